"""A drive whose torque acts the wrong way round cannot brake its axis: its brake alone does."""

from __future__ import annotations

import numpy as np
import pytest

from backends.faults import fault
from pa10d.control.faults import LoopFault

WRONG = 1  # 0-based


@pytest.mark.by_default("another joint was too fast first")
@pytest.mark.parametrize(
    ("kind", "named", "faster", "jumps", "right"),
    [
        ("wrong_sign", WRONG, 0.05, False, False),
        ("not_held", 0, 0.5, False, False),
        ("not_held", 0, 0.5, True, False),
        ("following_error", WRONG, 0.5, False, True),
    ],
    ids=[
        "it is known", "another joint was too fast first", "its encoder jumped, too",
        "its torque was seen to be right",
    ],
)  # fmt: skip
def test_its_own_ramp_does_not_drive_it_on(world, kind, named, faster, jumps, right):
    """22 rad/s before; all others stop along their ramps. faster: rad/s, until that is seen. One
    that takes no torque any more because its encoder jumped is watched as well. Whoever has gone
    there and back under its servo is not told to exchange phases: it was, of a right arm."""
    seen, at = [], {}
    cycle = world.arm.path.watch

    def watched(stopping_for_fault, standing):
        cycle(stopping_for_fault, standing)
        if at:
            seen.append((world.drives.mechanics.q.copy(), world.drives.mechanics.velocity.copy()))

    world.arm.path.watch = watched

    def story():
        yield from world.moving()
        mechanics = world.drives.mechanics
        mechanics.motors = np.where(np.arange(world.robot.n) == WRONG, -1.0, 1.0)
        at.update(q=mechanics.q.copy(), speed=np.abs(mechanics.velocity))
        world.arm.right_way.known[:] = right
        world.arm._on_fault(LoopFault(kind, "moved by itself", named))
        if right:
            world.arm._on_fault(LoopFault("stop", "does not stop as asked", named))
        if jumps:
            world.arm._on_fault(fault("encoder_jump", "encoder jumped by 21488 counts", WRONG))
        yield world.is_in("fault")
        yield world.passes(0.5)

    world.run(story())
    way = np.abs(np.array([q for q, _ in seen]) - at["q"]).max(axis=0)
    fastest = np.abs(np.array([v for _, v in seen])).max(axis=0)
    assert at["speed"][WRONG] > 0.1, "it did not move: nothing was shown"
    assert fastest[WRONG] < at["speed"][WRONG] + faster
    assert way[WRONG] < 0.1
    assert world.at_rest()
    said = world.faults[-1].sentence
    assert ("joint 2 got faster as its own drive" in said) == (named != WRONG)
    assert ("exchange two phases" in said) != right
    assert ("look at its load first" in said) == (named != WRONG)
    assert ("more than its motor holds" in said) == (right or named != WRONG)
    assert [drive.brake_closed for drive in world.drives.drives] == world.robot.n * [True]
