"""Friction that grows with load or with the place, carried by bristles, and what is no change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_two_at_a_reversal import SUBSTEPS
from two_links import (
    COULOMB,
    RATE,
    V0,
    motion,
    recordings,
    robot,
    state_of,
    textbook,
    textbook_torque,
)

from pa10d.diagnose.outcome.found import _without
from pa10d.diagnose.outcome.words import unexplained
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search.harm import rms
from pa10d.dynamics import inverse_dynamics
from pa10d.effects.base import smooth_sign
from pa10d.measurement.recording import Recording
from pa10d.model import Term

WAY = 0.02  # rad


def carried(t, dq, level):
    """(N,) N·m: ż = q̇ - |q̇|·z·σ0/level (LuGre)."""
    at = np.arange(SUBSTEPS * len(t)) / SUBSTEPS
    speed, size = (np.interp(at, np.arange(len(t)), x) for x in (dq, level))
    stiffness, step = COULOMB[0] / WAY, 1.0 / (RATE * SUBSTEPS)
    force, z = np.zeros(len(speed)), 0.0
    for k, v in enumerate(speed):
        z = (z + step * v) / (1.0 + step * abs(v) * stiffness / size[k])
        force[k] = stiffness * z
    return force[::SUBSTEPS]


def on_load(t, q, dq, ddq):
    load = inverse_dynamics(robot(), robot().parameters, q, dq, ddq)[:, 0]
    rubs = carried(t, dq[:, 0], COULOMB[0] + 0.15 * np.abs(load))
    return np.column_stack([rubs - COULOMB[0] * smooth_sign(dq[:, 0], V0), np.zeros(len(t))])


def on_place(t, q, dq, ddq):
    spot = 0.8 * np.exp(-(((q[:, 0] - 0.3) / 0.3) ** 2))
    rubs = carried(t, dq[:, 0], COULOMB[0] + spot)
    return np.column_stack([rubs - COULOMB[0] * smooth_sign(dq[:, 0], V0), np.zeros(len(t))])


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "seed", "effect_id", "values"),
    [
        pytest.param(on_load, 2, "load_friction", {"mu": 0.15, "rotor": 0.4}),
        pytest.param(
            on_place, 3, "position_friction", {"A": 0.8, "qc": 0.3}, marks=pytest.mark.long
        ),
    ],
)
def test_what_grows_with_something_on_a_bristle(law, seed, effect_id, values):
    """Turning round at once beside a bristle of its own it left 85 and 20 times the noise."""
    runs = recordings(seed, law, 0.02)
    model = textbook(runs)
    found = diagnose(model, [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]])
    named = {f.term.effect_id: f.parameters for f in found.findings if f.term.joints == (0,)}
    assert sorted(named) == sorted([effect_id, "presliding_hysteresis"])
    for name, true in values.items():
        assert named[effect_id][name].value == pytest.approx(true, rel=0.02)
    assert named["presliding_hysteresis"]["F"].value == pytest.approx(COULOMB[0], rel=0.01)
    assert "lag" not in named["presliding_hysteresis"], "these are not damped"
    assert max(line.ratio for line in found.remaining) < 1.3


def test_what_bristles_take_is_told_beside_dry_friction_in_their_place():
    """Of bristles that took 10 % of a joint's error "more than 99 %" was said, and "lacks 3.1 N·m":
    no friction at all was left in their place."""
    state = state_of(recordings(2))
    alone = rms(state.held_residual())
    names = [(t.effect_id, t.joints) for t in state.terms]
    dry = names.index(("coulomb", (0,)))
    term = state.terms[dry]
    state.replace_term(dry, replace(term, shape={**term.shape, "elsewhere": 1.0}))
    state.push(Term("presliding_hysteresis", (0,), np.array(COULOMB[:1]), {"zs": 1e-3}))
    state.refit()
    last = len(state.terms) - 1
    nothing = rms(state.held_residual(state.fit_without(last)))
    assert nothing[0] > 10.0 * alone[0]
    np.testing.assert_allclose(_without(state, last, nothing), alone, rtol=1e-6)
    np.testing.assert_array_equal(_without(state, dry, nothing), nothing)


LAG = 0.02  # s


def damped(t, q, dq, ddq):
    """σ1·ż beside what bends, z from the law itself and not from the effect's column."""
    rubs = carried(t, dq[:, 0], np.full(len(t), COULOMB[0]))
    return np.column_stack(
        [
            rubs + LAG * np.gradient(rubs, 1.0 / RATE) - COULOMB[0] * smooth_sign(dq[:, 0], V0),
            np.zeros(len(t)),
        ]
    )


