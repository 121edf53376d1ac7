"""Gains into a profile as a new version of it, and out of it again.

Versions are those of the profile's tuning: a shipped profile gets a copy in the data folder, which
every command takes from then on, and ``pa10d profile versions`` lists the change.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.common.yamlfile import read_yaml
from pa10d.profile import load_profile
from pa10d.services.profile_file import rewritten
from pa10d.services.tuning.edit import editable
from pa10d.services.tuning.versions import (
    coming,
    digest,
    folder_of,
    own_profile,
    standing,
    take_back,
    versions_in,
    write_version,
)
from pa10d.services.weighing.archive import Weighings
from pa10d.services.weighing.state import Applied, Weighing
from pa10d.services.weighing.told import ChangedProfile
from pa10d.services.weighing.work import status
from pa10d.store.folders import locked

KEY = "torque_gain"
FAR = 2.0  # times, or part: no motor lies so far from its nameplate, a wrong weight does


def apply_gains(data: str, weighing: str, joints: Sequence[int] = ()) -> ChangedProfile:
    """Write the gains into the weighing's profile.

    joints: from 1; without: all that are determined and not left open by friction with the load.
    """
    archive = Weighings(data)
    state = archive.find(weighing)
    if state.applied is not None:
        raise UserError(f"{state.name}: applied already; expected 'undo' before")
    gains = _gains(state, joints)
    path = own_profile(data, state.profile)
    found = load_profile(path)
    if found.drives is None or state.scale is None or len(found.drives) != len(state.scale):
        lines = state.result.joints if state.result else ()
        maps = " ".join(line.map for line in lines if line.joint in gains)
        raise UserError(f"{path}: drives: none to put right; expected {maps} with each import")
    wanted = {j: float(f"{state.scale[j - 1] * gain:.5g}") for j, gain in gains.items()}
    folder = folder_of(data, path)
    with locked(folder):
        file = editable(data, path)
        drives = [dict(drive) for drive in file.data["drives"]]
        for j, gain in wanted.items():
            drives[j - 1][KEY] = gain
        changed = {**file.data, "drives": drives}
        said = [f"torque gain of joint {j}: {gain:g} ({state.name})" for j, gain in wanted.items()]
        text = rewritten(file, changed)
        state.applied = Applied(
            profile=str(file.path), version=coming(folder) - 1,
            gains={str(j): gain for j, gain in wanted.items()},
            when=datetime.now(UTC).isoformat(timespec="milliseconds"),
        )  # fmt: skip
        archive.save(state)  # before the profile: a full disk then refuses all of it
        try:
            version = write_version(folder, said, file.path, file.text, text, changed)
        except BaseException:
            state.applied = None
            archive.save(state)
            raise
    return _told(state, file.path, version.made)


def undo_gains(data: str, weighing: str) -> ChangedProfile:
    """The profile as it was before; refused where somebody has changed it since."""
    archive = Weighings(data)
    state = archive.find(weighing)
    if state.applied is None:
        raise UserError(f"{state.name}: nothing was applied; expected 'apply' before")
    path, number = Path(state.applied.profile), state.applied.version
    folder = folder_of(data, path)
    with locked(folder):
        load_profile(path)  # a weighing from elsewhere may name any file
        made = next((one for one in versions_in(folder, path) if one.number == number), None)
        if made is None or digest(read_yaml(path).text) != made.after:
            listed = ", ".join(f"drive {j}: {g:g}" for j, g in state.applied.gains.items())
            raise UserError(
                f"{path}: changed since the gains were written; expected later changes to be "
                f"undone first, or {KEY} to be put back by hand ({listed})"
            )
        take_back(folder, made, path)
    state.applied = None
    archive.save(state)
    return _told(state, path, standing(folder, path))


def _told(state: Weighing, path: Path, version: int) -> ChangedProfile:
    return ChangedProfile(**vars(status(state)), file=str(path), version=version)


def _gains(state: Weighing, joints: Sequence[int]) -> dict[int, float]:
    lines = state.result.joints if state.result else ()
    told = {line.joint: line.gain for line in lines if line.gain is not None}
    if not told:
        raise UserError(f"{state.name}: no gain is determined; expected a recording with a weight")
    for joint in joints:
        if joint not in told:
            known = ", ".join(map(str, told))
            raise UserError(f"joint {joint}: its gain is not determined; expected some of {known}")
    open_ = {line.joint for line in lines if line.left_open}
    firm = list(joints) or [j for j in told if j not in open_]
    if not firm:
        raise UserError(
            f"{state.name}: friction with the load leaves every gain open; expected the joints to "
            "apply all the same (--joints)"
        )
    for joint in firm:
        _refuse_unlikely(joint, told[joint])
    return {joint: told[joint] for joint in firm}


def _refuse_unlikely(joint: int, gain: float) -> None:
    """The arm would move by torques of which every one is wrong by as much."""
    found = f"joint {joint}: found a gain of {gain:.3g}"
    if gain <= 0:
        raise UserError(
            f"{found}: its torque counts the other way; expected a weight that is where it was "
            "said to be"
        )
    if not 1.0 / FAR <= gain <= FAR:
        raise UserError(
            f"{found}: the weight was not what was said, or the profile is wrong about the drive; "
            f"expected {1.0 / FAR:g} to {FAR:g}, or rated_torque put right in the profile"
        )
