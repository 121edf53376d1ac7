"""A fit says what it sees; whether an effect is missing is for a diagnosis alone to say."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from pa10d.identify.advice import _cost, warnings_of
from pa10d.model import Term


def test_a_fit_that_bodies_cannot_follow_claims_no_missing_effect():
    """The diagnosis of the same data may find that nothing is missing; one verdict at a time."""
    joint = SimpleNamespace(
        n=1,
        angle_unit=lambda j: "rad",
        torque_unit=lambda j: "N·m",
        joint_names=("a",),
        parameters=np.zeros((1, 10)),
    )
    layout = SimpleNamespace(
        robot=joint, base=[], names=lambda: ["Fv1"], owners=lambda: [0], terms=(), places=()
    )
    solution = SimpleNamespace(beta=np.array([-0.4]), lost=np.zeros((1, 0)), scale=np.ones(1))
    fit = SimpleNamespace(
        solution=solution,
        uncertainty=SimpleNamespace(covariance=np.array([[1e-6]])),
        rms=np.array([0.5]),
        torque=np.array([20.0]),
        open=np.array([False]),
    )
    feasible = SimpleNamespace(
        found=True,
        converged=True,
        coefficients=np.zeros(1),
        rms=np.array([0.6]),
        edge=np.array([False]),
    )

    def said(feasible):
        return warnings_of(
            layout,
            fit,
            feasible,
            SimpleNamespace(found=np.array([True]), v0=np.array([0.01])),
            SimpleNamespace(seconds=0.0, estimate=0.0, std_error=0.0, slow=np.nan),
            None,
            SimpleNamespace(
                range=np.array([2.0]), reversals=np.array([9]), hidden=np.array([False])
            ),
        )

    left = "joint 1 (a): feasible parameters leave 20 % more error (0.6 instead of 0.5 N·m): "
    assert [one.split(";")[0] for one in said(feasible)] == [
        "Fv1 is -0.4 in the free fit and 0, its bound, in the feasible one: as it is, nothing can "
        "have it",
        f"{left}nothing that can exist explains all of it",
    ]
    assert all(
        one.endswith("whether an effect is missing, a diagnosis says") for one in said(feasible)
    )
    rubs = Term("coulomb", (0,), np.zeros(1))
    layout.terms, layout.places = (rubs,), (slice(0, 1),)
    assert "does its torque, or its angle, count the other way" in said(feasible)[0]
    fit.uncertainty.covariance = np.array([[0.0121]])
    assert "nothing can have it" in said(feasible)[0], "four standard errors are not reached"
    layout.terms, layout.places = (), ()
    fit.uncertainty.covariance = np.array([[1e-6]])
    feasible.converged = False
    assert said(feasible)[1:] == [f"{left}the search for better ones did not converge"]
    feasible.converged = True
    spring = Term("joint_elasticity", (0,), np.zeros(1), {"K": 100.0})
    layout.terms, layout.places = (spring,), (slice(0, 1),)
    assert said(feasible)[-1].startswith(f"{left}what was told does not fit (Fv1 out of bounds)")


def test_joints_that_bodies_cannot_follow_share_one_sentence():
    """One cause, however many joints show it: an arm of seven said it five times over."""
    robot = SimpleNamespace(torque_unit=lambda j: "N·m", joint_names=("a", "b", "c"))
    bounded, free = np.array([0.6, 0.9, 0.51]), np.array([0.5, 0.9, 0.5])
    assert _cost(robot, np.array([0, 2]), bounded, free) == (
        "joints 1, 3: feasible parameters leave 2 to 20 % more error "
        "(most on joint 1 (a): 0.6 instead of 0.5 N·m)"
    )
