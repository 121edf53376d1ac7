"""A run: what encoders and torque sensors said while the robot moved."""

from __future__ import annotations

import os
from collections.abc import Hashable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from pa10d.checks import Known, check_recording
from pa10d.common.errors import UserError
from pa10d.face.robot import Robot
from pa10d.face.values import Array, ByContent, Fixed, bits, frozen
from pa10d.measurement.believable import EXPECTED, believable, refuse_vanishing
from pa10d.measurement.recording import Recording
from pa10d.readers import Part, read_recording
from pa10d.services.runs import stated_in
from pa10d.services.soundness import unsound
from pa10d.store.channels import Samples
from pa10d.store.equal_steps import equal_steps

FEWEST = 100  # samples


class Run(ByContent):
    """One recording, at equal steps; all arrays are read-only.

    time         (N,)   s; irregular stamps are resampled
    q            (N, n) rad (m where a joint slides)
    tau          (N, n) N·m (N), measured at the joint side
    dq           (N, n) rad/s as the robot reported it, or None: then q is differentiated
    temperature  (N, n) °C, or None
    extra        name -> (N,): further channels, kept and never needed
    remarks      what a user should know of it before fitting
    """

    def __init__(
        self,
        time: ArrayLike,
        q: ArrayLike,
        tau: ArrayLike,
        dq: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
        name: str = "run",
        extra: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        t = _stamps(time)
        given = _joint_columns(len(t), {"q": q, "tau": tau, "dq": dq, "temperature": temperature})
        samples = Samples(
            np.zeros(len(t), np.int64), given["q"], given["tau"], given.get("dq"),
            temperature=given.get("temperature"), extra=_channels(extra or {}, len(t)),
        )  # fmt: skip
        refuse_vanishing(name, samples.tau)
        timing, even = equal_steps(t, samples)
        self.name, self._unmeasured = name, timing.unmeasured
        self.time = frozen(timing.grid)
        self.q, self.tau = frozen(even.q), frozen(even.tau)
        self.dq = None if even.dq is None else frozen(even.dq)
        self.temperature = None if even.temperature is None else frozen(even.temperature)
        self.remarks: tuple[str, ...] = ()
        self.extra = Fixed({k: frozen(v) for k, v in even.extra.items()})

    @property
    def recording(self) -> Recording:
        """The same for the science underneath."""
        recording = Recording(
            self.name, self.time, self.q, self.tau, self.dq, self.temperature, self.extra
        )
        return recording.without(self._unmeasured) if self._unmeasured else recording

    @property
    def rate(self) -> float:
        """Samples per second."""
        return self.recording.rate

    @property
    def content(self) -> Hashable:
        arrays = (self.time, self.q, self.tau, self.dq, self.temperature)
        extra = tuple((name, bits(values)) for name, values in sorted(self.extra.items()))
        return self.name, self._unmeasured, tuple(map(bits, arrays)), extra

    def __len__(self) -> int:
        return len(self.time)

    def _page(self) -> str:
        from pa10d.report.notebook import run_page

        return run_page(self.recording, self.remarks)

    def __repr__(self) -> str:
        seconds = float(self.time[-1] - self.time[0])
        joints = self.q.shape[1]
        return f"<Run {self.name}: {seconds:.4g} s at {self.rate:.6g} Hz, {joints} joints>"


def load_run(
    path: str | os.PathLike[str],
    robot: Robot,
    map: Mapping[str, str] | None = None,
    name: str | None = None,
    force: bool = False,
    topic: str | None = None,
    episode: int | None = None,
) -> Run:
    """A recording of ``robot`` from a file that ``pa10d run import`` reads.

    map: column or topic, with its unit, -> field: ``{"t[ms]": "time", "joint_{n}_pos[deg]": "q"}``
    force: also where a fit to it would be wrong (degrees, another arm …), which else is refused
    topic: of a bag, and episode: of a LeRobot data set, where not the one that is taken else
    """
    file = Path(path)
    mapping = [f"{column}={field}" for column, field in (map or {}).items()]
    found = read_recording(file, robot.profile, robot.tree, mapping, part=Part(topic, episode))
    samples = found.samples
    run = Run(
        found.timing.grid, samples.q, samples.tau, samples.dq, samples.temperature,
        name or _stem(file), samples.extra,
    )  # fmt: skip
    vars(run)["_unmeasured"] = found.timing.unmeasured  # before anybody else has it
    known = Known(found.wraps, stated_in(found, robot.tree.n))
    findings = check_recording(run.recording, found.timing, robot.tree, delay=False, known=known)
    errors = [finding for finding in findings if finding.severity == "error"]
    if errors and not force:
        raise unsound(str(file), errors)
    vars(run)["remarks"] = (
        *found.header_warnings,
        *found.timing_warnings,
        *(str(finding) for finding in findings),
    )
    return run


def _stem(file: Path) -> str:
    return file.name.split(".")[0] or "run"


def _channels(extra: Mapping[str, ArrayLike], length: int) -> dict[str, Array]:
    out = {}
    for name, values in extra.items():
        out[name] = np.asarray(values, dtype=np.float64)
        if out[name].shape != (length,):
            raise UserError(f"extra {name!r}: found {out[name].shape}, expected ({length},)")
    return out


def _stamps(time: ArrayLike) -> Array:
    t = np.asarray(time, dtype=np.float64)
    if t.ndim != 1 or len(t) < FEWEST:
        raise UserError(f"time: found shape {t.shape}, expected (N,) with at least {FEWEST} stamps")
    if not np.isfinite(t).all() or (np.diff(t) < 0).any():
        raise UserError("time: expected finite stamps in s that never fall")
    return t


def _joint_columns(length: int, columns: Mapping[str, ArrayLike | None]) -> dict[str, Array]:
    """Those that were given, as (length, n) each."""
    out: dict[str, Array] = {}
    for name, values in columns.items():
        if values is None:
            continue
        array = np.asarray(values, dtype=np.float64)
        array = array[:, None] if array.ndim == 1 else array
        joints = next(iter(out.values())).shape[1] if out else array.shape[-1]
        if array.shape != (length, joints):
            expected = f"({length}, {joints})"
            raise UserError(f"{name}: found shape {array.shape}, expected {expected}")
        if name in ("q", "tau") and not believable(array).all():
            row, joint = np.argwhere(~believable(array))[0]
            raise UserError(
                f"{name}: joint {joint + 1} is {array[row, joint]} in sample {row}, "
                f"expected {EXPECTED}"
            )
        out[name] = array
    return out
