"""Friction of a gear that two joints share, turning round as softly as that gear does."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import recordings, textbook

from pa10d.diagnose.procedure import diagnose

FORCE = 1.5  # N·m


@pytest.mark.long  # test_corners has a load's friction
@pytest.mark.parametrize("soft", [0.03, pytest.param(0.15, marks=pytest.mark.long)])  # rad/s
def test_its_size_does_not_depend_on_how_softly_it_turns_round(soft):
    """A sign that was sharper than the gear's left 10 to 39 times the noise, too small a friction
    and a viscous part that nobody had put in, seven standard errors from zero."""

    def gear(t, q, dq, ddq):
        rubs = FORCE * np.tanh((dq[:, 0] + dq[:, 1]) / soft)
        return np.column_stack([rubs, rubs])

    runs = recordings(5, gear, 0.02)
    found = diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    first = found.findings[0]
    assert (first.term.effect_id, first.term.joints) == ("coupling_friction", (0, 1))
    values = first.parameters
    assert values["F"].value == pytest.approx(FORCE, rel=0.02)
    assert values["v0"].value == pytest.approx(soft, rel=0.1)
    if "D" in values:
        assert abs(values["D"].value) < 3.0 * values["D"].std_error_random
    assert max(line.ratio for line in found.remaining) < 1.2


@pytest.mark.long
def test_both_motors_of_a_differential_rub():
    """Once the sum of the speeds had its friction, that of the difference was no suspect any more:
    80 times the floor, and "no effect that was looked for explains it"."""

    def differential(t, q, dq, ddq):
        of_sum = FORCE * np.tanh((dq[:, 0] + dq[:, 1]) / 0.02)
        of_difference = 0.6 * FORCE * np.tanh((dq[:, 0] - dq[:, 1]) / 0.02)
        return np.column_stack([of_sum + of_difference, of_sum - of_difference])

    runs = recordings(5, differential, 0.02)
    found = diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    by_ratio = {f.term.shape["ratio"]: f.parameters["F"] for f in found.findings}
    assert {f.term.effect_id for f in found.findings} == {"coupling_friction"}
    assert by_ratio[1.0].value == pytest.approx(FORCE, abs=3.0 * by_ratio[1.0].std_error)
    assert by_ratio[-1.0].value == pytest.approx(0.6 * FORCE, abs=3.0 * by_ratio[-1.0].std_error)
    assert max(line.ratio for line in found.remaining) < 1.2
