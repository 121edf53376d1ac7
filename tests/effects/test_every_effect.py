"""What holds for every effect: shapes, bounds, finiteness, causality, units."""

from dataclasses import replace

import numpy as np
import pytest
from effect_motions import arm_context, context_of, pa10, rms, wandering
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pa10d.effects import Context, Effect, all_effects, effect
from pa10d.effects.library import backlash
from pa10d.model import Term

EFFECTS = all_effects()
SCOPES = {"joint": (1,), "pair": (3, 5), "robot": ()}
every = pytest.mark.parametrize("name", sorted(EFFECTS))
quick = settings(
    max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def typical(kind: Effect) -> dict[str, float]:
    if kind.id == "contact":
        return {"qs": 5.0, "side": -1.0}  # touching all the time
    return dict(kind.example.shape)


@every
def test_columns_are_torque_per_coefficient_of_the_equations_touched(name):
    kind, context = EFFECTS[name], arm_context(seconds=0.4)
    found = kind.columns(context, SCOPES[kind.scope], typical(kind))
    k, (samples, n) = len(kind.coefficients), context.q.shape
    assert found.shape == ((samples, n, k) if kind.reaches_other_joints else (samples, k))
    assert found.dtype == float
    assert kind.scope == "joint" or kind.reaches_other_joints


@every
def test_starts_name_every_shape_and_lie_within_bounds(name):
    kind = EFFECTS[name]
    for seed, seconds in ((0, 0.05), (1, 8.0)):
        starts = kind.starts(arm_context(seed=seed, seconds=seconds), SCOPES[kind.scope])
        assert len(starts) >= 1
        for shape in starts:
            assert set(shape) == {s.name for s in kind.shapes_in(shape)}
            for s in kind.shapes_in(shape):
                assert s.lower <= shape[s.name] <= s.upper


@every
@quick
@given(
    seed=st.integers(0, 10_000),
    size=st.sampled_from([0.0, 1e-6, 0.05, 1.0, 5.0]),
    pace=st.floats(0.01, 6.0),
    data=st.data(),
)
def test_columns_are_finite_for_any_motion_and_any_shape(name, seed, size, pace, data):
    kind, robot = EFFECTS[name], pa10()
    context = context_of(robot, wandering(7, seed, size, pace), seconds=0.6)
    shape = {
        s.name: data.draw(
            st.sampled_from([s.lower, s.upper])
            if s.scale == "choice"
            else st.floats(s.lower, s.upper)
        )
        for s in kind.shapes
    }
    joints = {
        "joint": (data.draw(st.integers(0, 6)),),
        "pair": data.draw(st.sampled_from([(0, 1), (2, 6), (5, 4)])),
        "robot": (),
    }[kind.scope]
    theta = np.array(
        [data.draw(st.floats(max(c.lower, -50.0), min(c.upper, 50.0))) for c in kind.coefficients]
    )
    for at in (shape, kind.relinearised(theta, shape)):
        assert np.isfinite(kind.columns(context, joints, at)).all()


@every
def test_the_future_does_not_change_the_past(name):
    """Up to one sample ahead may be looked at: signs are averaged around each sample."""
    kind, context = EFFECTS[name], arm_context(seed=3, seconds=2.0)
    cut = 500
    other = arm_context(seed=4, seconds=2.0)
    mixed = replace(
        context,
        **{
            key: np.concatenate([getattr(context, key)[:cut], getattr(other, key)[cut:]])
            for key in ("q", "dq", "ddq", "total")
        },
    )
    joints = SCOPES[kind.scope]
    whole = kind.columns(context, joints, typical(kind))
    changed = kind.columns(mixed, joints, typical(kind))
    assert np.allclose(whole[: cut - 1], changed[: cut - 1], rtol=1e-9, atol=1e-9)
    if name != "torque_offset":
        assert not np.allclose(whole[cut:], changed[cut:])


@every
def test_an_effect_keeps_nothing_and_leaves_the_run_alone(name):
    kind, joints = EFFECTS[name], SCOPES[EFFECTS[name].scope]
    first, second = arm_context(seed=5, seconds=0.5), arm_context(seed=6, seconds=0.5)
    before = [getattr(first, key).copy() for key in ("t", "q", "dq", "ddq", "rigid", "total")]
    once = kind.columns(first, joints, typical(kind))
    kind.columns(second, joints, typical(kind))
    assert np.array_equal(kind.columns(first, joints, typical(kind)), once)
    for key, kept in zip(("t", "q", "dq", "ddq", "rigid", "total"), before, strict=True):
        assert np.array_equal(getattr(first, key), kept)


@every
def test_torque_is_linear_in_the_coefficients(name):
    kind, context = EFFECTS[name], arm_context(seed=7, seconds=0.5)
    joints, rng = SCOPES[kind.scope], np.random.default_rng(0)
    a, b = rng.normal(size=(2, len(kind.coefficients)))

    def torque(theta: np.ndarray) -> np.ndarray:
        return Term(kind.id, joints, theta, typical(kind)).torque(context)

    assert torque(2 * a - 3 * b) == pytest.approx(2 * torque(a) - 3 * torque(b), abs=1e-7)
    untouched = [j for j in range(7) if j not in joints]
    if not kind.reaches_other_joints:
        assert not torque(a)[:, untouched].any()


@every
def test_only_those_that_say_so_depend_on_the_model(name):
    kind, context = EFFECTS[name], arm_context(seed=8, seconds=0.5)
    joints = SCOPES[kind.scope]
    other = replace(
        context,
        rigid=1.3 * context.rigid,
        total=1.7 * context.total + 1.0,
        rubbing=2.0 * context.rubbing,
        ways=(0.004,) * context.robot.n,
        levels=np.full_like(context.q, 1.3),
    )
    choices = [s.name for s in kind.shapes if s.scale == "choice"]
    same = [
        np.allclose(
            kind.columns(context, joints, shape), kind.columns(other, joints, shape), rtol=1e-6
        )
        for value in (0.0, 1.0)
        for shape in [{**typical(kind), **dict.fromkeys(choices, value)}]
    ]
    assert all(same) != kind.uses_model


SECONDS = {  # power of the second in each unit, N·m being kg·m²/s²
    "N·m": -2, "N·m·s/rad": -1, "N·m/rad": -2, "N·m·(s/rad)^p": lambda shape: shape["p"] - 2,
    "1/(N·m)²": 4, "kg·m²": 0, "kg·m": 0, "kg": 0, "rad": 0, "1": 0, "cycles/rev": 0,
    "s": 1, "rad/s": -1,
}  # fmt: skip


def power_of_time(unit: str, shape: dict[str, float]) -> float:
    found = SECONDS[unit]
    return found(shape) if callable(found) else found


@every
def test_units_are_those_that_the_columns_have(name, monkeypatch):
    """The same run told in half-seconds: every number changes as its unit says.

    A built-in speed (the width of a sign) does not, hence the margin.
    """
    kind, context = EFFECTS[name], arm_context(seed=9, seconds=6.0)
    factor, joints, shape = 2.0, SCOPES[kind.scope], typical(kind)
    in_halves: Context = replace(
        context,
        robot=context.robot.with_gravity(context.robot.gravity / factor**2),
        t=context.t * factor,
        dq=context.dq / factor,
        ddq=context.ddq / factor**2,
        total=context.total / factor**2,
    )
    other = {
        s.name: shape[s.name] * factor ** power_of_time(s.unit, shape)
        for s in kind.shapes_in(shape)
    }
    here = kind.columns(context, joints, shape)
    monkeypatch.setattr(backlash, "CONTACT_HZ", backlash.CONTACT_HZ / factor)
    there = kind.columns(in_halves, joints, other)
    for i, c in enumerate(kind.coefficients):
        expected = -2.0 - power_of_time(c.unit, shape)
        found = np.log(rms(there[..., i]) / rms(here[..., i])) / np.log(factor)
        assert found == pytest.approx(expected, abs=0.15), c.name


def test_what_the_data_do_not_show_is_not_determined():
    """All axes of a SCARA stand upright: how high its load sits is not 0 m."""
    known = np.diag([0.01, 0.01, 0.01, 0.0, *(0.0,) * 6])
    told = effect("payload").values(np.array([0.3, 0.006, 0.003, *(0.0,) * 7]), known, {}, {})
    assert [name for name, v in told.items() if not v.determined] == ["cz"]
    assert str(told["cz"]) == "not determined"
