"""Data sets with known answers: like each other for one seed, within limits, and telling."""

import csv
import gzip
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from plant_robots import seven_axes

from backends.virtual.datasets import (
    KINDS,
    figures_of,
    make_runs,
    motion_of,
    random_effect,
    reach_of,
    write_csv,
)
from backends.virtual.datasets.draws import DRAWS

ROOT = Path(__file__).parents[2]


def test_same_seed_same_numbers():
    one, truth = make_runs(7, seconds=1.0)
    two, same = make_runs(7, seconds=1.0)
    assert tuple(one) == KINDS
    assert truth == same
    for kind in KINDS:
        np.testing.assert_array_equal(one[kind].tau, two[kind].tau)
        np.testing.assert_array_equal(one[kind].q, two[kind].q)
    other, _ = make_runs(8, seconds=1.0)
    assert not np.array_equal(one["train_a"].q, other["train_a"].q)


def test_reference_is_the_same_arm_before():
    runs, _ = make_runs(
        7,
        [{"effect": "payload", "mass": 3.0, "cz": 0.1}],
        noise="none",
        kinds=("ref_a", "train_a"),
        seconds=1.0,
    )
    plain, _ = make_runs(7, noise="none", kinds=("ref_a", "train_a"), seconds=1.0)
    np.testing.assert_array_equal(runs["ref_a"].tau, plain["ref_a"].tau)
    assert np.abs(runs["train_a"].tau - plain["train_a"].tau).max() > 1.0


@pytest.mark.parametrize("kind", [*KINDS, "sweep"])
def test_motions_are_smooth_and_within_limits(kind):
    reach = reach_of(seven_axes())
    t = np.arange(0, 40, 0.01)
    for seed in range(5):
        q, dq, ddq = motion_of(kind, np.random.default_rng(seed), reach, 40.0).sample(t)
        assert np.all(q >= reach.lower)
        assert np.all(q <= reach.upper)
        assert np.all(np.abs(dq) <= 0.76 * reach.speed)
        np.testing.assert_allclose(np.gradient(q, 0.01, axis=0)[1:-1], dq[1:-1], atol=0.02)
        middle = np.abs(np.gradient(dq, 0.01, axis=0) - ddq)[1:-1]
        assert np.quantile(middle, 0.99) < 0.05 * np.abs(ddq).max()


def test_runs_stay_near_their_motion_and_stop_in_pauses():
    run = make_runs(3, kinds=("valid_b",), seconds=20.0)[0]["valid_b"]
    still = np.mean(np.diff(run.q, axis=0) == 0, axis=0)
    assert np.all(still > 0.02)
    assert np.abs(np.diff(run.q, axis=0)).max() < 0.002 * 2 * np.pi


@pytest.mark.long
@pytest.mark.parametrize("name", DRAWS)
def test_drawn_effect_shows_in_the_torque(name):
    """Against the same arm without it, same motion, no noise: it is there, where it was put."""
    figures = figures_of(seven_axes())
    drawn = random_effect(np.random.default_rng(11), name, figures)
    kinds = ("train_a", "train_b")
    with_it, truth = make_runs(2, [drawn], "none", kinds, seconds=8.0)
    without, _ = make_runs(2, [], "none", kinds, seconds=8.0)
    assert truth["effects"] == [drawn]
    joints = drawn.get("joints", [drawn["joint"]] if "joint" in drawn else range(1, 8))
    change = np.max(
        [np.std(with_it[k].tau - without[k].tau, axis=0) for k in kinds], axis=0
    ) + np.max([np.abs(np.mean(with_it[k].tau - without[k].tau, axis=0)) for k in kinds], axis=0)
    assert np.max(change[[j - 1 for j in joints]] / figures.noise[[j - 1 for j in joints]]) > 0.5
    assert np.all(np.isfinite(with_it["train_a"].tau))


def test_csv_holds_what_was_recorded(tmp_path):
    effect = {"effect": "thermal_friction", "joint": 2, "loss": 0.4, "T": 5.0}
    run = make_runs(5, [effect], kinds=("train_a",), seconds=0.5, temperature=True)[0]["train_a"]
    write_csv(tmp_path / "a.csv.gz", run)
    with gzip.open(tmp_path / "a.csv.gz", "rt") as file:
        table = list(csv.DictReader(file))
    assert list(table[0]) == [
        "time",
        *(f"{c}{j}" for c in ("q", "tau", "temp") for j in range(1, 8)),
    ]
    assert len(table) == 250
    for name, values, half in (("q", run.q, 6e-8), ("tau", run.tau, 6e-5)):
        read = np.array([[float(row[f"{name}{j}"]) for j in range(1, 8)] for row in table])
        np.testing.assert_allclose(read, values, atol=half)
    assert float(table[-1]["temp2"]) > 25.5


@pytest.mark.long
def test_script_writes_sets(tmp_path):
    command = [sys.executable, "scripts/make_datasets.py", "--out", str(tmp_path), "--seed", "3"]
    subprocess.run([*command, "--effect", "payload", "--seconds", "2"], cwd=ROOT, check=True)
    files = {p.name for p in (tmp_path / "set003").iterdir()}
    assert {f"{k}.csv.gz" for k in (*KINDS, "ref_a", "ref_b")} < files
    truth = json.loads((tmp_path / "set003" / "truth.json").read_text())
    assert truth["effects"][0]["effect"] == "payload"
    assert (tmp_path / "set003" / "robot.urdf").exists()
