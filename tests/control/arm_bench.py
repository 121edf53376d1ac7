"""Plans run on a plant in this process, as the daemon runs them over the bus: in simulated time,
with the encoder's counts, the drives' per mille and the bus's cycle of delay."""

from __future__ import annotations

from collections import Counter

import numpy as np
from fake_backend import FakeBackend
from rough_plant import make

from pa10d.control.build import build_arm, weight_of
from pa10d.control.gains import PidGains
from pa10d.control.joint_figures import first_figures
from pa10d.control.limits import arm_limits
from pa10d.control.outside import outside
from pa10d.control.pid import Pid
from pa10d.control.reference import MotionUnderWay
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState
from pa10d.daemon.motions.experiment import FALLS, WEIGHINGS
from pa10d.daemon.motions.first_motion import TRIES
from pa10d.dynamics import robot_from_profile
from pa10d.dynamics.carried import weighing
from pa10d.experiments.measured_joints import measured_figures
from pa10d.experiments.motion import measured_torque, rows_of, softly, weight_between, whole_motion
from pa10d.experiments.pacing import Joints, paced
from pa10d.experiments.seen import Seen
from pa10d.experiments.slower import AS_ASKED, Slower, slower_after
from pa10d.experiments.way_back import rows_back
from pa10d.profile import load_profile
from pa10d.services.joints import (
    begun,
    calmed,
    felt_more,
    firmed,
    not_held,
    slowed,
    soft,
    told_on_the_way,
    torque_steps,
)
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.kinds.first_motion import PARTS
from pa10d.trajectory.poses import Surroundings


class BusLike(FakeBackend):
    """What was written in this cycle acts from the next SYNC on, in whole per mille."""

    def __init__(self, plant, period, steps):
        super().__init__(plant, period)
        self._step, self._waiting = steps, np.zeros(self.n)

    def _cycle(self):
        waiting, self._waiting = self._waiting, np.round(self.torque / self._step) * self._step
        self.torque, kept = waiting, self.torque
        feedback = super()._cycle()
        self.torque = kept
        return feedback


class Refused(Exception):
    """The pre-check did not let a motion run; weighs: see ``Paced``."""

    def __init__(self, text, weighs=None):
        super().__init__(text)
        self.weighs = weighs


