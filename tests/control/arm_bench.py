"""Plans run on a plant in this process, as the daemon runs them over the bus: in simulated time,
with the encoder's counts, the drives' per mille and the bus's cycle of delay."""

from __future__ import annotations

import numpy as np
from fake_backend import FakeBackend
from rough_plant import make

from pa10d.control.build import build_arm
from pa10d.control.gains import PidGains, first_gains, fitted_gains
from pa10d.control.limits import arm_limits
from pa10d.control.pid import Pid
from pa10d.control.reference import MotionUnderWay
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState
from pa10d.dynamics import robot_from_profile
from pa10d.experiments.measured_joints import Seen, measured_figures
from pa10d.experiments.motion import measured_torque, rows_of, whole_motion
from pa10d.experiments.pacing import Joints, paced
from pa10d.profile import load_profile
from pa10d.services.joints import torque_steps
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


class ArmBench:
    """A PA10 that its URDF describes badly; ``faults``: what ended motions."""

    def __init__(self, rate=500.0, bandwidth=None, pose=None, **plant):
        profile = load_profile("pa10-sim")
        update = {"rate": rate, "bandwidth_hz": bandwidth}
        control = profile.control.model_copy(update=update)
        self.profile = profile.model_copy(update={"control": control})
        self.rate, self.robot = rate, robot_from_profile(self.profile)
        self.limits = arm_limits(self.profile, self.robot)
        self.plant = make(self.profile, **plant)
        self.plant.reset(np.zeros(7) if pose is None else np.array(pose))
        self.steps = torque_steps(self.profile, self.robot)
        self.backend = BusLike(self.plant, 1.0 / rate, self.steps)
        self.ring = Ring.create(self.robot.n, int(200 * rate), 1.0 / rate)
        self.arm = build_arm(self.profile, self.robot, self.backend, self.ring)
        self.arm.connect()
        self.arm.cycle()
        self.joints: Joints | None = None
        self.around = Surroundings.of(self.robot)

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
        for _ in range(int(self.rate) + 50):
            self.arm.cycle()
        return self.arm.fault

    def run(self, plan, ahead=None):
        """→ rows of the plan as recorded, and the fault."""
        start = self.arm.path.reference.q.copy()
        if self.joints is not None:
            chosen = paced(plan, start, self.robot, self.limits, self.rate, self.joints)
            assert chosen.check.level != "error", chosen.check.sentence
            plan, whole, ahead = chosen.plan, chosen.whole, self.joints.figures
        else:
            whole = whole_motion(plan, start, self.robot, self.rate)
        rows = rows_of(whole, None, None)
        if ahead is not None:
            rows[:, -self.robot.n :] += measured_torque(plan, whole, self.robot, ahead, self.rate)
        began = self.ring.written
        self.arm.run(MotionUnderWay(1, rows, whole.first, whole.last))
        while self.arm.state in (ArmState.RUNNING, ArmState.STOPPING):
            self.arm.cycle()
        self.arm.cycle()
        taken = self.ring.read(began)[0]
        return taken[self.ring.layout.get(taken, "recording") > 0], self.arm.fault

    def first_motion(self):
        """Enable, measure, use what follows → the fault that ended it, or None."""
        bound = self.limits.following_error
        self.use(first_gains(self.robot, self.profile.control, bound))
        if (fault := self.enable()) is not None:
            return fault
        parts, figures, get = {}, None, self.ring.layout.get
        for part in PARTS:
            asked = {"kind": "first_motion", "parameters": {"part": part}}
            plan = read_request(asked).build(self.around)
            rows, fault = self.run(plan, figures)
            if fault is not None:
                return fault
            parts[part] = Seen(plan, self.rate, get(rows, "q"), get(rows, "torque"))
            figures = measured_figures(self.robot, parts, self.steps)
            gains = fitted_gains(self.robot, self.profile.control, bound, figures).gains
            self.use(gains)
        self.joints = Joints(figures, gains, ahead=True)
        return None

    def error(self, rows):
        """(n,) rad, the largest."""
        get = self.ring.layout.get
        return np.abs(get(rows, "q_ref") - get(rows, "q")).max(axis=0)
