"""The first motion of an arm: its joints are measured part by part, and gains set from each."""

from __future__ import annotations

import contextlib
import logging
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.control.faults import Fault
from pa10d.control.gains import PidGains
from pa10d.control.known_joints import KnownJoints, MeasuredJoints
from pa10d.daemon.jobs.jobs import Progress, part
from pa10d.daemon.motions.experiment import Experiment
from pa10d.daemon.motions.power_off import leave_unpowered
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.experiments.measured_joints import lowered
from pa10d.experiments.outcome import Outcome
from pa10d.experiments.request import MotionRequest

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon

Array = NDArray[np.float64]

SHARES = {"friction": 0.2, "sliding": 0.1, "response": 0.5, "poses": 0.2}  # of the time
# of one joint, with calmer gains where it swings, firmer ones where it falls behind: what it weighs
# may be told before, and by halves a servo gets to its firmest in four steps
TRIES = {"oscillation": 5, "following_error": 8}
SKIPPED = "measured on {}, and neither profile nor URDF has changed since: nothing to do"

AGAIN = "has shown how it is to be held: it is tried again by itself"
SLOWED = "joint {} fell behind: strokes at {:g} of their speed, and it is tried again"

log = logging.getLogger("pa10d.experiment")


class FirstMotion:
    """Carried out as an experiment is; the arm is left as it was found, with its new gains."""

    def __init__(self, daemon: Daemon, request: MotionRequest, report: Progress) -> None:
        self._daemon, self._robot = daemon, daemon.robot
        self._request, self._report = request, report
        self.moved = False
        self.result = Outcome(request.kind)
        self._before: PidGains | None = None

    async def carry_out(self) -> Outcome:
        """Measure, keep, and use from now on; skipped where that was done."""
        kept = self._daemon.measured_joints()
        if kept is not None and not self._request.parameters.get("again"):
            self.result.joints = kept.document()
            said = kept.known.sentences
            self.result.recommendation = [SKIPPED.format(kept.measured), *said]
            return self.result
        was_unpowered = not self._robot.moving
        try:
            return await self._measure()
        except BaseException:
            await self._take_back()
            raise
        finally:
            if was_unpowered and self._robot.moving:
                await leave_unpowered(self._robot, self.result.notes)

    async def _measure(self) -> Outcome:
        at = self._robot.pose().tolist()
        begin = await self._ask("joints:parts_to_run", parameters=self._request.parameters, at=at)
        self._before = PidGains.from_document(begin["before"])
        known = KnownJoints.from_document(begin["begin"])
        self.result.tuned += begin["notes"]
        runs: dict[str, str] = {}
        before = 0.0
        for name in begin["parts"]:
            share, joints = SHARES[name], self._request.parameters.get("joints")
            if name == "sliding":
                joints = await self._ask("joints:soft_joints", known=known.document(), of=joints)
                if not joints:
                    before += share
                    continue
            inner = part(self._report, before, before + share)
            runs[name], known = await self._run(name, joints, known, inner)
            before += share
            told = await self._ask("joints:learn", runs=runs, known=known.document())
            known = KnownJoints.from_document(told)
        made = await self._ask(
            "joints:keep_joints", runs=list(runs.values()), known=known.document()
        )
        kept = MeasuredJoints.from_document(made)
        await self._robot.use_gains(kept.known.gains, keep=True, felt=kept.known.felt)
        self._robot.joints = kept
        self.result.joints, self.result.recommendation = made, list(kept.known.sentences)
        usual = self._daemon.profile.control.bandwidth_hz is None
        if (slower := lowered(kept.known.asked, kept.known.bandwidth.tolist(), usual)) is not None:
            (self.result.tuned if usual else self.result.notes).append(slower)
        return self.result

    async def _run(
        self, name: str, joints: list[int] | None, known: KnownJoints, report: Progress
    ) -> tuple[str, KnownJoints]:
        """One part, of these joints (from 1, None: all) → its run, and what is known then: gains
        get calmer where the arm swings."""
        parameters = {**self._request.parameters, "part": name}
        if joints is not None:
            parameters["joints"] = joints
        tried: Counter[int | None] = Counter()
        while True:
            await self._robot.use_gains(known.gains, keep=False, felt=known.felt)
            request = replace(
                self._request, parameters=parameters, controller="pid", model=None, name=None
            )
            experiment = Experiment(self._daemon, request, report, known.figures)
            try:
                found = await experiment.carry_out()
            except UserError as error:
                self.result.notes += experiment.falls
                self._robot.stops.refuse()
                fault = self._robot.fault
                if fault is None or fault.kind not in TRIES:
                    raise
                tried[fault.joint] += 1
                went = experiment.went if fault.kind == "following_error" else None
                again = tried[fault.joint] < TRIES[fault.kind]
                calmer = await self._calmer(known, fault, went, name) if again else None
                if calmer is not None:
                    known = calmer
                elif (speed := await self._slower(name, known, fault, parameters)) is not None:
                    parameters["speed"] = speed
                    self.result.notes.append(SLOWED.format(fault.joint, speed))
                else:
                    told = {"known": known.document(), "fault": fault.document()}
                    way = await self._ask("ways_out:way_out", **told)
                    raise UserError(f"joint {fault.joint}: {fault.cause}; {way}") from error
                await self._robot.reset()
                continue
            self.moved = True
            self.result.notes += experiment.falls
            self.result.seconds = (self.result.seconds or 0.0) + (found.seconds or 0.0)
            self.result.recorded += found.recorded
            self.result.runs += found.runs
            return found.runs[0], known

    async def _calmer(
        self, known: KnownJoints, fault: Fault, went: tuple[Array, Array] | None, name: str
    ) -> KnownJoints | None:
        """What is known after a joint swung or fell behind; None where no gains would help. went:
        rad and N·m (N, n), until then; name: of the part that it ended."""
        seen = None if went is None else [values.tolist() for values in went]
        told = {"known": known.document(), "fault": fault.document(), "went": seen, "part": name}
        calmer = await self._ask("joints:calmer", **told)
        if calmer is None:
            return None
        self.result.tuned.append(calmer["note"])
        log.warning("joint %s %s", fault.joint, AGAIN)
        return KnownJoints.from_document(calmer)

    async def _slower(
        self, name: str, known: KnownJoints, fault: Fault, parameters: Mapping[str, Any]
    ) -> float | None:
        """Share of the strokes' speed at which it is tried again; None where that is no help."""
        if fault.kind != "following_error":
            return None
        speed = float(parameters.get("speed", 1.0))
        told = {"known": known.document(), "fault": fault.document()}
        less: float | None = await self._ask("joints:slower", part=name, speed=speed, **told)
        return less

    async def _ask(self, what: str, **more: Any) -> Any:
        return await self._daemon.workers.run(
            f"pa10d.services.{what}",
            lambda *_: None,
            data=str(self._daemon.data),
            profile=str(self._daemon.profile.path),
            **more,
        )

    async def _take_back(self) -> None:
        """The gains that there were before; an arm that is held gets them without a step."""
        with contextlib.suppress(CommandRefused):
            if self._before is not None:
                await self._robot.use_gains(self._before, keep=False)
