"""A version fitted to other motion than its parent is held against the parent's runs, too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from two_links import NAMES, RATE, URDF, motion, recordings, textbook, textbook_torque

from pa10d.cli import main
from pa10d.judgement import worse_elsewhere
from pa10d.measurement.recording import Recording

FASTER = 4.0


def offset(t, q, dq, ddq):
    return np.column_stack([np.full(len(t), 1.5), np.zeros(len(t))])


def slow(seed: int) -> Recording:
    """The same arm a quarter as fast, after the zero of joint 1's drive was set anew."""
    t, q, dq, ddq = motion(seed)
    t, dq, ddq = t * FASTER, dq / FASTER, ddq / FASTER**2
    rng = np.random.default_rng(seed)
    tau = textbook_torque(q, dq, ddq) + offset(t, q, dq, ddq)
    grid = np.arange(0.0, t[-1], 1.0 / RATE)
    q, tau = (np.column_stack([np.interp(grid, t, x) for x in m.T]) for m in (q, tau))
    return Recording(f"slow_{seed}", grid, q, tau + 0.05 * rng.standard_normal(tau.shape))


@pytest.fixture(scope="module")
def fast():
    return recordings(0)


@pytest.fixture(scope="module")
def store(fast, tmp_path_factory):
    """m0 from fast motion, and slow motion that asks for what it did not need."""
    folder = tmp_path_factory.mktemp("elsewhere")
    (folder / "two.urdf").write_text(URDF)
    profile = folder / "two.yaml"
    profile.write_text("urdf: two.urdf\n")
    data = str(folder / "data")
    runs = [fast["fit_a"], fast["fit_b"], slow(11), slow(12)]
    for run in runs:
        file = folder / f"{run.name}.csv"
        columns = np.column_stack([run.t, run.q, run.tau])
        np.savetxt(file, columns, "%.9g", ",", header="time,q1,q2,tau1,tau2", comments="")
        assert main(["--data", data, "run", "import", str(file), "--profile", str(profile)]) == 0
    identify = ["identify", *NAMES[:2], "--profile", str(profile), "--name", "m0"]
    assert main(["--data", data, *identify]) == 0
    return data


@pytest.mark.long
@pytest.mark.parametrize(
    "command",
    [
        ["add", "m0", "torque_offset", "--joint", "1", "--fit", "slow_11", "slow_12"],
        ["improve", "m0", "--fit", "slow_11", "--validate", "slow_12"],
    ],
    ids=["add", "improve"],
)
def test_what_rises_on_the_parents_own_runs_is_said(store, capsys, command):
    assert main(["--data", store, *command, "--name", command[0]]) == 0
    said = capsys.readouterr().err
    assert "on fit_a, fit_b, which m0 was fitted to, its error rises from" in said
    assert "fit to those runs as well" in said


@pytest.mark.long
def test_nothing_is_said_of_a_version_fitted_to_them(store, capsys):
    command = ["add", "m0", "torque_offset", "--joint", "1", "--name", "both", "--fit"]
    assert main(["--data", store, *command, *NAMES[:2], "slow_11"]) == 0
    assert "was fitted to" not in capsys.readouterr().err


def test_only_joints_that_are_worse_are_named(fast):
    model = textbook(fast)
    assert worse_elsewhere(model, model, [fast["fit_a"]]) == []
    joint = next(k for k, term in enumerate(model.terms) if term.joints == (1,))
    wrong = replace(model.terms[joint], coefficients=model.terms[joint].coefficients * 3.0)
    terms = (*model.terms[:joint], wrong, *model.terms[joint + 1 :])
    (line,) = worse_elsewhere(model, replace(model, terms=terms), [fast["fit_a"]])
    assert line.startswith("joint 2: on fit_a, which m0 was fitted to")
