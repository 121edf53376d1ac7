"""The report of a model holds what a reviewer asks for; figures stand as they are elsewhere."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from backends.virtual.datasets import make_runs
from pa10d.cli import main
from pa10d.common.errors import UserError
from pa10d.effects import Value
from pa10d.model import ModelNotes, Term
from pa10d.model.parameters import flags, parameter_list
from pa10d.services.dossier import dossier, write_model_report
from pa10d.services.library import open_library
from pa10d.services.models import compare_runs, identify_runs
from pa10d.services.robots import load_robot
from pa10d.store import Channels, Samples


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """A textbook model of the whole arm on one run, and a run that it has not seen."""
    data = tmp_path_factory.mktemp("dossier")
    made = open_library(data)
    profile, robot = load_robot("pa10-sim")
    runs = make_runs(5, [], "white", ("train_a", "valid_a"), profile, seconds=8.0)[0]
    for name, run in runs.items():
        stamps = (run.t * 1e9).round().astype("int64")
        channels = Channels(joints=robot.joint_names)
        with made.runs.building(name, name, channels, profile) as writer:
            writer.append(Samples(stamps, run.q, run.tau))
    identify_runs(made, ["train_a"], str(profile.path), name="m0")
    return made


def test_it_holds_what_a_reviewer_asks_for(library, tmp_path):
    path = write_model_report(library, "m0", tmp_path / "m0.html", ["valid_a"])
    text = path.read_text(encoding="utf-8")
    for section in (
        "The robot", "The runs and their motion", "The identification", "Parameters",
        "Validation", "Versions", "Joint 7",
    ):  # fmt: skip
        assert f'data-title="{section}"' in text
    for asked in ("Condition number", "Low-pass", "train_a", "valid_a", "standard error", "URDF"):
        assert asked in text
    assert "which no fit of this model has seen" in text
    loads = r"<(script|link|img|iframe)[^>]+(src|href)=.?https?:"
    assert not re.search(loads, text), "it opens without a network"
    assert str(tmp_path) not in text


@pytest.mark.long
def test_its_errors_are_those_of_a_comparison(library):
    found = dossier(library, "m0", ["valid_a"])
    compared = compare_runs(library, "m0", ["valid_a"])
    np.testing.assert_array_equal(
        found.comparison.pooled.scores.rms, compared.comparison.pooled.scores.rms
    )
    fit, judge = found.runs
    assert (fit.use, judge.use) == ("fit", "judge")
    speed = np.abs(np.gradient(library.runs.recording(library.runs.find("train_a")).q, axis=0))
    np.testing.assert_allclose(fit.speed, speed.max(axis=0) * fit.rate, rtol=0.1)


@pytest.mark.long
def test_a_run_on_both_sides_is_said_to_be(library):
    found = dossier(library, "m0", ["train_a", "valid_a"])
    assert found.seen == "some of which it was fitted to"
    assert [run.use for run in found.runs] == ["fit and judge", "judge"]


def test_runs_that_a_search_judged_by_are_told_too(library):
    found = dossier(library, "m0", ["train_a"], searched=["train_a", "valid_a"])
    assert [(run.name, run.use) for run in found.runs] == [
        ("train_a", "fit and judge"), ("valid_a", "judge in the search"),
    ]  # fmt: skip


def test_a_reviewer_reads_each_effect_once_and_where_errors_come_from(library, tmp_path):
    path = write_model_report(library, "m0", tmp_path / "m0.html", ["valid_a"])
    text = path.read_text(encoding="utf-8")
    assert "viscous (joints 1 to 7)" in text
    assert "the torque constants, which are known to 5 % or so" in text
    longest = max(parameter_list(library.models.load("m0")), key=lambda one: len(one.meaning))
    assert f'<td class="text">{longest.meaning}</td>' in text, "it breaks, and is not cut off"


def test_what_was_chosen_is_at_no_bound(library):
    model = library.models.load("m0")
    term = replace(
        Term.of("coupling_friction", (2, 3), {"ratio": 1.0, "viscous": 1.0}),
        shape_errors={"ratio": 0.0, "viscous": 0.0},
    )
    p = len(model.covariance) + term.width
    known = replace(model, terms=(*model.terms, term), covariance=np.eye(p), notes=ModelNotes())
    (ratio,) = (one for one in parameter_list(known) if one.name.endswith("ratio"))
    assert "at its bound" not in ratio.flags


def test_the_urdf_stands_beside_each_base_parameter(library):
    model = library.models.load("m0")
    rows = parameter_list(model)
    inertial = [row.urdf for row in rows if row.urdf is not None]
    expected = model.base.matrix() @ model.robot.parameters.ravel()
    np.testing.assert_allclose(inertial, expected, atol=1e-12)
    assert all(row.urdf is None for row in rows[len(inertial) :])


@pytest.mark.parametrize(
    ("value", "bounds", "said"),
    [
        (Value(1.0, 0.1, "kg"), None, []),
        (Value(1.0, 0.31, "kg"), None, ["weak"]),
        (Value(1.0, 0.1, "kg", determined=False), None, ["not determined"]),
        (Value(2.0, 0.1, "rad/s"), (0.0, 2.0), ["at its bound"]),
        (Value(0.0, 0.1, "rad/s"), (0.0, 2.0), ["at its bound", "weak"]),
    ],
)
def test_what_is_to_be_known_of_a_value(value, bounds, said):
    assert flags(value, bounds) == said


def test_the_command_writes_it(library, tmp_path, capsys):
    out = tmp_path / "own.html"
    data = str(library.models.folder.parent)
    arguments = ["--data", data, "model", "report", "m0", "--runs", "valid_a", "--out", str(out)]
    assert main(arguments) == 0
    assert capsys.readouterr().out.strip() == str(out)
    assert out.stat().st_size > 1e6


def test_a_run_that_is_not_there_is_a_line(library, tmp_path):
    with pytest.raises(UserError, match="run 'nowhere'"):
        write_model_report(library, "m0", tmp_path / "m0.html", ["nowhere"])
    assert not (tmp_path / "m0.html").exists()
