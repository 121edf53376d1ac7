"""Friction that is higher at low speed and builds up over a way: two effects that only together
make nothing worse where the joint turns round."""

from __future__ import annotations

import numpy as np
from two_links import COULOMB, RATE, V0, recordings, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.effects.base import smooth_sign

FS, VS, WAY = 4.0, 0.1, 1e-3  # N·m, rad/s, rad
SUBSTEPS = 10


def lugre(t, q, dq, ddq):
    """The first joint's Coulomb friction in a bristle: ż = v - |v|·z/zs(v), F = σ0·z (Canudas de
    Wit et al. 1995, without its dampings)."""
    speed = np.interp(np.arange(SUBSTEPS * len(t)) / SUBSTEPS, np.arange(len(t)), dq[:, 0])
    stiffness, step = COULOMB[0] / WAY, 1.0 / (RATE * SUBSTEPS)
    force, z = np.zeros(len(speed)), 0.0
    for k, v in enumerate(speed):
        level = COULOMB[0] + FS * np.exp(-((v / VS) ** 2))
        z = (z + step * v) / (1.0 + step * abs(v) * stiffness / level)
        force[k] = stiffness * z
    more = force[::SUBSTEPS] - COULOMB[0] * smooth_sign(dq[:, 0], V0)
    return np.column_stack([more, np.zeros(len(t))])


def test_stribeck_friction_of_a_bristle_is_named_with_the_bristle():
    """Stribeck friction alone made reversals worse and was refused; 18 times the floor stayed."""
    runs = recordings(3, lugre, 0.02)
    found = diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    named = [(f.term.effect_id, f.term.joints) for f in found.findings]
    assert named == [("stribeck", (0,)), ("presliding_hysteresis", (0,))]
    assert found.left.rms[0] < 0.3 * found.as_given.rms[0]