@pytest.mark.long
def test_bristles_that_are_damped():
    """Without their damping they left a joint at 1.4 times its noise, which nothing explained."""
    runs = recordings(4, damped, 0.02)
    model = textbook(runs)
    found = diagnose(model, [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]])
    (one,) = found.findings
    assert (one.term.effect_id, one.term.joints) == ("presliding_hysteresis", (0,))
    told = one.parameters
    assert told["sigma0"].value == pytest.approx(COULOMB[0] / WAY, rel=0.02)
    assert told["sigma1"].value == pytest.approx(LAG * COULOMB[0] / WAY, rel=0.05)
    assert max(line.ratio for line in found.remaining) < 1.15


def test_versions_before_bristles_have_dry_friction_of_their_own():
    """They stood without any, and "of which the model lacks" was 2.5 N·m for 0.19."""
    state = state_of(recordings(3, on_load, 0.02))
    count = len(state.terms)
    before = state.fit.rms()
    state.push(Term("presliding_hysteresis", (0,), np.ones(1), {"zs": WAY}))
    (dry,) = [i for i, t in enumerate(state.terms) if t.effect_id == "coulomb" and 0 in t.joints]
    shape = {**state.terms[dry].shape, "elsewhere": 1.0}
    state.replace_term(dry, replace(state.terms[dry], shape=shape))
    state.refit()
    assert state.bare(count, own_weights=True).fit.rms() == pytest.approx(before, rel=1e-6)
    assert "elsewhere" in state.terms[dry].shape


def bumps(seed, share):
    """A run whose joints rub more at low speed, as they always did; paced by ``share``."""
    t, q, dq, ddq = motion(seed)
    dq, ddq = share * dq, share**2 * ddq
    rng = np.random.default_rng([seed, 9])
    more = 1.5 * np.exp(-np.abs(dq) / 0.1) * np.tanh(dq / V0)
    tau = textbook_torque(q, dq, ddq) + more + 0.02 * rng.standard_normal(q.shape)
    return Recording(f"run{seed}", t / share, q, tau)


@pytest.mark.long
def test_what_a_model_always_lacked_has_not_changed():
    """A model without Stribeck friction, motion at half the pace: less Coulomb friction "now" was
    named on both joints."""
    model = textbook({"fit_a": bumps(1, 1.0), "fit_b": bumps(2, 1.0)})
    found = diagnose(model, [bumps(3, 0.5)], [bumps(4, 0.5)], frozen=True)
    assert not found.findings
    for line in found.remaining:
        assert line.ratio > 2.0
        assert "was identified from" in line.sentence
    assert unexplained(found).startswith("The model keeps an error that it had before")


@pytest.mark.long
def test_of_one_suspicion_nothing_is_said_about_others():
    """40 times the floor were "slow noise" where only Stribeck friction of another joint was
    tested, and "no effect of the library" had explained it."""
    runs = recordings(3, on_place, 0.02)
    sides = [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    found = diagnose(textbook(runs), *sides, only=("spring", [1]))
    assert not found.findings
    assert found.remaining[0].ratio > 5.0
    assert "slow noise" not in found.remaining[0].sentence
    assert "library" not in unexplained(found)
    assert unexplained(found).startswith("Something is left that a spring does not explain")
