"""What a person is told: derived parameters and their errors against Monte Carlo."""

import numpy as np
import pytest

from pa10d.effects import all_effects, effect

DRAWS = 40_000


def drawn(mean, errors, seed=0):
    """Coefficients drawn around ``mean`` with correlated errors, and their covariance."""
    rng = np.random.default_rng(seed)
    mixing = np.eye(len(mean)) + 0.4 * rng.standard_normal((len(mean), len(mean)))
    root = np.diag(errors) @ mixing
    return mean + rng.standard_normal((DRAWS, len(mean))) @ root.T, root @ root.T


@pytest.mark.parametrize(
    ("name", "mean", "errors", "derived"),
    [
        (
            "payload",
            [2.5, 0.05, -0.08, 0.3, *[0.01] * 6],
            [0.02, 0.002, 0.003, 0.004, *[0.005] * 6],
            {
                "mass": lambda x: x[:, 0],
                "cx": lambda x: x[:, 1] / x[:, 0],
                "cy": lambda x: x[:, 2] / x[:, 0],
                "cz": lambda x: x[:, 3] / x[:, 0],
            },
        ),
        ("spring", [14.0, -5.0], [0.3, 0.2], {"q0": lambda x: x[:, 1] / x[:, 0]}),
        (
            "torque_ripple",
            [1.2, -0.7],
            [0.04, 0.03],
            {"amplitude": lambda x: np.hypot(x[:, 0], x[:, 1])},
        ),
    ],
)
def test_derived_parameters_against_monte_carlo(name, mean, errors, derived):
    samples, covariance = drawn(np.array(mean), np.array(errors))
    found = effect(name).values(np.array(mean), covariance, {"N": 50.0}, {"N": 0.1})
    for key, function in derived.items():
        scatter = function(samples)
        assert found[key].value == pytest.approx(float(np.mean(scatter)), abs=0.03 * scatter.std())
        assert found[key].std_error == pytest.approx(float(scatter.std()), rel=0.03)


def test_bristle_stiffness_against_monte_carlo():
    rng = np.random.default_rng(1)
    force, reach = 6.0 + 0.1 * rng.standard_normal(DRAWS), 4e-3 + 1e-4 * rng.standard_normal(DRAWS)
    found = effect("presliding_hysteresis").values(
        np.array([6.0]), np.array([[0.01]]), {"zs": 4e-3}, {"zs": 1e-4}
    )["sigma0"]
    assert found.value == pytest.approx(1500.0)
    assert found.std_error == pytest.approx(float(np.std(force / reach)), rel=0.03)


def test_bristle_damping_against_monte_carlo():
    rng = np.random.default_rng(2)
    force, way, lag = (
        mean * (1.0 + spread * rng.standard_normal(DRAWS))
        for mean, spread in ((6.0, 0.02), (4e-3, 0.03), (0.01, 0.05))
    )
    found = effect("presliding_hysteresis").values(
        np.array([6.0]),
        np.array([[0.12**2]]),
        {"zs": 4e-3, "damped": 1.0, "lag": 0.01},
        {"zs": 1.2e-4, "lag": 5e-4},
    )["sigma1"]
    assert found.value == pytest.approx(15.0)
    assert found.unit == "N·m·s/rad"
    assert found.std_error == pytest.approx(float(np.std(force / way * lag)), rel=0.03)


def test_values_carry_units_and_hide_nuisances():
    for kind in all_effects().values():
        k = len(kind.coefficients)
        shape = {s.name: 0.5 * (s.lower + s.upper) for s in kind.shapes}
        found = kind.values(np.ones(k), 0.04 * np.eye(k), shape, dict.fromkeys(shape, 0.1))
        units = {c.name: c.unit for c in kind.coefficients} | {s.name: s.unit for s in kind.shapes}
        assert not {c.name for c in kind.coefficients if c.nuisance} & set(found)
        said = {s.name for s in kind.shapes if s.scale != "choice" or not s.optional}
        assert said <= set(found)
        for key, value in found.items():
            assert value.unit
            if key in units:
                assert value.unit == units[key]
                assert value.std_error == pytest.approx(0.1 if key in shape else 0.2)


def test_a_part_that_was_left_out_has_no_value():
    kind = effect("coupling_friction")
    shape = {"ratio": 1.0, "viscous": 0.0}
    assert set(kind.values(np.ones(2), np.eye(2), shape, {})) == {"F", "ratio", "viscous"}
    assert "D" in kind.values(np.ones(2), np.eye(2), {"ratio": 1.0}, {})


def test_what_own_heat_takes_is_told_per_watt():
    kind = effect("thermal_friction")
    for heated, per in ((0.0, ""), (1.0, "/W")):
        found = kind.values(np.ones(2), np.eye(2), {"T": 20.0, "heated": heated}, {})
        assert found["dFv"].unit == f"N·m·s/rad{per}"
        assert found["dFc"].unit == f"N·m{per}"


@pytest.mark.parametrize("name", ["spring", "payload", "torque_ripple", "presliding_hysteresis"])
def test_nothing_found_is_no_division_by_zero(name):
    kind = effect(name)
    k = len(kind.coefficients)
    shape = {s.name: s.lower for s in kind.shapes}
    for value in kind.values(np.zeros(k), np.zeros((k, k)), shape, {}).values():
        assert np.isfinite([value.value, value.std_error]).all()
    slightly_negative = -1e-18 * np.eye(k)  # what rounding makes of a covariance of zero
    for value in kind.values(np.zeros(k), slightly_negative, shape, {}).values():
        assert np.isfinite(value.std_error)


def test_a_share_that_its_law_settles_is_as_unsure_as_it_is_off():
    """All of the torque passes a gap: 0.896 ± 0.005 of it was told, where teeth were firmer than
    is taken for granted."""
    gap = effect("backlash")
    found = gap.values(np.array([0.896]), np.diag([0.005**2]), {"b": 0.007}, {"b": 0.0008})
    assert found["share"].std_error == pytest.approx(np.hypot(0.005, 0.104))
    assert found["share"].std_error_random == pytest.approx(0.005)
