"""Which numbers of a term are told as estimates."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.effects import all_effects, effect
from pa10d.model import Term
from pa10d.model.estimates import as_estimates, no_estimates, not_one


def told(name, coefficients, errors, shape=(), shape_errors=(), joints=(0,), less=False):
    term = Term(name, joints, np.array(coefficients), dict(shape), dict(shape_errors))
    covariance = np.diag(np.square(errors))
    values = term.effect.values(term.coefficients, covariance, term.shape, term.shape_errors)
    return term, as_estimates(term, values, less)


def test_a_size_that_may_as_well_be_nothing_is_not_told():
    """Bristles beside dry friction of which nothing tells them apart: "F = 0.49 ± 1 N·m"."""
    shape, errors = {"zs": 0.01}, {"zs": 0.001}
    _, found = told("presliding_hysteresis", [0.49], [1.0], shape, errors)
    said = {name: str(value) for name, value in found.items()}
    assert said["F"] == said["sigma0"] == "not determined"
    assert said["zs"] == "0.01 ± 0.001 rad"
    _, found = told("presliding_hysteresis", [1.0], [0.98], shape, errors)
    assert str(found["F"]) == "not determined"
    _, found = told("presliding_hysteresis", [0.49], [0.1], shape, errors)
    assert all(value.determined for value in found.values())


def test_what_is_next_to_nothing_beside_what_is_known_is_told():
    _, found = told("coulomb_asymmetry", [0.5, 0.01], [0.02, 0.03])
    assert all(value.determined for value in found.values())


def test_what_follows_from_an_unknown_is_as_unknown():
    """A spring of which k is not determined had "q0 = -0.05 ± 0.92 rad"."""
    _, found = told("spring", [0.5, -0.03], [1.0, 0.1])
    assert {name: str(v) for name, v in found.items()} == dict.fromkeys(
        ("k", "q0"), "not determined"
    )
    _, found = told("spring", [0.5, -0.03], [0.01, 0.1])
    assert found["q0"].determined
    for kind in all_effects().values():
        k, shape = len(kind.coefficients), {s.name: s.upper for s in kind.shapes}
        names = kind.values(np.ones(k), np.eye(k), shape, dict.fromkeys(shape, 0.1))
        for name, needs in kind.derived.items():
            assert {name, *needs} <= set(names)


def test_what_a_spring_swings_with_is_unknown_where_its_mode_is():
    """It was told with "rotor = 0.00766 ± 0.0026 kg·m²" of a K of 2.1 ± 2.8 N·m/rad."""
    shape = {"K": 2.1, "zeta": 0.036, "rotor": 0.0077}
    sure = {"K": 0.1, "zeta": 0.01, "rotor": 0.001}
    term, found = told("joint_elasticity", [1.0], [0.1], shape, sure)
    assert all(found[name].determined for name in shape)
    assert not not_one(term, found)
    term, found = told("joint_elasticity", [1.0], [2.0], shape, sure | {"K": 2.8})
    assert not any(found[name].determined for name in shape)
    assert not_one(term, {name: found[name] for name in shape})


def test_a_spring_of_which_there_may_as_well_be_nothing_has_no_stiffness():
    """A motor without a gear was told "share = 1.03 ± 0.8, K = 0.51 ± 0.072 N·m/rad"."""
    shape, sure = {"K": 0.51, "zeta": 0.05, "rotor": 1e-4}, {"K": 0.07, "zeta": 0.01, "rotor": 1e-5}
    term, found = told("joint_elasticity", [1.03], [0.8], shape, sure)
    assert not any(found[name].determined for name in shape)
    assert not_one(term, found)


def test_a_rotor_is_a_part_of_what_its_joint_moves():
    """Load friction was told with "rotor = 0.2094 ± 0.063 kg·m²" of a joint of 0.11 in all."""
    shape = {"v0": 0.05, "rotor": 0.2094}
    term = Term("load_friction", (0,), np.array([0.07]), shape, {"rotor": 0.063})
    values = term.effect.values(
        term.coefficients, np.diag([0.006**2]), term.shape, term.shape_errors
    )
    found = as_estimates(term, values, False, 0.11)
    assert str(found["rotor"]) == "no estimate"
    assert found["mu"].determined
    assert "rotor comes out at 0.209 kg·m², and all that the joint moves is less" in no_estimates(
        term, found
    )
    assert as_estimates(term, values, False, 0.25)["rotor"].determined


def test_a_ripple_that_may_as_well_be_nothing_has_no_order():
    """It was told as "N = 8.486 ± 0.63 cycles/rev, amplitude = 0.021 ± 0.048 N·m"."""
    _, found = told("torque_ripple", [0.015, 0.015], [0.048, 0.048], {"N": 8.486}, {"N": 0.63})
    assert str(found["amplitude"]) == str(found["N"]) == "not determined"
    _, found = told("torque_ripple", [0.015, 0.015], [0.005, 0.005], {"N": 8.486}, {"N": 0.63})
    assert found["amplitude"].determined
    assert found["N"].determined


def test_a_stiffness_that_may_as_well_be_endless_is_none():
    """A gear of 4.6e6 N·m/rad by its own encoders was told as 5.5e4 ± 4.3e4."""
    shape = {"K": 5.49e4, "zeta": 0.1}
    for error, determined in ((4.3e4, False), (2e4, True)):
        _, found = told("joint_elasticity", [1.0], [0.1], shape, {"K": error, "zeta": 0.01})
        assert found["K"].determined is determined


def test_choices_are_no_numbers():
    shape = {"qs": 0.1, "side": 1.0}
    term, found = told("contact", [1.0], [2.0], shape, {"qs": 10.0})
    assert found["side"].determined
    assert not_one(term, found)


@pytest.mark.parametrize("value", [0.5, 0.62, -0.7])
def test_a_tilt_beyond_what_a_tilt_may_be_is_no_estimate(value):
    """It was told to 0.04 mrad."""
    term, found = told("base_tilt", [0.02, value, 0.0, 0.0], [1e-4] * 4, joints=())
    assert str(found["ry"]) == "no estimate"
    assert not found["ry"].determined
    assert str(found["rx"]) == "0.02 ± 0.0001 rad"
    said = no_estimates(term, found)
    assert said.startswith(f"base_tilt: ry comes out at {value:g} rad, the end of what it may be")
    assert "(-0.5 to 0.5)" in said


def test_friction_below_nothing_beyond_its_doubt_is_no_estimate():
    term, found = told("coupling_friction", [0.8, -0.2], [0.05, 0.01], {"ratio": 1.0}, (), (0, 1))
    assert (str(found["F"]), str(found["D"])) == ("0.8 ± 0.05 N·m", "no estimate")
    assert "D comes out at -0.2 N·m·s/rad, and nothing has less than none" in no_estimates(
        term, found
    )
    term, found = told("coulomb", [-0.3], [0.01], {"v0": 0.01}, {"v0": 0.001})
    assert "its torque or its angle counts the other way" in no_estimates(term, found)
    term, found = told("coulomb", [-0.01], [0.01], {"v0": 0.01}, {"v0": 0.001})
    assert not found["Fc"].beyond
    assert no_estimates(term, found) == ""


def test_of_what_there_is_there_may_be_less():
    _, found = told("coulomb", [-0.8], [0.01], {"v0": 0.01}, {"v0": 0.001}, less=True)
    assert str(found["Fc"]) == "-0.8 ± 0.01 N·m"


def test_a_shape_that_was_stopped_at_its_end_is_no_estimate():
    kind = effect("stribeck")
    lowest = next(s for s in kind.shapes if s.name == "delta").lower
    shape, errors = {"vs": 0.2, "delta": lowest}, {"vs": 0.01, "delta": 0.05}
    _, found = told("stribeck", [1.0], [0.01], shape, errors)
    assert str(found["delta"]) == "no estimate"
    _, given = told("stribeck", [1.0], [0.01], shape, {"vs": 0.01})
    assert not given["delta"].beyond


def test_a_share_is_none_of_a_spring_s_numbers():
    """K 1800 ± 6400 and zeta 0.4 ± 8, but a share of 1.2 ± 0.2: nothing was said of it."""
    shape, errors = {"K": 1800.0, "zeta": 0.4}, {"K": 6400.0, "zeta": 8.5}
    term, found = told("joint_elasticity", [1.18], [0.21], shape, errors)
    assert found["share"].determined
    assert not_one(term, found)


def test_an_end_that_is_the_fields_own_law_is_an_estimate():
    """Armstrong's exponent of 2: "no estimate, but where something else has drawn it"."""
    shape, errors = {"vs": 0.2, "delta": 2.0}, {"vs": 0.01, "delta": 0.12}
    term, found = told("stribeck", [1.0], [0.01], shape, errors)
    assert str(found["delta"]) == "2 ± 0.12"
    assert no_estimates(term, found) == ""


