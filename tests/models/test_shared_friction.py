"""What dry friction and bristles of one joint share is known of neither."""

from dataclasses import replace

import model_examples as examples
import numpy as np
import pytest

from pa10d.effects import Value
from pa10d.model import Term
from pa10d.model.shared_friction import beside_bristles

BRISTLES = Term("presliding_hysteresis", (1,), np.array([4.95]), {"zs": 0.0016}, {"zs": 2e-5})
SEEN = {
    "F": Value(4.95, 0.26, "N·m"),
    "zs": Value(0.0016, 2e-5, "rad"),
    "sigma0": Value(3045.0, 160.0, "N·m/rad"),
}


def dry(error: float, joint: int = 1) -> Term:
    return Term("coulomb", (joint,), np.array([1.54]), {"v0": 0.005}, {"v0": error})


def test_where_nothing_shows_how_sharp_dry_friction_is_either_may_carry_it():
    """Truth: 6.49 N·m and 4149 N·m/rad, all of it on bristles."""
    terms = [dry(0.0), BRISTLES]
    found = beside_bristles(terms, BRISTLES, SEEN)
    assert found["F"].std_error == pytest.approx(np.hypot(0.26, 1.54))
    assert abs(found["sigma0"].value - 4149.0) < 2.0 * found["sigma0"].std_error
    assert found["zs"] == SEEN["zs"]
    own = beside_bristles(terms, terms[0], {"Fc": Value(1.54, 0.1, "N·m")})
    assert own["Fc"].std_error == pytest.approx(np.hypot(0.1, 1.54))


def test_a_little_on_bristles_is_all_that_much_dry_friction_may_be_off_by():
    """1.82 ± 1.8 N·m stood beside 0.17 N·m of a cable, and it was 1.824."""
    cable = Term("presliding_hysteresis", (1,), np.array([0.17]), {"zs": 0.056}, {"zs": 0.019})
    terms = [dry(0.0), cable]
    own = beside_bristles(terms, terms[0], {"Fc": Value(1.54, 0.02, "N·m")})
    assert own["Fc"].std_error == pytest.approx(np.hypot(0.02, 0.17))
    found = beside_bristles(terms, cable, {"F": Value(0.17, 0.02, "N·m")})
    assert found["F"].std_error == pytest.approx(np.hypot(0.02, 0.17))


@pytest.mark.parametrize("other", [dry(0.0005), dry(0.0, joint=0)])
def test_where_it_shows_or_is_another_joint_the_parts_are_known(other):
    assert beside_bristles([other, BRISTLES], BRISTLES, SEEN) == SEEN


def test_a_model_tells_it():
    model = examples.with_effects(examples.textbook(), "presliding_hysteresis")
    where = len(model.terms) - 1
    joints = model.terms[where].joints

    def doubt(error: float) -> float:
        """Of the bristles' level, where dry friction's sharpness is known to that."""
        terms = tuple(
            replace(t, shape_errors={"v0": error})
            if t.effect.smoothed_over and t.joints == joints
            else t
            for t in model.terms
        )
        return replace(model, terms=terms).term_values(where)["F"].std_error

    sharp = 1e-3 * min(t.shape["v0"] for t in model.terms if t.effect.smoothed_over)
    assert doubt(0.0) > 1.5 * doubt(sharp)
