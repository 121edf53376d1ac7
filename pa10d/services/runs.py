"""Runs: bring them in, look at them, check them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pa10d.checks import (
    OF_ONE_TORQUE,
    CheckFinding,
    Known,
    beyond_limits,
    check_commanded,
    check_recording,
    in_order,
)
from pa10d.common.errors import UserError
from pa10d.dynamics.robot import Robot
from pa10d.measurement.recording import Recording
from pa10d.profile import Profile
from pa10d.readers import WHOLE, Part, read_recording
from pa10d.services.kept_mapping import keep_mapping
from pa10d.services.mending import in_words_of
from pa10d.services.soundness import unsound
from pa10d.store import Channels, RunInfo, RunStore, Samples
from pa10d.store.channels import Array
from pa10d.store.column_guess import guessed, was_asked_for
from pa10d.store.column_mapping import names_an_angle
from pa10d.store.csv_import import CsvRecording
from pa10d.store.run_info import KeptFinding

OF_THE_FILE = frozenset(
    ("commanded", "jitter", "scattered_stamps", "missing_samples", "duplicate_stamps", "gaps")
)  # gone once stored
PACKED = (".tgz", ".gz", ".bz2", ".zst", ".xz", ".zip", ".tar")
KNOWN = (
    ".csv", ".txt", ".tsv", ".dat", ".mcap", ".db3", ".bag", ".parquet", ".feather", ".arrow",
    ".arrows", ".mat", ".h5", ".hdf5", ".npz", ".npy", ".blf", ".asc", ".log", ".trc", ".db",
    ".mf4",
)  # fmt: skip


@dataclass(frozen=True)
class Imported:
    """A new run, and what is to be known of it."""

    info: RunInfo
    header_warnings: list[str]
    findings: list[CheckFinding]
    kept: str = ""  # what became of the mapping
    another: str = ""  # how another recording of the same file is asked for


def import_run(
    store: RunStore,
    file: Path,
    profile: Profile,
    robot: Robot,
    *,
    name: str | None = None,
    mapping: Sequence[str] = (),
    replace: bool = False,
    check: bool = False,
    force: bool = False,
    progress: Callable[[float, str], None] = lambda share, words: None,
    part: Part = WHOLE,
) -> Imported:
    """Store a recording as a run; nothing is stored where the file is broken.

    check: look at all that can go wrong in a recording, and store none that a fit must not use
    (Unsound), unless forced. What the checks say stays with the run. part: of a file that holds
    several recordings; a run without a name is called by it, too."""
    found = read_recording(
        file, profile, robot, mapping, lambda s: progress(0.8 * s, "reading"), part
    )
    recording = _recording(found, name or file.name)
    checked = findings_of(found, recording.name, robot, profile, delay=check)
    findings = [in_own_words(finding, found, robot.n) for finding in checked]
    errors = [finding for finding in findings if finding.severity == "error"]
    if check and errors and not force:
        raise unsound(file.name, errors, _also_wrong(findings))
    limits = [f"{file.name}: {finding.sentence}" for finding in beyond_limits(recording, robot)]
    said = [*found.header_warnings, *found.timing_warnings, *limits]
    with store.building(
        name,
        _stem(file) if part.episode is None else f"{_stem(file)}-{part.episode}",
        _channels(found.samples, robot),
        profile,
        source=file.name,
        warnings=tuple(_without_folder(file, text) for text in said),
        findings=tuple(_kept(f) for f in findings if f.severity != "info"),
        unit_given=tuple(sorted(stated_in(found, robot.n))),
        excluded=found.timing.unmeasured,
        replace=replace,
        time_zero_ns=found.time_zero_ns,
    ) as writer:
        writer.append(found.samples)
    kept = keep_mapping(store.folder.parent, profile, mapping) if mapping else ""
    return Imported(writer.info, found.header_warnings, findings, kept, found.another)


def _also_wrong(findings: Sequence[CheckFinding]) -> list[CheckFinding]:
    """Warnings that no error is the cause of: all, where each error is one torque's own."""
    errors = (finding for finding in findings if finding.severity == "error")
    if all(error.code in OF_ONE_TORQUE for error in errors):
        return [finding for finding in findings if finding.severity == "warning"]
    return []