class ArmBench:
    """An arm that its URDF describes badly, by itself a PA10."""

    def __init__(self, rate=500.0, bandwidth=None, pose=None, profile=None, **plant):
        profile = load_profile("pa10-sim") if profile is None else profile
        update = {"rate": rate, "bandwidth_hz": bandwidth}
        control = profile.control.model_copy(update=update)
        self.profile = profile.model_copy(update={"control": control})
        self.rate, self.robot = rate, robot_from_profile(self.profile)
        self.limits = arm_limits(self.profile, self.robot)
        self.plant = make(self.profile, **plant)
        self.around = Surroundings.of(self.robot)
        self.plant.reset(self.around.limits.rest_pose() if pose is None else np.array(pose))
        self.steps = torque_steps(self.profile, self.robot)
        self.backend = BusLike(self.plant, 1.0 / rate, self.steps)
        self.ring = Ring.create(self.robot.n, int(200 * rate), 1.0 / rate)
        self.arm = build_arm(self.profile, self.robot, self.backend, self.ring)
        self.arm._rests = 0.0  # behind these brakes no link swings
        self.arm.connect()
        self.arm.cycle()
        self.joints: Joints | None = None
        self.parts, self.felt = {}, []
        self.notes: list[str] = []
        self.beyond = np.zeros(self.robot.n)  # rad, that joints were beyond their limits

    def use(self, gains: PidGains) -> None:
        """As the command ``gains`` does."""

        def servo():
            return Pid(gains, self.limits.torque, 1.0 / self.rate)

        self.arm.path.make_servo = servo
        self.arm.path.reference.rest(self.arm.path.q.copy())
        self.arm.use(servo())

    def enable(self):
        """→ the fault, or None once it is held for a second."""
        self.arm.enable()
        while self.arm.state == ArmState.ENABLING:
            self.arm.cycle()
        for _ in range(int(self.rate) + 50):
            self.arm.cycle()
        return self.arm.fault

    def enable_at_last(self):
        """The same, as an experiment does: again where a fall told what holds its joint."""
        fell = Counter()
        while (fault := self.enable()) is not None and fault.weighed:
            fell[fault.weighed] += 1
            if fell[fault.weighed] > FALLS:
                break
            self.notes.append(f"joint {fault.joint} {fault.cause}")
            self._reset()
        return fault

    def _reset(self):
        while self.arm.state != ArmState.FAULT:
            self.arm.cycle()
        self.arm.reset()
        while self.arm.state != ArmState.INACTIVE:
            self.arm.cycle()

    def run(self, plan, ahead=None, slower=AS_ASKED):
        """→ rows of the plan as recorded, and the fault."""
        start = self.arm.path.reference.q.copy()
        if self.joints is not None:
            chosen = paced(plan, start, self.robot, self.limits, self.rate, self.joints, slower)
            if chosen.check.level == "error" or chosen.weighs is not None:
                raise Refused(chosen.check.sentence, chosen.weighs)
            if chosen.check.level == "warning":
                self.notes.append(f"{plan.kind}: {chosen.check.sentence}")
            plan, whole, ahead = chosen.plan, chosen.whole, self.joints.figures
            self.pace = chosen.adjusted.pace
        else:
            unhurried = None
            if ahead is not None:
                unhurried = softly(ahead, self.limits.following_error, plan.start - start)
            whole = whole_motion(plan, start, self.robot, self.rate, softly=unhurried)
        rows, weight = rows_of(whole, None, None), None
        if ahead is not None:
            rows[:, -self.robot.n :] += measured_torque(plan, whole, self.robot, ahead, self.rate)
            weight = weight_between(self.robot, ahead, start)
        began = self.ring.written
        self.arm.run(MotionUnderWay(1, rows, whole.first, whole.last, weight))
        while self.arm.state in (ArmState.RUNNING, ArmState.STOPPING):
            self.arm.cycle()
            q = self.backend.plant.measure()[0]
            np.maximum(self.beyond, np.maximum(q - self.limits.upper, self.limits.lower - q),
                       out=self.beyond)  # fmt: skip
        self.arm.cycle()
        taken = self.went = self.ring.read(began)[0]
        return taken[self.ring.layout.get(taken, "recording") > 0], self.arm.fault

    def run_on(self, plan):
        """As an experiment does: a smaller motion before where the arm's weight is in doubt; with
        calmer gains where a joint swings, or slower."""
        for left in range(WEIGHINGS, -1, -1):
            try:
                return self._run_on(plan)
            except Refused as refused:
                if refused.weighs is None or not left:
                    raise
                rows, fault = self._run_on(plan, Slower(small=refused.weighs))
                if fault is not None:
                    return rows, fault
                self.notes.append(f"{refused.weighs:.0%} of it before, to weigh the arm")
                seen = (self.ring.layout.get(rows, k) for k in ("q", "torque"))
                self.felt.append(Seen(plan, self.rate, *seen))
                self.known = felt_more(self.profile, self.robot, self.known, self.parts, self.felt)
                self._use_known()
                self._take_joints()

    def _run_on(self, plan, slower=AS_ASKED):
        for _ in range(TRIES["oscillation"]):
            rows, fault = self.run(plan, slower=slower)
            if fault is None:
                break
            if self._calm(fault):
                continue
            slower = slower_after(fault, self.joints.figures, self.pace, slower)
            if slower is None or not self._again():
                break
            self.notes.append(f"{slower.why}: it is tried again at 1/{slower.pace:g} of its speed")
        return rows, fault

    def first_motion(self):
        """Enable, measure, use what follows → the fault that ended it, or None."""
        places = np.array([self.plant.measure()[0], self.around.limits.rest_pose()])
        first = first_figures(self.robot, places)
        self.known, unmet = begun(self.profile, self.robot, first)
        self.notes += [unmet] if unmet else []
        if (reason := not_held(self.profile, self.robot, self.known)) is not None:
            raise Refused(reason)
        self._use_known()
        if (fault := self.enable_at_last()) is not None and not self._calm(fault):
            return fault
        parts, get = {}, self.ring.layout.get
        for part in PARTS:
            asked = {"kind": "first_motion", "parameters": {"part": part}}
            if part == "sliding":
                asked["parameters"]["joints"] = soft(self.profile, self.robot, self.known)
                if not asked["parameters"]["joints"]:
                    continue
            if not read_request(asked).has_any(self.around):
                continue
            plan, rows, fault = self._measured_part(part, asked)
            if fault is not None:
                return fault
            parts[part] = Seen(plan, self.rate, get(rows, "q"), get(rows, "torque"))
            figures = measured_figures(self.robot, parts, self.steps, self.known.figures)
            now = figures.after(self.known.figures)
            self.known, _ = begun(self.profile, self.robot, now)
            if (reason := not_held(self.profile, self.robot, self.known)) is not None:
                raise Refused(reason)
            self._use_known()
        self._take_joints()
        self.parts = parts
        return None

    def _measured_part(self, part, asked):
        """As the daemon has it: calmer or firmer gains, and where none help, slower strokes."""
        tried = Counter()
        while True:
            plan = read_request(asked).build(self.around)
            rows, fault = self.run(plan, self.known.figures)
            if fault is None or fault.kind not in TRIES:
                return plan, rows, fault
            tried[fault.axis] += 1
            cut = Seen(plan, self.rate, *self._ours(self.went))
            if tried[fault.axis] < TRIES[fault.kind] and self._calm(fault, cut, part):
                continue
            now = asked["parameters"].get("speed", 1.0)
            speed = slowed(self.profile, self.robot, self.known, fault, part, now)
            if speed is None or not self._again():
                return plan, rows, fault
            asked["parameters"]["speed"] = speed
            self.notes.append(f"strokes at {speed:g} of their speed")

    def _ours(self, rows):
        """rad and N·m of a run and its stop, as far as that was the servo's."""
        q, torque, state = (self.ring.layout.get(rows, k) for k in ("q", "torque", "state"))
        ours = np.isin(state, (ArmState.RUNNING, ArmState.STOPPING)) & torque.any(axis=1)
        return q[ours], torque[ours]

    def _use_known(self):
        self.use(self.known.gains)
        if self.known.felt is not None:
            self.arm.weigh(weight_of(self.robot, self.known.felt))

    def _take_joints(self):
        self.around = Surroundings.of(weighing(self.robot, self.known.felt))
        self.joints = Joints(self.known.figures, self.known.gains, ahead=True)

    def _calm(self, fault, cut=None, part="friction") -> bool:
        """Reset with calmer gains, if it swung. cut: what was recorded of a part that tells
        weights."""
        asked = self.profile, self.robot, self.known, fault
        if fault.kind == "following_error" and self.joints is None:
            calmer = told_on_the_way(*asked, cut, part) if cut is not None else None
            calmer = calmer or firmed(*asked)
        elif fault.kind == "oscillation":
            calmer = calmed(self.profile, self.robot, self.known, fault.axis, fault.hertz)
        else:
            return False
        if calmer is None:
            return False
        self.notes.append(calmer.note)
        self.known = calmer.known
        return self._again()

    def _again(self) -> bool:
        """Reset, and enabled with what is known now."""
        self._reset()
        self._use_known()
        if self.joints is not None:
            self._take_joints()
        return self._inside() and self.enable_at_last() is None

    def _inside(self) -> bool:
        """Brought back inside where it stands outside its limits, as for an experiment that has
        ``recover``."""
        if not outside(self.arm.path.q, self.limits.lower, self.limits.upper):
            return True
        self.arm.enable(recover=True)
        for _ in range(int(self.rate) + 50):
            self.arm.cycle()
        if self.arm.fault is None:
            self.notes.append("brought back inside its limits")
            rows = rows_back(self.robot, self.arm.path.reference.q.copy(), self.rate)
            self.arm.run(MotionUnderWay(1, rows))
            while self.arm.state in (ArmState.RUNNING, ArmState.STOPPING):
                self.arm.cycle()
        return self.arm.fault is None

    def error(self, rows):
        """(n,) rad, the largest."""
        get = self.ring.layout.get
        return np.abs(get(rows, "q_ref") - get(rows, "q")).max(axis=0)
