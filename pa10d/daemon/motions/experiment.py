"""An experiment from request to recommendation, as a job: plan, check, enable, run, analyse."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import NotNow, Stopped, UserError
from pa10d.common.jsonable import JsonObject
from pa10d.control.faults import WRONG
from pa10d.control.joint_figures import JointFigures
from pa10d.control.known_joints import MeasuredJoints
from pa10d.control.laws import Law
from pa10d.control.states import ArmState
from pa10d.daemon.jobs.jobs import Progress, part
from pa10d.daemon.motions.numbers import NUMBERS, SHIFTED, STOPPED
from pa10d.daemon.motions.power_off import leave_unpowered
from pa10d.daemon.motions.way_back import bring_inside
from pa10d.daemon.robot.readiness import readiness
from pa10d.daemon.robot.refusals import CommandRefused
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.experiments.checks import Check
from pa10d.experiments.outcome import Outcome, RecordedRun
from pa10d.experiments.pacing import REMEDY
from pa10d.experiments.prepared import CarriedBy, PlannedMotion, Prepared, wrong_in
from pa10d.experiments.request import MotionRequest
from pa10d.experiments.slower import AS_ASKED, Slower, slower_after

if TYPE_CHECKING:
    from pa10d.daemon.daemon import Daemon
    from pa10d.identify.scale import Body

Array = NDArray[np.float64]

LOOK_EVERY = 0.1  # s
TRIES = 3  # with calmer gains, or slower, each
FALLS = 5  # that may tell what holds one joint: the first three with all others
WEIGHINGS = 3  # by smaller motions, each of which lets the next be larger
WENT = 20.0  # s before a fault that are looked at
SHORT = 0.5  # s in which a run ends as a rule
CLOSE_RUN = 10.0  # s for the recorder to finish a run
PASSING = ("disk",)  # subjects of what a plan is checked for that are no lack of its own
PLANNED, CHECKED, MOVED = 0.1, 0.15, 0.9  # progress after each step

log = logging.getLogger("pa10d.experiment")


def carried_by(
    robot: RobotProcess,
    request: MotionRequest,
    figures: JointFigures | None = None,
    slower: Slower | None = None,
) -> CarriedBy:
    """What this motion will be followed with; figures: see ``Experiment``."""
    asked = request.controller
    law: Law = asked or robot.law.name
    measured = robot.joints if law == "pid" and not request.is_first else None
    return CarriedBy(
        law,
        robot.law.model if asked is None else request.model,
        _told(measured) if figures is None else {"figures": figures.document()},
        asked is None or figures is not None,
        None if slower is None else vars(slower),
    )


def _told(measured: MeasuredJoints | None) -> JsonObject | None:
    return None if measured is None else measured.document()


async def planned(
    daemon: Daemon, request: MotionRequest, where: Mapping[str, str], report: Progress
) -> JsonObject:
    """Make the plan, in its folder → what there is to know of it. where: profile, folder."""
    told: JsonObject = await daemon.workers.run(
        "pa10d.services.experiments:make_plan", report, data=str(daemon.data),
        kind=request.kind, parameters=request.parameters, **where,
    )  # fmt: skip
    return told


async def prepare(
    daemon: Daemon, where: Mapping[str, str], carried: CarriedBy, weight: Body | None = None
) -> Prepared:
    """The planned motion from where the arm stands, with its pre-check; nothing moves."""
    told = await daemon.workers.run(
        "pa10d.services.prepared_motion:prepare_motion", lambda *_: None, data=str(daemon.data),
        start=daemon.robot.pose().tolist(), **vars(carried), **where,
        weight=None if weight is None else weight.text,
    )  # fmt: skip
    return Prepared.from_document(told)


class WeightsInDoubt(UserError):
    """What bars a motion is what the arm may weigh; ``share`` of it would tell."""

    def __init__(self, checks: Sequence[Check], share: float) -> None:
        said = [one.sentence for one in checks if one.subject == "tracking"]
        super().__init__(f"the pre-check refused the motion: {'; '.join(said)}, and was; {REMEDY}")
        self.share = share


class Experiment:
    """One request carried out; ``result`` grows as it goes; ``moved``: past the pre-check,
    powered or about to be."""

    def __init__(
        self,
        daemon: Daemon,
        request: MotionRequest,
        report: Progress,
        figures: JointFigures | None = None,
        weight: Body | None = None,
    ) -> None:
        """figures: of the joints, where they are not those that the robot keeps; weight: one
        that hangs at the last joint."""
        self._figures, self._weight = figures, weight
        self._slower: Slower | None = None
        self._daemon, self._robot = daemon, daemon.robot
        self._request, self._report = request, report
        self._folder = daemon.runtime / f"experiment-{next(NUMBERS)}"
        self.moved = False
        self._stood: Array | None = None  # rad, before it was enabled last
        self._began = 0  # of the records, where the last motion began
        self.falls: list[str] = []  # of its notes those of joints that were not held at first
        self.result = Outcome(request.kind)

    async def carry_out(self) -> Outcome:
        """To the end; the arm is left as it was found. An arm that was measured is tried with
        calmer gains where it swings, and slower where it was predicted to follow and did not."""
        tries, fell, weighings = 1, Counter[int](), 0
        while True:
            try:
                found = await self._once()
                if self._small is None:
                    return found
                await self._weigh(found.runs, self._small)
            except Stopped:
                raise
            except WeightsInDoubt as doubt:
                if (weighings := weighings + 1) > WEIGHINGS or self._robot.joints is None:
                    raise
                self._slower = Slower(small=doubt.share)
            except UserError:
                self._robot.stops.refuse()
                if await self._weighed(fell):
                    continue
                if tries == TRIES or not (await self._calmed() or await self._slowed()):
                    raise
                tries += 1

    @property
    def went(self) -> tuple[Array, Array]:
        """rad and N·m sent, (N, n), of what a fault has ended: the way to its start as well, and
        the stop, as far as it was the servo's."""
        ring = self._robot.ring
        rows, _ = ring.read(max(self._began, ring.written - round(WENT / ring.period)))
        q, torque, state = (ring.layout.get(rows, key) for key in ("q", "torque", "state"))
        ours = np.isin(state, (ArmState.RUNNING, ArmState.STOPPING)) & torque.any(axis=1)
        return q[ours], torque[ours]

    async def _weighed(self, fell: Counter[int]) -> bool:
        """Whether a joint was not held, and how it fell told what holds it: then the next enabling
        begins with that. Or it told nothing, and each brake opens alone the next time; or it left
        its place as another one's brake opened alone: then all open together. It may fall as far
        each time: few are allowed. fell: how often each told, from 1, and how often brakes did not
        open alone (0) or are going to (-1)."""
        fault = self._robot.fault
        if fault is None or not (fault.weighed or fault.opens_otherwise):
            return False
        which = fault.weighed or -int(fault.alone_next)
        fell[which] += 1
        if fault.opens_otherwise and fell[which] > 1:
            return False
        if fault.weighed and fell[fault.weighed] > FALLS:
            raise UserError(
                f"{fault.seen}; joint {fault.weighed} was not held {FALLS + 1} times, and is not "
                f"tried again by itself: {WRONG}"
            )
        if (joint := self._falls_out(self._robot.pose())) is not None:
            raise UserError(
                f"{fault.seen}; it is not tried again by itself, for joint {joint} came near its "
                "position limit as it fell and would go over it: move it away from there, its "
                f"brake released by hand; {WRONG}"
            )
        if fault.weighed:
            log.warning(
                "joint %s fell, which told what may hold joint %d (time %d, of %d at most): the "
                "arm rests, and is enabled again by itself",
                fault.joint, fault.weighed, fell[fault.weighed], FALLS,
            )  # fmt: skip
            note = f"joint {fault.joint} {fault.cause}, and it is tried again."
        elif fault.alone_next:
            log.warning(
                "joint %s fell, which did not tell what holds it: the arm rests, and is enabled "
                "again by itself, each brake opening alone first", fault.joint,
            )  # fmt: skip
            note = f"{fault.seen}: it is tried again with each brake opening alone first."
        else:
            log.warning(
                "joint %s came out of its closed brake: the arm rests, and is enabled again by "
                "itself, all brakes opening together", fault.joint,
            )  # fmt: skip
            note = f"{fault.seen}: it is tried again with all brakes opening together."
        self.falls.append(note)
        self.result.notes.append(note)
        await self._robot.reset()
        self._begin_again()
        return True

    def _falls_out(self, here: Array) -> int | None:
        """A joint (from 1) that another fall as far as its last would take over its limit."""
        if self._stood is None:
            return None
        there, robot = 2.0 * here - self._stood, self._robot.robot
        gone = np.flatnonzero((there < robot.lower) | (there > robot.upper))
        return int(gone[0]) + 1 if len(gone) else None

    @property
    def _small(self) -> float | None:
        """Which share of the motion is run, to weigh the arm; None: all of it, as it was asked."""
        small = 1.0 if self._slower is None else self._slower.small
        return small if small < 1.0 else None

    async def _weigh(self, runs: list[str], small: float) -> None:
        """A smaller motion has ended well: the arm weighs what that has shown from now on."""
        kept = await self._daemon.workers.run(
            "pa10d.services.joints:keep_felt",
            lambda *_: None,
            data=str(self._daemon.data),
            profile=str(self._daemon.profile.path),
            runs=runs,
        )
        self.result.notes.append(
            f"what the arm weighs was too much in doubt: {small:.0%} of the motion was run before, "
            "and told"
        )
        measured = MeasuredJoints.from_document(kept)
        told = self._robot.joints
        if measured.known.lean and (told is None or not told.known.lean):
            self.result.notes.append(measured.known.lean)
        await self._robot.use_gains(measured.known.gains, keep=True, felt=measured.known.felt)
        self._robot.joints, self._slower = measured, None
        self._begin_again()

    async def _calmed(self) -> bool:
        """Whether the arm swung, and has got calmer gains; the fault is left for that."""
        fault, robot = self._robot.fault, self._robot
        if fault is None or fault.kind != "oscillation" or robot.joints is None:
            return False
        kept = await self._daemon.workers.run(
            "pa10d.services.joints:keep_calmer",
            lambda *_: None,
            data=str(self._daemon.data),
            profile=str(self._daemon.profile.path),
            fault=fault.document(),
        )
        if kept is None:
            return False
        self.result.tuned.append(kept["note"])
        log.warning("joint %s swung: it is held more calmly, and tried again", fault.joint)
        measured = MeasuredJoints.from_document(kept)
        await robot.reset()
        await robot.use_gains(measured.known.gains, keep=True, felt=measured.known.felt)
        robot.joints = measured
        self._begin_again()
        return True

    async def _slowed(self) -> bool:
        """Whether a joint left its path though nothing is in its way, and the next try is slower;
        the fault is left for that."""
        fault, joints = self._robot.fault, self._robot.joints
        law = self._request.controller or self._robot.law.name
        if fault is None or joints is None or self._figures is not None or law != "pid":
            return False
        ran = 1.0 if self.result.adjusted is None else float(self.result.adjusted["pace"])
        slower = slower_after(fault, joints.known.figures, ran, self._slower or AS_ASKED)
        if slower is None:
            return False
        self._slower = slower
        self.result.notes.append(
            f"{slower.why}: it is tried again at 1/{slower.pace:g} of its speed"
        )
        await self._robot.reset()
        self._begin_again()
        return True

    def _begin_again(self) -> None:
        self.result.runs, self.result.recorded = [], []
        self._request = replace(self._request, replace=self._request.name is not None)

    async def _once(self) -> Outcome:
        was_unpowered = not self._robot.moving
        self._folder.mkdir(exist_ok=True)
        try:
            if self._request.recover and self._robot.outside():
                self._report(0.0, "bringing the arm back inside")
                await bring_inside(self._daemon)
            await self._plan()
            prepared = await self._prepare()
            self.moved = True
            prepared = await self._power_up(prepared)
            await self._use_controller(prepared)
            await self._move(prepared)
            await self._analyse()
            if prepared.sentence is not None and self._small is None:
                self.result.notes.append(prepared.sentence)
        except CommandRefused as refusal:  # the arm's state is another in a while
            raise NotNow(str(refusal)) from refusal
        finally:
            await self._leave(was_unpowered)
        return self.result

    async def _plan(self) -> None:
        self._report(0.0, "planning")
        told = part(self._report, 0.0, PLANNED)
        self.result.plan = await self._robot.stops.unless(
            planned(self._daemon, self._request, self._where, told)
        )

    @property
    def _where(self) -> dict[str, str]:
        return {"profile": str(self._daemon.profile.path), "folder": str(self._folder)}

    async def _prepare(self) -> Prepared:
        """The way to the plan and the pre-check of both; nothing has moved yet."""
        self._report(PLANNED, "checking limits, torque and collisions")
        carried = carried_by(self._robot, self._request, self._figures, self._slower)
        found = await self._robot.stops.unless(
            prepare(self._daemon, self._where, carried, self._weight)
        )
        self.result.checks = [*readiness(self._robot), *found.checks]
        if wrong := wrong_in(self.result.checks):
            own = wrong_in([one for one in found.checks if one.subject not in PASSING])
            kind = UserError if own else NotNow
            raise kind("the pre-check refused the motion: " + "; ".join(wrong[:3]))
        if found.weighs is not None:
            raise WeightsInDoubt(found.checks, found.weighs)
        return found

    async def _power_up(self, prepared: Prepared) -> Prepared:
        if self._robot.state == "inactive":
            self._report(CHECKED, "enabling the arm")
            self._stood = self._robot.pose()
            try:
                await self._robot.enable()
            except BaseException:
                self._robot.stop()  # it may be on its way to control, of which nothing is known yet
                raise
        state = await self._robot.until("holding", "fault", timeout=5.0)
        self._robot.stops.refuse()
        if state != "holding":
            raise UserError(f"the arm is {state}, expected holding{self._why()}")
        if np.abs(self._robot.pose() - prepared.start).max() > SHIFTED:
            return await self._prepare()
        return prepared

    async def _use_controller(self, prepared: Prepared) -> None:
        name = self._request.controller
        if name == "pid":
            await self._robot.law.use({"name": "pid"})
        elif name is not None:
            await self._robot.law.use({"name": name, "model": prepared.live}, self._request.model)

    async def _move(self, prepared: Prepared) -> None:
        self.result.adjusted, total = prepared.adjusted, prepared.seconds
        self.result.seconds, before = total, 0.0
        for k, motion in enumerate(prepared.motions):
            share = [CHECKED + (MOVED - CHECKED) * s / total
                     for s in (before, before + motion.seconds)]  # fmt: skip
            name = self._request.name
            if name is not None and len(prepared.motions) > 1:
                name = f"{name}-{k + 1}"
            await self._run(motion, name, part(self._report, *share))
            before += motion.seconds

    async def _run(self, motion: PlannedMotion, name: str | None, report: Progress) -> None:
        """One motion, recorded."""
        number, robot = next(NUMBERS), self._robot
        self._began = robot.ring.written
        announced = await robot.recorder.announce(
            motion=number, rows=motion.last, name=name,
            kind=self._request.kind, plan_file=motion.plan_file, tags=list(self._request.tags),
            replace=self._request.replace,
        )  # fmt: skip
        run = announced["run"]["id"]
        ended = robot.runs.expect(run)
        try:
            await robot.follow(motion.file, number, motion.first, motion.last, motion.weight)
            await self._follow(number, motion.rows, report)
            await self._finish_recording(ended)
        except BaseException:
            robot.stop()  # the motion may have begun, and nobody been told yet
            with contextlib.suppress(CommandRefused):
                if not ended.done():
                    await robot.recorder.withdraw()
            raise
        finally:
            robot.runs.forget(run)
        info = ended.result()
        self.result.runs.append(info["id"])
        told = (info[key] for key in ("id", "name", "status", "duration"))
        self.result.recorded.append(RecordedRun(*told))
        if info["status"] != "success":
            kind = Stopped if info["status"] == "stopped" else UserError
            raise kind(how_it_ended(info["name"], info["status"], info["reason"]))

    async def _follow(self, number: int, rows: int, report: Progress) -> None:
        """Until the motion is over, whatever ends it."""
        ring, get = self._robot.ring, self._robot.ring.layout.get
        while self._robot.state == "running":
            await asyncio.sleep(LOOK_EVERY)
            last = ring.last()
            if last is not None and get(last, "motion") == number:
                report(float(get(last, "row")) / rows, "moving")
        state = await self._robot.until("holding", "inactive", "fault", "offline", timeout=STOPPED)
        if state in ("fault", "offline"):
            fault = self._robot.fault  # it may be tried again; what to do is said where it is not
            log.warning("experiment ended while %s%s", state, f": {fault.seen}" if fault else "")

    async def _finish_recording(self, ended: asyncio.Future[JsonObject]) -> None:
        await asyncio.wait([ended], timeout=SHORT)
        if not ended.done() and await self._robot.recorder.withdraw():
            where = "stopped on the way to the start; nothing was recorded"
            raise UserError(f"{where}{self._why()}") if self._why() else Stopped(where)
        await asyncio.wait_for(asyncio.shield(ended), CLOSE_RUN)

    async def _analyse(self) -> None:
        self._report(MOVED, "analysing")
        found = await self._daemon.workers.run(
            "pa10d.services.experiments:analyse",
            part(self._report, MOVED, 1.0),
            data=str(self._daemon.data),
            profile=str(self._daemon.profile.path),
            kind=self._request.kind,
            runs=self.result.runs,
        )
        self.result.analysis = found["analysis"]
        self.result.recommendation = found["recommendation"]

    async def _leave(self, was_unpowered: bool) -> None:
        """At rest, and unpowered where it was so before; also when cancelled."""
        await asyncio.shield(self._come_to_rest(was_unpowered))
        with contextlib.suppress(OSError):  # how it ended is told, whatever is left lying there
            for file in self._folder.glob("*"):
                file.unlink(missing_ok=True)
            self._folder.rmdir()

    async def _come_to_rest(self, power_off: bool) -> None:
        robot = self._robot
        if robot.state in ("running", "stopping"):
            robot.stop()
            await robot.until("holding", "inactive", "fault", "offline", timeout=STOPPED)
        if power_off and robot.moving:  # one that still stops powers off once it rests
            await leave_unpowered(robot, self.result.notes)

    def _why(self) -> str:
        fault = self._robot.fault
        return f": {fault.sentence}" if fault else ""


def how_it_ended(run: str, status: str, reason: str) -> str:
    """In words, and each of them once."""
    return f"run {run}: {reason if reason.startswith(status) else f'{status}; {reason}'}"
