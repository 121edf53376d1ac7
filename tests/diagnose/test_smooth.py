"""A smooth map takes away what no effect explains, says that it explains nothing, and leaves noise
alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from two_links import motion, recordings, robot, textbook

from pa10d.common.errors import UserError
from pa10d.compare import noise_floor, run_residual, scores
from pa10d.compare.unexplained import map_warnings
from pa10d.diagnose.asked.smooth import Smoothed, add_map
from pa10d.effects import Context
from pa10d.measurement.recording import Recording
from pa10d.store.models import ModelStore

FIT, JUDGE = ("fit_a", "fit_b"), ("valid_a", "valid_b")


def product(t, q, dq, ddq):
    """Of both angles, on the first joint: like nothing in the library."""
    return np.column_stack([0.5 * np.sin(2 * q[:, 0]) * q[:, 1], np.zeros(len(t))])


def mapped(runs: dict[str, Recording], joint: int, over, **options) -> Smoothed:
    return add_map(
        textbook(runs),
        [joint],
        over,
        [runs[k] for k in FIT],
        validate=[runs[k] for k in JUDGE],
        name="m1",
        **options,
    )


@pytest.fixture(scope="module")
def runs():
    return recordings(0, product)


@pytest.fixture(scope="module")
def removed(runs):
    return mapped(runs, 0, ("q", "q2"))


def test_it_takes_the_error_most_of_the_way_to_the_noise(runs, removed):
    held = [runs[k] for k in JUDGE]
    old, new = ([run_residual(m, r) for r in held] for m in (textbook(runs), removed.model))
    before, after, floor = scores(old).rms, scores(new).rms, noise_floor(new).values
    assert before[0] > 8 * floor[0]
    assert (before - after)[0] > 0.85 * (before - floor)[0]
    assert after[1] < 1.02 * before[1], "the other joint pays nothing for it"
    assert removed.helps
    assert removed.warnings == []
    assert removed.after < 0.3 * removed.before


def test_the_model_says_that_it_explains_nothing(runs, removed):
    model = removed.model
    assert model.terms[-1].label == "smooth_map J1 over q1, q2"
    assert "explains nothing: no physical effect" in model.change
    said = map_warnings(model, [run_residual(model, runs["valid_a"])])
    assert said[0] == (
        "smooth_map J1 over q1, q2 removes the error, explains nothing: no physical effect"
    )
    assert map_warnings(textbook(runs), []) == []


def test_it_tells_how_much_of_a_run_it_has_not_been_to(removed):
    t, q, *_ = motion(123)
    wide = Recording("wide", t, 1.5 * q, np.zeros_like(q))
    run = run_residual(removed.model, wide)
    shape = removed.model.terms[-1].shape
    beyond = np.zeros(len(t), dtype=bool)
    for k in (1, 2):
        angle = 1.5 * q[:, k - 1]
        beyond |= (angle < shape[f"q{k} from"]) | (angle > shape[f"q{k} to"])
    share = np.mean(run.decimated(beyond[:, None].astype(float))[run.counts[:, 0]])
    assert 0.1 < share < 0.9
    (line,) = map_warnings(removed.model, [run])[1:]
    assert line.startswith(f"run wide: {share:.0%} of it lies outside the range")


def test_far_outside_it_goes_on_level(removed):
    t, q, dq, ddq = motion(5, 5.0)
    far = Context(robot(), t, 40 * q, dq, ddq, np.zeros((2, 10)), 0 * q)
    drawn = removed.model.terms[-1].torque(far)[:, 0]
    assert np.abs(drawn).max() <= np.abs(removed.model.terms[-1].coefficients).max()


def test_a_stored_model_predicts_the_same(runs, removed, tmp_path):
    store = ModelStore(tmp_path)
    info = store.save(replace(removed.model, parent=None))
    assert info.effects[-1] == "smooth_map J1 over q1, q2"
    back = store.load(info)
    assert back.terms[-1].over == ("q1", "q2")
    context = run_residual(removed.model, runs["valid_a"]).equation.context
    assert np.array_equal(back.predict(context), removed.model.predict(context))
    assert store.history(info)[-1].change == removed.model.change


@pytest.mark.by_default("over: [q1, q2]-over: [q1]-coefficients")
@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("over: [q1, q2]", "over: [q1, q9]", "one or two quantities"),
        ("over: [q1, q2]", "over: [q1, wind]", "one or two quantities"),
        ("over: [q1, q2]", "over: []", "found nothing"),
        ("over: [q1, q2]", "over: [q1]", "coefficients"),
        ("effect: smooth_map", "effect: spring", "over"),
    ],
)
def test_a_file_with_another_map_is_refused_in_one_line(removed, tmp_path, old, new, expected):
    store = ModelStore(tmp_path)
    path = store.path(store.save(replace(removed.model, parent=None)))
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(UserError, match=expected) as said:
        ModelStore(tmp_path).load("m1")
    assert len(str(said.value).splitlines()) == 1


@pytest.mark.parametrize("over", [("q", "q2"), ("dq",)])
@pytest.mark.long
def test_on_a_clean_arm_it_gains_nothing_and_says_so(over):
    runs = recordings(1)
    made = mapped(runs, 0, over)
    assert not made.helps
    assert "no significant gain on held-out data" in made.warnings[0]
    assert made.after > 0.99 * made.before
    assert made.after < 1.03 * made.before


@pytest.mark.long
def test_over_the_wrong_quantities_it_gains_nothing_and_says_so(runs):
    made = mapped(runs, 0, ("dq",))
    assert not made.helps
    assert "what is left does not depend on dq1, or too little" in made.warnings[0]


@pytest.mark.long
def test_a_map_of_one_quantity_draws_its_curve():
    def wave(t, q, dq, ddq):
        return np.column_stack([np.zeros(len(t)), 0.3 * np.sin(5 * q[:, 0])])

    made = mapped(recordings(2, wave), 1, ("q1",))
    assert made.helps
    angle = np.linspace(-0.8, 0.8, 100)
    q = np.column_stack([angle, 0 * angle])
    t = np.arange(100) / 100.0
    drawn = made.model.terms[-1].torque(Context(robot(), t, q, 0 * q, 0 * q, np.zeros((2, 10)), q))
    left = drawn[:, 1] - 0.3 * np.sin(5 * angle)
    # gravity may have taken a part; it is as slow as the angle itself
    left -= np.polyval(np.polyfit(angle, left, 3), angle)
    assert np.std(left) < 0.1 * 0.3
    values = made.model.term_values(len(made.model.terms) - 1)
    assert values["lowest"].value < -0.2
    assert values["highest"].value > 0.2


WRONG = {
    "no joint": ([], ("q",), "joint none: expected one joint of 1 to 2"),
    "two joints": ([0, 1], ("q",), "joint 1, 2: expected one joint"),
    "another joint": ([2], ("q",), "joint 3: expected one joint"),
    "nothing": ([0], (), "over nothing: expected one or two"),
    "three": ([0], ("q", "dq", "t"), "expected one or two different quantities"),
    "the same twice": ([0], ("q", "q1"), "expected one or two different quantities"),
    "unknown": ([0], ("wind",), "no quantity of a motion"),
}


@pytest.mark.by_default("two joints", "unknown")
@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_choice_is_one_line(runs, case):
    joints, over, expected = WRONG[case]
    with pytest.raises(UserError, match=expected):
        add_map(textbook(runs), joints, over, [runs["fit_a"]], name="m1")


def test_the_same_map_twice_is_refused(runs, removed):
    with pytest.raises(UserError, match="has this map already"):
        add_map(removed.model, [0], ("q1", "q2"), [runs[k] for k in FIT], name="m2")
