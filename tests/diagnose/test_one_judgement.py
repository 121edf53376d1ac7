"""One model, one run, one band: one error, whichever command, document or report says it."""

from __future__ import annotations

import json
import re
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from same_error import assert_one_error
from two_links import CUTOFF, URDF, recordings, textbook

from pa10d.cli import main
from pa10d.daemon.jobs import tasks
from pa10d.judgement import MASK, judge
from pa10d.services import plots
from pa10d.services.library import open_library

PROFILE = "name: two\nurdf: two.urdf\nsimulation: {}\n"


def late_friction(t, q, dq, ddq):
    """A bump at low speed on the second joint."""
    extra = np.zeros((len(t), 2))
    v = dq[:, 1]
    extra[:, 1] = 1.2 * np.tanh(v / 0.02) / (1.0 + (v / 0.15) ** 2)
    return extra


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Runs of the two-link arm, its textbook model m0 and an improved m1."""
    place = tmp_path_factory.mktemp("one")
    (place / "two.urdf").write_text(URDF)
    (place / "two.yaml").write_text(PROFILE)
    for name, run in recordings(18, extra=late_friction).items():
        head = "time,q1,q2,tau1,tau2"
        table = np.column_stack([run.t, run.q, run.tau])
        np.savetxt(
            place / f"{name}.csv", table, delimiter=",", header=head, comments="", fmt="%.9g"
        )
    return place


@pytest.fixture(scope="module")
def said(store):
    """command -> its JSON."""
    profile = str(store / "two.yaml")

    def ask(capsys, *words: str):
        capsys.readouterr()
        assert main(["--data", str(store / "data"), "--json", *words]) == 0
        return json.loads(capsys.readouterr().out)

    return profile, ask


def test_every_way_of_asking_gives_one_figure(store, said, capsys):
    profile, ask = said
    for name in ("fit_a", "fit_b", "valid_a", "valid_b"):
        ask(capsys, "run", "import", str(store / f"{name}.csv"), "--profile", profile)
    fit, judge_by = ["fit_a", "fit_b"], ["valid_a", "valid_b"]
    made = ask(
        capsys, "identify", *fit, "--profile", profile, "--name", "m0", "--cutoff", str(CUTOFF)
    )
    on_fit = ask(capsys, "compare", "m0", *fit)
    assert same(made, on_fit["pooled"])

    compared = ask(capsys, "compare", "m0", *judge_by, "--report", str(store / "c.html"))
    truth = compared["pooled"]["rms"]
    frozen = ask(capsys, "diagnose", "m0", "--fit", *fit, "--validate", *judge_by, "--frozen")
    assert not frozen["refitted"]
    assert same(frozen, compared["pooled"])

    free = ask(
        capsys, "improve", "m0", "--fit", *fit, "--validate", *judge_by, "--name", "m1",
        "--report", str(store / "d.html"),
    )  # fmt: skip
    assert free["refitted"]
    np.testing.assert_allclose(free["rms_as_given"], truth, rtol=1e-4)
    delivered = ask(capsys, "compare", "m1", *judge_by)["pooled"]
    np.testing.assert_allclose(free["promised"], delivered["rms"], rtol=1e-3)
    np.testing.assert_allclose(free["achieved"], delivered["rms"], rtol=1e-4)
    np.testing.assert_allclose([r["rms"] for r in free["remaining"]], delivered["rms"], rtol=1e-4)
    np.testing.assert_allclose(free["findings"][-1]["rms_after"], delivered["rms"], rtol=1e-4)

    assert_one_error(partial(ask, capsys), str(store / "data"), store, free, store / "d.html")

    line = ask(capsys, "model", "history", "m1", "--runs", *judge_by)
    assert len({(entry["cutoff_hz"], entry["mask"], *entry["runs"]) for entry in line}) == 1
    np.testing.assert_allclose(line[0]["rms"], truth, rtol=1e-6)
    np.testing.assert_allclose(line[-1]["rms"], delivered["rms"], rtol=1e-6)

    data = str(store / "data")
    steps = plots.staircase_of(data, "m1", judge_by)
    np.testing.assert_allclose(steps["steps"][0]["rms"], truth, rtol=1e-6)
    job = tasks.compare(data, "m0", judge_by, lambda share, what: None)
    np.testing.assert_allclose(job["pooled"]["rms"], truth, rtol=1e-6)

    floor = job["pooled"]["noise_floor"]
    later = ask(capsys, "compare", "m1", *judge_by)
    shown = plots.versus(data, "m0", "m1", judge_by)
    history = ask(capsys, "model", "history", "m0", "--runs", *judge_by)
    for other in (later["pooled"], free, steps, shown, *line, *history):
        np.testing.assert_allclose(other["noise_floor"], floor, rtol=1e-6)
    alone = compared["pooled"]["noise_floor"]
    assert floor[0] < 0.9999 * alone[0], "m1 was not there to see it through"
    assert [step["model"] for step in later["history"]] == ["m0", "m1"]

    library = open_library(data)
    runs = [library.runs.recording(library.runs.find(name)) for name in judge_by]
    alone = judge(library.models.load(library.models.find("m0")), runs)
    np.testing.assert_allclose(alone.rms, truth, rtol=1e-6)
    for page, rms in (("c.html", truth), ("d.html", free["rms"])):
        assert all(f"{value:.4g}" in words(store / page) for value in rms)


def same(one, other) -> bool:
    """Do two documents that name the same band and samples name the same error?"""
    named = [one[k] == other[k] for k in ("cutoff_hz", "mask")]
    return all(named) and np.allclose(one["rms"], other["rms"], rtol=1e-4)


def words(page: Path) -> str:
    """What a reader sees of a page."""
    return re.sub(r"<[^>]+>", " ", page.read_text(encoding="utf-8"))


def test_a_judgement_says_that_it_saw_the_middle_only(monkeypatch):
    runs = recordings(1)
    model, pair = textbook(runs), [runs["fit_a"], runs["fit_b"].part(0, 2000, "")]
    assert judge(model, pair).mask == MASK
    monkeypatch.setattr(import_module("pa10d.judgement.judge"), "MOST", 5000)
    found = judge(model, pair)
    assert found.mask == f"{MASK}, of each run no more than its 3000 middle samples"
    middle = [pair[0].part(1500, 4500, ""), pair[1]]
    monkeypatch.undo()
    assert found.rms == pytest.approx(judge(model, middle).rms)
