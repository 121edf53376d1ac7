"""A corner that is another one in each stretch is not known to the width of its parabola."""

import numpy as np
import pytest

from pa10d.identify.rows import Rows
from pa10d.identify.smoothing import FINE, _from_stretch_to_stretch

GRID = 0.01 * FINE


def rows(*corners: float) -> list[Rows]:
    """Dry friction of 1 N·m beside viscous friction, in stretches that have these corners."""
    speed = np.sin(np.linspace(0.0, 60.0, 20_000))
    out = []
    for v0 in corners:
        torque = np.tanh(speed / v0) + 0.3 * speed
        columns = np.column_stack([speed, *(np.tanh(speed / v) for v in GRID)])
        counts = np.ones((len(speed), 1), dtype=bool)
        out.append(Rows([columns], torque[:, None], counts, ~counts))
    return out


def test_a_corner_that_is_the_same_everywhere_is_known():
    assert _from_stretch_to_stretch(rows(*[0.01] * 6), [GRID])[0] < 1e-3


def test_a_corner_is_as_unsure_as_it_is_from_stretch_to_stretch():
    """Joints of 0.006 rad/s were told with 0.0047 ± 0.00008 and 0.00643 ± 0.0001: they went through
    it within a sample, each time in another part of that."""
    found = _from_stretch_to_stretch(rows(*[0.008, 0.0125] * 3), [GRID])[0]
    assert found == pytest.approx(np.log(0.0125 / 0.008) / 2.0 / np.sqrt(6.0 - 1.0), rel=0.3)


def test_what_was_not_looked_at_finely_is_not_judged():
    one = [Rows([r.columns[0][:, :2]], r.tau, r.keep, r.rest) for r in rows(0.005, 0.02)]
    assert _from_stretch_to_stretch(one, [GRID[:1]])[0] == 0.0
