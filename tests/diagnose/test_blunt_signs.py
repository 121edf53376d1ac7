"""Friction that turns round over a wide speed, as published of a Panda (a sigmoid 0.36 rad/s wide):
it is Coulomb friction with a blunt sign, and hides nothing that lies on it."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import COULOMB, V0, recordings, textbook

from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.procedure import diagnose
from pa10d.effects.base import smooth_sign

WIDTH, EXTRA, SPEED = 0.36, 1.5, 0.06  # rad/s, N·m, rad/s


def found_in(peak: float) -> Diagnosis:
    """peak: N·m of Stribeck friction on the first joint, beside the sigmoid."""

    def instead_of_the_sharp_one(t, q, dq, ddq):
        v, sharp = dq[:, 0], smooth_sign(dq[:, 0], V0)
        blunt = COULOMB[0] * (np.tanh(v / WIDTH) - sharp)
        return np.column_stack([blunt + peak * np.exp(-((v / SPEED) ** 2)) * sharp, 0.0 * v])

    runs = recordings(0, instead_of_the_sharp_one)
    fit, held = [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    return diagnose(textbook(runs), fit, held)


@pytest.mark.long
def test_a_blunt_sign_is_no_effect_that_is_missing():
    found = found_in(0.0)
    assert (found.verdict, found.findings) == ("none", ())
    assert np.all(found.left.ratio < 1.1)


@pytest.mark.long
def test_extra_friction_at_low_speed_is_told_on_a_blunt_sign():
    """Found beside a sharp one it left 3.5 times the noise; the sign, which no sample then said
    anything of, stayed sharp."""
    found = found_in(EXTRA)
    (finding,) = found.findings
    assert (finding.term.effect_id, finding.term.joints) == ("stribeck", (0,))
    for name, true in (("Fs", EXTRA), ("vs", SPEED)):
        value = finding.parameters[name]
        assert abs(value.value - true) < 3 * value.std_error
    blunt = next(t for t in found.model.terms if t.effect_id == "coulomb")
    assert abs(blunt.shape["v0"] - WIDTH) < 0.05 * WIDTH
    assert np.all(found.left.ratio < 1.1)
    # what it is compared with has the sign that suits it without the finding
    assert found.rms[0] < 1.05 * found.as_given.rms[0]
