"""A URDF whose lengths or axes are not the arm's: it is said, and no effect is named for it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from bare_sides import ar1
from scipy.spatial.transform import Rotation
from test_zeros_and_tilt import FIT, HELD, of_turret, turret

from pa10d.diagnose.outcome.words import unexplained
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.suspects import suspects
from pa10d.diagnose.unknown.geometry import other_geometry
from pa10d.dynamics import Freedom, freedoms, inverse_dynamics
from pa10d.effects import effect
from pa10d.identify.procedure import identify
from pa10d.model import Term
from pa10d.report.finding_section import Asked
from pa10d.report.unexplained_section import unexplained_section
from pa10d.report.verdict import headline

AXES = np.eye(3)
LIKEWISE = [(e, joints) for e, joints in suspects(True, 3) if e.seen_by_shared_bodies]
FLOOR = np.full(3, 0.05 * np.sqrt(8.0 / 50.0))


def model_of(runs, robot):
    return identify([runs[n] for n in FIT], robot, name="m0", cutoff=8.0)


def found_in(runs, robot, named=None):
    """With this effect (id, joint) named before, or nothing."""
    model = model_of(runs, robot)
    train, held, _ = two_sides(model, [runs[n] for n in FIT], [runs[n] for n in HELD])
    state = SearchState.start(model, train, held)
    given = len(state.terms)
    if named is not None:
        size = np.zeros(len(effect(named[0]).coefficients))
        state.push(Term(named[0], (named[1],), size, {}))
        state.refit()
    return other_geometry(state, LIKEWISE, given, FLOOR)


def told_of(runs, robot):
    """Of the joints, with nothing named beside."""
    return found_in(runs, robot).told


@cache
def elsewhere(joint, kind, by, urdf=False):
    """(runs, robot as the URDF has it); urdf: the URDF alone has the joint there."""
    there = Freedom(joint, kind, AXES).moved(turret(), np.array(by))
    arm, said = (turret(), there) if urdf else (there, turret())
    return of_turret(arm, np.zeros(3), 0.0), said


@pytest.mark.long
@pytest.mark.by_default("1-origin")
@pytest.mark.parametrize(
    ("joint", "kind", "by", "urdf"),
    [
        (1, "origin", (0.02, 0.0, 0.0), False),
        (2, "axis", (0.0, 0.0, 0.05), True),
        pytest.param(1, "origin", (0.02, 0.0, 0.0), True, marks=pytest.mark.long),
        pytest.param(2, "axis", (0.0, 0.0, 0.05), False, marks=pytest.mark.long),
    ],
)
def test_a_frame_elsewhere_is_told_with_its_joint_and_size(joint, kind, by, urdf):
    runs, robot = elsewhere(joint, kind, by, urdf)
    told = told_of(runs, robot)
    assert {one.joint for one in told} == {0, 1, 2}
    (where,) = told[0].misplaced
    assert (where.freedom.joint, where.freedom.kind) == (joint, kind)
    truth = -np.array(by) if urdf else np.array(by)
    assert np.linalg.norm(where.by - truth) < 0.1 * np.linalg.norm(truth)
    if kind == "axis":
        there = Rotation.from_rotvec(truth).apply(robot.axis[joint]) - robot.axis[joint]
        most = int(np.argmax(np.abs(there)))
        way = ("-" if there[most] < 0.0 else "+") + "xyz"[most]
        assert f"mostly towards {way} of its own frame" in where.words


@pytest.mark.by_default("zero2-0.05")
@pytest.mark.parametrize(
    ("zero", "lean"), [((0.0, 0.0, 0.0), 0.0), ((0.0, 0.05, 0.0), 0.0), ((0.0, 0.0, 0.0), 0.05)]
)
def test_neither_a_clean_arm_nor_a_zero_nor_a_tilt_is_told_as_geometry(zero, lean):
    assert told_of(of_turret(turret(), np.array(zero), lean), turret()) == ()


def with_ring(joint, by):
    """(runs, robot): its angle reads too high by sin(q) and cos(q) so much, rad."""
    runs = of_turret(turret(), np.zeros(3), 0.0)
    for run in runs.values():
        q = run.q[:, joint].copy()
        run.q[:, joint] += by[0] * np.sin(q) + by[1] * np.cos(q)
    return runs, turret()


def test_a_ring_that_is_not_centred_is_told_with_its_size():
    told = told_of(*with_ring(1, (0.03, 0.01)))
    assert len(told) > 1
    (where,) = told[0].misplaced
    assert (where.freedom.joint, where.freedom.kind) == (1, "ring")
    assert np.allclose(where.by, (0.03, 0.01), atol=4e-3)


@pytest.mark.long
def test_a_gain_that_it_needs_beside_it_stays_named_and_is_not_counted_for_it():
    """The gain was dropped, as if the ring could do without it, and what it takes told of the
    ring."""
    runs, robot = with_ring(1, (0.03, 0.01))
    for run in runs.values():
        run.tau[:, 2] *= 1.15
    alone, found = found_in(runs, robot), found_in(runs, robot, ("torque_gain", 2))
    assert [t.joints for t in found.state.terms if t.effect_id == "torque_gain"] == [(2,)]
    assert {m.freedom.kind for one in found.told for m in one.misplaced} <= {"ring"}
    for one in found.told:
        (other,) = [other for other in alone.told if other.joint == one.joint] or [None]
        assert other is None or other.rms == pytest.approx(one.rms, rel=0.2)


@pytest.mark.long
def test_a_spring_that_stood_in_for_it_is_dropped():
    found = found_in(*elsewhere(1, "origin", (0.02, 0.0, 0.0)), ("spring", 1))
    assert [t.effect_id for t in found.state.terms if t.effect_id == "spring"] == []
    assert {one.joint for one in found.told} == {0, 1, 2}


def test_a_spring_that_is_there_stays_and_is_no_geometry():
    runs = of_turret(turret(), np.zeros(3), 0.0)
    for run in runs.values():
        run.tau[:, 0] += 3.0 * run.q[:, 0]
        run.tau[:, 1] += 2.0 * run.q[:, 1]
    found = found_in(runs, turret(), ("spring", 1))
    assert (found.told, found.as_well) == ((), ())
    assert ("spring", (1,)) in [(t.effect_id, t.joints) for t in found.state.terms]


@pytest.mark.long
@pytest.mark.by_default("0.9")
@pytest.mark.parametrize("phi", [0.9, 0.999])
def test_slow_noise_is_no_geometry(phi):
    runs = of_turret(turret(), np.zeros(3), 0.0)
    rng = np.random.default_rng(3)
    for run in runs.values():
        run.tau[:] += 0.2 * np.column_stack([ar1(rng, len(run.t), phi) for _ in range(3)])
    assert told_of(runs, turret()) == ()


@pytest.mark.long
def test_it_is_said_in_the_headline_on_the_joint_and_what_to_do():
    """It was "what the library has not, or slow noise" and "look at how its torque is measured"."""
    runs, said = elsewhere(1, "origin", (0.02, 0.0, 0.0))
    found = diagnose(model_of(runs, said), [runs[n] for n in FIT], [runs[n] for n in HELD])
    assert (found.verdict, found.findings) == ("unknown", ())
    assert unexplained(found).startswith("No effect of the library, but an arm that is not")
    where = "joint 2 sits about 20 mm elsewhere, mostly along +x"
    assert where in found.remaining[0].sentence
    assert where in headline(found)
    (what,) = found.warnings
    assert "the arm may not be as its URDF says" in what
    asked = Asked("m0", list(FIT), list(HELD))
    section = unexplained_section(found, found.misplaced[0], None, asked)
    assert section.title == "Joint 1: the arm may not be as its URDF says"


def test_columns_are_what_a_small_change_of_the_tree_does():
    robot, rng = turret(), np.random.default_rng(2)
    motion = [rng.normal(size=(5, 3)) for _ in range(3)]
    for freedom in freedoms(robot):
        slope = freedom.torque(robot, robot.parameters, motion)
        for k, unit in enumerate(1e-3 * np.eye(freedom.along.shape[1])):
            if freedom.kind == "ring":
                there, back = (
                    inverse_dynamics(robot, robot.parameters, *freedom.read(motion, by))
                    for by in (unit, -unit)
                )
            else:
                there, back = (
                    inverse_dynamics(freedom.moved(robot, by), robot.parameters, *motion)
                    for by in (unit, -unit)
                )
            assert np.allclose(slope[..., k], (there - back) / 2e-3, atol=1e-3)


def test_a_ring_reads_the_motion_that_its_angle_has():
    """Against differences in time."""
    t, by = np.arange(0.0, 1.0, 1e-4), np.array([0.004, 0.002])
    q, dq, ddq = np.sin(3 * t), 3 * np.cos(3 * t), -9 * np.sin(3 * t)
    freedom = Freedom(0, "ring", np.eye(2))
    true = [x[:, 0] for x in freedom.read([x[:, None] for x in (q, dq, ddq)], by)]
    assert np.allclose(true[0], q - by[0] * np.sin(q) - by[1] * np.cos(q))
    assert np.allclose(np.gradient(true[0], t)[1:-1], true[1][1:-1], atol=1e-6)
    assert np.allclose(np.gradient(true[1], t)[1:-1], true[2][1:-1], atol=1e-5)