def test_a_small_value_of_a_wide_range_is_an_estimate():
    """A rotor of 0.4 kg·m², where a robot's largest may have 1000."""
    shape = {"v0": 0.01, "rotor": 0.4}
    _, found = told("load_friction", [0.1], [0.01], shape, {"v0": 0.001, "rotor": 0.02})
    assert str(found["rotor"]) == "0.4 ± 0.02 kg·m²"
    nothing = {"v0": 0.01, "rotor": 0.0}
    _, found = told("load_friction", [0.1], [0.01], nothing, {"v0": 0.001, "rotor": 0.02})
    assert not found["rotor"].beyond


def test_a_damping_is_told_that_needs_no_inertia_to_be_read():
    """Beside the ratio: of another median of the inertia than was meant, the damping that a reader
    works out from it was 15 to 30 % off, beside an error of 1 %. Its error is that of draws."""
    shape, errors = {"K": 900.0, "zeta": 0.06, "rotor": 0.5}, {"K": 30.0, "zeta": 0.003}
    term, found = told("joint_elasticity", [1.0], [0.01], shape, errors | {"rotor": 0.1})
    damping = term.effect.beside_link(found, 2.5)["C"]
    rng = np.random.default_rng(1)
    k, zeta, rotor = (
        value + error * rng.standard_normal(20_000)
        for value, error in ((900.0, 30.0), (0.06, 0.003), (0.5, 0.1))
    )
    draws = 2.0 * zeta * np.sqrt(k * (2.5 - rotor))
    assert damping.value == pytest.approx(np.mean(draws), rel=0.01)
    assert damping.std_error == pytest.approx(np.std(draws), rel=0.05)
    assert str(damping).endswith(" N·m·s/rad")
    _, unsure = told("joint_elasticity", [1.0], [2.0], shape, errors | {"K": 1200.0})
    assert not term.effect.beside_link(unsure, 2.5)["C"].determined
