"""The report of a comparison: whole, offline, safe against odd names, drawn by a browser."""

import shutil
import subprocess
from dataclasses import replace

import figure_reader as reader
import numpy as np
import pytest

from pa10d import figures
from pa10d.compare import compare
from pa10d.compare.places import failing
from pa10d.figures.staircase import Stair
from pa10d.report import compare_page

EVIL = "</script><b onmouseover=alert(1)>&amp;\"'"


@pytest.fixture(scope="module")
def comparison():
    import sys
    from pathlib import Path

    sys.path.insert(0, str(Path(__file__).parent.parent / "compare"))
    import compare_arm as arm

    def ripple(t, q, dq):
        return arm.on_joint(1, np.sin(30 * q[:, 1]))

    model = arm.model()
    model = replace(model, name=EVIL, robot=replace(model.robot, joint_names=("a", EVIL, "c")))
    runs = [arm.recording(seed, extra=ripple, name=f"{EVIL}{seed}") for seed in (1, 2)]
    return compare(model, runs)


@pytest.fixture(scope="module")
def text(comparison):
    rms = comparison.pooled.scores.rms
    return compare_page(comparison, [Stair("m0", "textbook", 2 * rms), Stair("m1", EVIL, rms)])


def test_nothing_is_loaded_from_elsewhere(text):
    found = reader.Report(text)
    assert all(link.startswith("#") for link in found.links)
    assert sum("plotly.js (cartesian" in script[:200] for script in found.scripts) == 1
    assert "@import" not in text
    assert "url(http" not in text


def test_every_plot_has_its_figure_and_its_words(text):
    found = reader.Report(text)
    assert found.open == []
    assert len(set(found.ids)) == len(found.ids)
    assert set(found.canvases) <= set(found.stored)
    words = " ".join(found.words)
    plots = len(found.canvases)
    assert plots == 2 + 4 * 3
    assert words.count("How to read this") == plots
    assert words.count("What to do next") == plots
    for key in found.stored:
        assert found.figure(key)["data"]


@pytest.fixture(scope="module")
def blind(comparison):
    """The same, of which nobody knows the noise."""
    pooled = comparison.pooled
    floor = replace(pooled.floor, values=np.full(3, np.nan), methods=(None,) * 3)
    own = np.full(3, np.inf)
    spread = tuple(failing(pooled.scores, floor.values, comparison.model.robot, [], [], own))
    return replace(comparison, pooled=replace(pooled, floor=floor, where=(), spread=spread))


def test_where_the_noise_is_not_known_nothing_is_measured_by_it(blind):
    found = reader.Report(compare_page(blind))
    words = " ".join(found.words)
    for untrue in ("units of its noise", "0 of 3", "Green:", "(dashed)", "looks like noise"):
        assert untrue not in words
    assert "The noise of no joint is known" in words
    assert "Noise floor not known from these runs (joints 1 to 3)." in words
    range_shares = 100 * blind.pooled.scores.nrmse
    assert blind.pooled.worst == np.argmax(range_shares)
    drawn = figures.overview(blind.pooled, blind.model.robot.joint_names, ["N·m"] * 3)
    assert drawn["data"][0]["y"] == range_shares.tolist()
    assert drawn["layout"]["shapes"] == []


def test_the_overview_is_in_units_of_the_noise(comparison):
    pooled = comparison.pooled
    drawn = figures.overview(pooled, ["a", "b", "c"], ["N·m"] * 3)
    assert drawn["data"][0]["y"] == (pooled.scores.rms / pooled.noise_floor).tolist()


def test_names_stay_text(text):
    found = reader.Report(text)
    assert "onmouseover" not in found.attributes
    assert not any("alert(1)" in script for script in found.scripts)
    assert f"{EVIL}: where does it fail?" in found.words


def test_what_was_found_is_said(text, comparison):
    words = reader.Report(text).words
    for place in comparison.pooled.where:
        assert words.count(place.sentence) == 2
    order = comparison.orders[1].lines[0][0]
    assert order == pytest.approx(30.0, abs=0.05)
    assert any(f"A line at {order:.4g} cycles per revolution" in word for word in words)
    assert any("joint 2 (effect torque_ripple)" in word for word in words)


def test_figures_are_those_of_the_comparison(text, comparison):
    words = reader.Report(text).words
    for value in comparison.pooled.scores.rms:
        assert f"{value:.4g}" in words
    assert any("Noise floor from" in word for word in words)


@pytest.mark.long
def test_a_browser_draws_it_without_errors(text, tmp_path):
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("no chromium or google-chrome to draw the report with")
    file = tmp_path / "report.html"
    file.write_text(text)
    done = subprocess.run(
        [browser, "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1200,9000",
         "--virtual-time-budget=30000", "--enable-logging=stderr", "--dump-dom", file.as_uri()],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    assert "Uncaught" not in done.stderr
    assert done.stdout.count('class="main-svg"') >= 10