def check_run(store: RunStore, run: str, robot: Robot, profile: Profile) -> list[CheckFinding]:
    """The checks of an import, for a run that is stored, with what the import knew: the unit that
    positions were given, and what only the file could tell. What it said in words of the file stays
    so. What was recorded here is in radians."""
    info = store.find(run)
    recording, timing = store.read(info).recording(info.name)
    recording = recording.without(info.excluded) if info.excluded else recording
    if recording.joints != robot.n:
        raise UserError(
            f"run {info.name!r}: found {recording.joints} joints, expected the {robot.n} of "
            f"{robot.name}"
        )
    told = {(one["code"], one["sentence"]): one["advice"] for one in info.findings or ()}
    stated = frozenset(info.unit_given if info.source else range(robot.n))
    found = [
        dataclasses.replace(finding, advice=told.get(_key(finding), finding.advice))
        for finding in check_recording(
            recording, timing, robot, known=Known(None, stated, _ratios(profile))
        )
    ]
    again = {finding.code for finding in found}
    of_file = [one for one in info.findings or () if one["code"] in OF_THE_FILE - again]
    return in_order([*found, *(CheckFinding(**one) for one in of_file)])


def _key(finding: CheckFinding) -> tuple[str, str]:
    return finding.code, finding.sentence


def findings_of(
    found: CsvRecording, name: str, robot: Robot, profile: Profile, *, delay: bool
) -> list[CheckFinding]:
    """What to know of a recording that was read, gravest first, with fields for columns."""
    recording = _recording(found, name)
    by_name = _demanded(found.called)
    wanted = _wanted(found.samples, robot)
    by_law = [] if wanted is None else check_commanded(recording, wanted, robot.joint_names)
    told = by_name or list(by_law)
    known = Known(found.wraps, stated_in(found, robot.n), _ratios(profile))
    checked = check_recording(recording, found.timing, robot, delay=delay, known=known)
    return in_order([*told, *checked])


def _ratios(profile: Profile) -> list[float] | None:
    return [drive.gear_ratio for drive in profile.drives] if profile.drives else None


def stated_in(found: CsvRecording, n: int) -> frozenset[int]:
    """Joints, from 0, whose positions a mapping gives the unit of an angle."""
    units = {j: found.said.get(found.called.get(f"q{j + 1}", ""), "") for j in range(n)}
    return frozenset(j for j, unit in units.items() if names_an_angle(unit))


def in_own_words(finding: CheckFinding, found: CsvRecording, n: int) -> CheckFinding:
    """Its ``--map`` options with the columns of the file that was read."""
    return in_words_of(finding, found.called, found.said, n)


def _wanted(samples: Samples, robot: Robot) -> Array | None:
    """(N, n) the positions that were asked for, where further channels are called like them."""
    choices = guessed(list(samples.extra), robot.n, robot.joint_names, demanded=True)
    columns = {choice.field: samples.extra[choice.column] for choice in choices}
    fields = [f"q{j}" for j in range(1, robot.n + 1)]
    if not all(field in columns for field in fields):
        return None
    return np.stack([columns[field] for field in fields], axis=1)


def _demanded(called: Mapping[str, str]) -> list[CheckFinding]:
    """Torques from columns whose names say that they were asked for, not measured."""
    named = [c for field, c in called.items() if field.startswith("tau") and was_asked_for(c)]
    if not named:
        return []
    return [
        CheckFinding(
            "warning",
            "commanded",
            f"{', '.join(named)}: a torque that was asked for, by its name, not a measured one",
            "map the measured torque or the motor current; what the drive's own loop adds is "
            "missing otherwise",
        )
    ]


def _without_folder(file: Path, text: str) -> str:
    """A run may outlive the folder that its file lay in."""
    return text.replace(f"{file.parent}/", "")


def _kept(finding: CheckFinding) -> KeptFinding:
    return KeptFinding(**finding.document())  # type: ignore[typeddict-item]


def _stem(file: Path) -> str:
    name = file.name
    for ending in (*PACKED, *KNOWN):
        name = name[: -len(ending)] if name.lower().endswith(ending) else name
    return name.strip().lstrip(".-") or "run"


def _recording(found: CsvRecording, name: str) -> Recording:
    samples = found.samples
    recording = Recording(name, found.timing.grid, samples.q, samples.tau, samples.dq)
    return recording.without(found.timing.unmeasured) if found.timing.gaps else recording


def _channels(samples: Samples, robot: Robot) -> Channels:
    return Channels(
        joints=robot.joint_names,
        velocity=samples.dq is not None,
        temperature=samples.temperature is not None,
        current=samples.current is not None,
        extra=tuple(samples.extra),
    )
