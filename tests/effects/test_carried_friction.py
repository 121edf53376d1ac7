"""Friction of any level that bristles of one stiffness carry, against an ODE solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from effect_motions import DT, context_of, pa10, rms, wandering
from scipy.integrate import solve_ivp

from pa10d.effects.together import contextualised, torque_of
from pa10d.model import Term

JOINT = 2
STIFFNESS, F, FS, VS, MU = 900.0, 4.0, 2.5, 0.15, 0.3


def own(name, coefficient, **shape):
    return Term(name, (JOINT,), np.array([coefficient]), shape)


BRISTLE = own("presliding_hysteresis", F, zs=F / STIFFNESS)
STRIBECK = own("stribeck", FS, vs=VS, delta=1.0)
LOAD = own("load_friction", MU, v0=0.01, rotor=0.0)
SPOT = own("position_friction", 2.0, qc=0.1, w=0.2, wave=0.0)


def model_of(terms):
    """Along a motion, and the torque of the terms on their joint, (N,)."""
    seen = context_of(pa10(), wandering(7, seed=3), 6.0)
    known = contextualised(seen, terms, seen.rigid, None)
    return known, sum(torque_of(term, known) for term in terms)[:, JOINT]


@pytest.mark.parametrize("other", [STRIBECK, LOAD, SPOT], ids=lambda term: term.effect_id)
def test_levels_add_up_on_one_bristle(other):
    """dF/dt = σ0·(q̇ - |q̇|·F/level): Canudas de Wit et al. (1995), without its dampings."""
    known, found = model_of([BRISTLE, other])
    q, dq, load = known.q[:, JOINT], known.dq[:, JOINT], known.load[:, JOINT]
    more = {
        "stribeck": FS * np.exp(-np.abs(dq) / VS),
        "load_friction": MU * np.abs(load),
        "position_friction": 2.0 * np.exp(-0.5 * ((q - 0.1) / 0.2) ** 2),
    }
    level = F + more[other.effect_id]

    def lugre(t, force):
        v, here = np.interp(t, known.t, dq), np.interp(t, known.t, level)
        return STIFFNESS * (v - abs(v) * force / here)

    exact = solve_ivp(
        lugre, (0, known.t[-1]), [0.0], t_eval=known.t, method="LSODA", max_step=DT, rtol=1e-7
    ).y[0]
    assert rms(found - exact) < 0.01 * rms(exact)
    at_once = F * np.sign(dq) + more[other.effect_id] * np.sign(dq)
    assert rms(at_once - exact) > 0.1 * rms(exact)


def test_without_bristles_it_turns_round_at_once():
    known, found = model_of([STRIBECK])
    dq = known.dq[:, JOINT]
    fast = np.abs(dq) > 0.05
    expected = FS * np.exp(-np.abs(dq) / VS) * np.sign(dq)
    assert found[fast] == pytest.approx(expected[fast], rel=0.02)


def test_of_samples_that_stand_apart_it_slides():
    seen = replace(context_of(pa10(), wandering(7, seed=3), 6.0), apart=True)
    terms = [BRISTLE, STRIBECK]
    known = contextualised(seen, terms, seen.rigid, None)
    found = sum(torque_of(term, known) for term in terms)[:, JOINT]
    dq = seen.dq[:, JOINT]
    fast = np.abs(dq) > 0.05
    level = F + FS * np.exp(-np.abs(dq) / VS)
    assert found[fast] == pytest.approx((level * np.sign(dq))[fast], rel=1e-3)


@pytest.mark.parametrize("corner", [1e-4, 0.004])
@pytest.mark.parametrize("other", [STRIBECK, SPOT], ids=lambda term: term.effect_id)
def test_all_friction_of_a_joint_turns_round_over_one_speed(other, corner):
    """As its Coulomb friction does: without it Stribeck friction of 0.15 rad/s took 7.5 mrad/s."""
    known, found = model_of([own("coulomb", F, v0=corner), other])
    alone = torque_of(other, known)[:, JOINT]
    level = other.coefficients[0] * other.effect.level(known, other.joints, other.shape)
    assert np.allclose(alone, level * known.sign(known.dq[:, JOINT], corner))
    assert np.allclose(found - alone, F * known.sign(known.dq[:, JOINT], corner))
