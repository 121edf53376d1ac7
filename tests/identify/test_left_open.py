"""A number whose interval allows more torque than there is to explain is no value."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

from pa10d.identify import identify
from pa10d.model.parameters import parameter_list
from pa10d.regression.solution import solve
from pa10d.regression.told import left_open
from pa10d.regression.triangle import Triangle

sys.path.append(str(Path(__file__).parents[2] / "scripts"))
bench_real = importlib.import_module("bench_real")

TORQUE, REST = np.array([10.0, 2.0]), np.array([0.5, 0.1])


def opened(value, error, peaks, added=False):
    columns = np.array([[peak] for peak in peaks])
    return bool(
        left_open(np.array([value]), np.array([error]), columns, TORQUE, REST, np.array([added]))[0]
    )


def test_next_to_nothing_is_known_well():
    assert not opened(0.001, 0.003, (1.0, 0.0))
    assert not opened(0.001, 0.003, (1.0, 1.0), added=True)


def test_what_allows_more_than_the_joints_torque_is_open():
    assert opened(3.0, 6.0, (1.0, 0.0))
    assert not opened(3.0, 4.0, (1.0, 0.0))
    assert opened(3.0, 4.0, (1.0, 1.0))  # a joint that carries less feels it, too
    assert not opened(7.0, 6.0, (1.0, 1.0))  # it is seven, whatever else holds it up


def test_what_was_added_is_held_against_the_error_that_is_left():
    assert opened(0.2, 0.4, (1.0, 0.0), added=True)
    assert not opened(0.2, 0.4, (1.0, 0.0))


@pytest.mark.long
def test_a_stribeck_torque_that_nobody_saw_is_not_printed(shared_data):
    robot = bench_real.robot_from_urdf(shared_data / "kr300" / "robot.urdf")
    runs = [bench_real.load("kr300", f"train{k}.csv", robot.n) for k in (1, 2)]
    model = identify(runs, robot, name="m", cutoff=10.0, with_effects=["stribeck"])
    told = {p.name: p for p in parameter_list(model) if p.name.endswith(": Fs")}
    unsure = {n for n, p in told.items() if p.value.std_error_random > abs(p.value.value)}
    assert unsure
    assert all("not determined" in told[name].flags for name in unsure)
    assert "coulomb J1: Fc" not in model.left_open
    (line,) = [w for w in model.notes.warnings if "standard error above 30 %" in w]
    assert "not determined" in line


def test_a_column_that_is_rounding_is_none():
    """A held joint's own inertia "was" -4e11 kg·m², and its error 5e11 N·m."""
    rng = np.random.default_rng(1)
    moves, rounding = rng.normal(size=(400, 2)), 1e-13 * rng.normal(size=400)
    torque = moves @ [2.0, -1.0] + rng.normal(size=400)
    triangle = Triangle(4)
    triangle.add(moves, rounding, torque)
    found = solve([triangle], [np.arange(3)], 3, np.ones(1))
    assert found.beta == pytest.approx([2.0, -1.0, 0.0], abs=0.2)
    assert list(found.open) == [2]


@pytest.mark.parametrize(("trusted", "size"), [(0.07, 0.24), (2.0, 0.24), (1.0, 0.0)])
def test_a_faint_direction_is_measured_by_the_noise_that_the_fit_leaves(trusted, size):
    """Joints that stand are trusted less by what friction does there: 30 times, and a direction in
    which lay nearly all of what the model left was called lost, "the motion does not show" it."""
    rng = np.random.default_rng(2)
    first, other = rng.normal(size=(2, 4000))
    torque = 3.0 * first + size * other + 0.07 * rng.normal(size=4000)
    triangle = Triangle(3)
    triangle.add(first, first + 4e-6 * other, torque)
    found = solve([triangle], [np.arange(2)], 2, np.array([trusted]))
    assert found.rank == (2 if size else 1)
