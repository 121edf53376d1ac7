"""What a ``boundary_velocity`` experiment is for: from which speed on is friction linear?"""

from __future__ import annotations

from pa10d.common.errors import UserError
from pa10d.dynamics import Robot
from pa10d.measurement.recording import Recording
from pa10d.paper.boundary import BoundaryVelocity, boundary_velocity
from pa10d.paper.single_joint import Gravity, single_joint
from pa10d.paper.spans import steady_parts
from pa10d.trajectory.plan import Plan


def boundaries(
    recording: Recording, plan: Plan, robot: Robot
) -> tuple[list[BoundaryVelocity], list[str]]:
    """The answer of every joint that was moved, and why there is none for others."""
    begin = float(recording.t[0]) - 1.0 / recording.rate  # the run begins with the plan's 1st tick
    found, missing = [], []
    for number in plan.joints:
        mine = list(steady_parts(recording, plan, begin, number).values())
        gravity: Gravity = "none" if number in plan.weightless else "fitted"
        try:
            found.append(boundary_velocity(single_joint(mine, robot, number - 1, gravity=gravity)))
        except UserError as error:
            missing.append(str(error))
    return found, missing
