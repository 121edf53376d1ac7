"""Figures: strict JSON, the right numbers, no peak lost, quick enough."""

import json

import figure_reader as reader
import numpy as np
import pytest

from pa10d import figures
from pa10d.figures.decimate import extremes, peaks, thinned
from pa10d.figures.staircase import Stair


def strict(figure):
    assert set(figure) == {"data", "layout"}
    return json.loads(json.dumps(figure, allow_nan=False))


def test_decimation_keeps_every_spike_in_its_place():
    rng = np.random.default_rng(0)
    signal = rng.standard_normal((1_000_003, 2))
    signal[654_321, 0], signal[123_456, 1] = 50.0, -60.0
    drawn, step = extremes(signal, 2000)
    assert len(drawn) <= 2002
    assert drawn.max(axis=0) == pytest.approx(signal.max(axis=0))
    assert drawn.min(axis=0) == pytest.approx(signal.min(axis=0))
    assert np.argmax(drawn[:, 0]) * step == pytest.approx(654_321, abs=2 * step)
    assert np.argmin(drawn[:, 1]) * step == pytest.approx(123_456, abs=2 * step)


def test_short_signals_are_left_alone():
    signal = np.arange(10.0)
    drawn, step = extremes(signal, 100)
    assert np.array_equal(drawn, signal)
    assert step == 1.0


def test_peaks_of_a_spectrum_stay_where_they_are():
    x, y = np.linspace(0, 100, 10_001), np.zeros(10_001)
    y[[7, 5000, 10_000]] = [1.0, 3.0, 2.0]
    f, size = peaks(x, y, 100)
    assert len(f) <= 101
    for where, value in ((0.07, 1.0), (50.0, 3.0), (100.0, 2.0)):
        assert size[np.argmin(np.abs(f - where))] == value


def test_thinning_is_even_and_in_step_with_nothing():
    chosen = thinned(100_000, 1000)
    assert len(chosen) == 1000
    assert np.all(np.diff(chosen) > 0)
    assert len(np.unique(np.diff(chosen))) > 20


def test_time_plot_has_the_numbers_on_one_time_axis():
    t = np.arange(1000) * 0.01
    measured, modelled = np.sin(t), np.sin(t) - 0.1 * t
    counts = np.ones(1000, dtype=bool)
    counts[200:300] = False
    figure = strict(figures.torque_plot(measured, modelled, 0.01, 0.05, counts))
    above, model, below = figure["data"]
    assert reader.numbers(above["y"]) == pytest.approx(measured, abs=1e-6)
    assert reader.numbers(model["y"]) == pytest.approx(modelled, abs=1e-6)
    assert reader.numbers(below["y"]) == pytest.approx(measured - modelled, abs=1e-6)
    assert below["yaxis"] == "y2"
    assert {trace.get("xaxis", "x") for trace in figure["data"]} == {"x"}
    assert all(trace["dx"] == pytest.approx(0.01) for trace in figure["data"])
    bands = [s for s in figure["layout"]["shapes"] if s["xref"] == "x"]
    assert [(s["x0"], s["x1"]) for s in bands] == [(2.0, 3.0)] * 2
    noise = next(s for s in figure["layout"]["shapes"] if s["yref"] == "y2")
    assert (noise["y0"], noise["y1"]) == (-0.1, 0.1)


def test_first_plots_of_a_long_run_are_small():
    rng = np.random.default_rng(0)
    signals = rng.standard_normal((7, 2, 30_000))
    made = [figures.torque_plot(a, b, 0.002, 0.1) for a, b in signals]
    size = sum(len(json.dumps(figure)) for figure in made)
    assert size < 7 * 100_000


def test_staircase_in_units_of_the_noise():
    steps = [
        Stair("m0", "textbook", np.array([2.0, 1.0])),
        Stair("m1", "+ x", np.array([0.5, 1.0])),
    ]
    figure = strict(figures.staircase(steps, ["a", "b"], np.array([0.5, 0.25])))
    assert [trace["y"] for trace in figure["data"]] == [[4.0, 1.0], [4.0, 4.0]]
    assert figure["data"][0]["customdata"][1] == [0.5, "+ x"]
    plain = strict(figures.staircase(steps, ["a", "b"]))
    assert plain["data"][0]["y"] == [2.0, 0.5]
    one_unknown = strict(figures.staircase(steps, ["a", "b"], np.array([0.5, np.nan])))
    assert [trace["y"] for trace in one_unknown["data"]] == [[2.0, 0.5], [1.0, 1.0]]
    assert "N·m" in one_unknown["layout"]["yaxis"]["title"]["text"]
    for floor, said in (
        (np.array([0.5, 0.25]), "divided by the noise"),
        (np.array([0.5, np.nan]), "errors stand in their units"),
        (None, "errors stand in their units"),
    ):
        assert said in figures.staircase_text(floor).read


def test_evidence_draws_a_curve_for_a_function_of_x_and_samples_otherwise():
    rng = np.random.default_rng(0)
    x = rng.uniform(-1, 1, 4000)
    noise = 0.1 * rng.standard_normal(4000)
    for effect, mode in ((np.sin(3 * x), "lines"), (np.sin(300 * rng.random(4000)), "markers")):
        figure = strict(figures.evidence(x, "q, rad", effect + noise, noise, effect, floor=0.1))
        named = {t["name"]: t for t in figure["data"] if t.get("xaxis", "x") == "x"}
        assert named["the effect"]["mode"] == mode
    note = figure["layout"]["annotations"][1]["text"]
    assert f"{np.sqrt(np.mean(noise**2)):.3g} N·m" in note


def test_ranking_and_bars():
    strict(figures.ranking(["a", "b"], [3.0, 1.0], 2.0, "z"))
    ones = np.ones(2)
    strict(figures.before_after(["a", "b"], 2 * ones, ones, 0.9 * ones))


def test_every_text_says_both_things():
    for reading in figures.TEXTS.values():
        assert len(reading.read) > 40
        assert len(reading.then) > 40
