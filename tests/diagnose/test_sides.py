"""What the fit sees and what it is judged on never overlap, filters included."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from two_links import (
    CUTOFF,
    RATE,
    motion,
    recordings,
    robot,
    state_of,
    textbook,
    textbook_torque,
)

from pa10d.common.errors import UserError
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.partial import partials
from pa10d.diagnose.regression.sides import blocks, two_sides
from pa10d.effects import effect
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import prepare


@pytest.fixture(scope="module")
def runs():
    return recordings(5)


@pytest.fixture(scope="module")
def model(runs):
    return textbook(runs)


def test_blocks_share_no_sample_and_leave_a_guard(runs):
    run = prepare(runs["fit_a"], robot(), CUTOFF)
    first, second = blocks(run)
    assert not np.any(first.keep & second.keep)
    assert not np.any((first.keep | second.keep) & ~run.keep)
    rows = [np.flatnonzero(side.keep.any(axis=1)) for side in (first, second)]
    apart = np.min(np.abs(rows[0][:, None] - rows[1][None, :])) / run.rate
    assert apart >= 2.0 / CUTOFF  # two periods of what the filter passes
    used = (first.keep | second.keep).sum() / run.keep.sum()
    assert 0.8 < used < 1.0
    assert 0.7 < first.keep.sum() / second.keep.sum() < 1.4


def test_what_happens_in_one_block_is_not_seen_in_the_other(runs):
    """A knock in a fitted block leaves the torque of the judged ones as it was."""
    first, second = blocks(prepare(runs["fit_a"], robot(), CUTOFF))
    rows = np.flatnonzero(first.keep.all(axis=1))
    knock = rows[len(rows) // 2] * first.lowpass.factor
    tau = runs["fit_a"].tau.copy()
    tau[knock] += 1000.0
    other = Recording("fit_a", runs["fit_a"].t, runs["fit_a"].q, tau)
    after = blocks(prepare(other, robot(), CUTOFF))
    assert np.max(np.abs(after[0].tau - first.tau)) > 10.0
    seen = np.abs(after[1].tau - second.tau)[second.keep]
    assert np.max(seen) < 1e-2  # of 1000


def of_periods(periods: int, harmonic: int = 1) -> Recording:
    """Both joints turn to one side in the first half of a period, fast, and slowly back."""
    t = np.arange(round(30.0 * RATE)) / RATE
    phase = 2 * np.pi * periods / 30.0 * t
    q = np.column_stack([np.sin(phase) + 0.4 * np.sin(2 * phase), 0.8 * np.sin(harmonic * phase)])
    rng = np.random.default_rng(0)
    return Recording("periods", t, q, 10.0 * q + rng.standard_normal(q.shape))


@pytest.mark.parametrize("periods", [2, 3, 4, 5, 6])
def test_both_sides_see_every_part_of_a_period(periods):
    """Six blocks of three periods would give the one side every first half, the other the rest."""
    run = prepare(of_periods(periods), robot(), CUTOFF)
    first, second = blocks(run)
    phase = np.mod(run.t * periods / 30.0, 1.0)
    for side in (first, second):
        inside = side.keep.any(axis=1)
        seen = np.unique((12 * phase[inside]).astype(int))
        assert len(seen) >= 10, f"{len(seen)} twelfths of the period"


def test_a_run_is_cut_by_its_motion_alone():
    run = of_periods(3)
    other = Recording("periods", run.t, run.q, run.tau[::-1] ** 2)
    for one, two in zip(
        blocks(prepare(run, robot(), CUTOFF)), blocks(prepare(other, robot(), CUTOFF)), strict=True
    ):
        np.testing.assert_array_equal(one.keep, two.keep)


def test_separate_runs_are_used_whole(runs, model):
    train, held, words = two_sides(model, [runs["fit_a"]], [runs["valid_a"], runs["valid_b"]])
    assert [r.name for r in train.runs] == ["fit_a"]
    assert [r.name for r in held.runs] == ["valid_a", "valid_b"]
    assert words == "runs valid_a, valid_b, which the fit has not seen"


def test_without_validation_every_other_block_judges(runs, model):
    train, held, words = two_sides(model, [runs["fit_a"]], [])
    assert "every other block of time of fit_a" in words
    assert "no separate validation run" in words
    assert not np.any(train.keep[0] & held.keep[0])


def test_a_run_on_both_sides_is_cut(runs, model):
    train, held, words = two_sides(
        model, [runs["fit_a"], runs["fit_b"]], [runs["fit_b"], runs["valid_a"]]
    )
    assert [r.name for r in train.runs] == ["fit_a", "fit_b"]
    assert sorted(r.name for r in held.runs) == ["fit_b", "valid_a"]
    assert "of fit_b, which the fit uses as well, every other block of time" in words
    cut = {r.name: r.keep for r in held.runs}["fit_b"]
    assert not np.any(train.keep[1] & cut)


def test_a_copy_of_a_fitted_run_does_not_judge(runs, model):
    """Three false claims of structure, "where the fit side has not been", stood on such a one."""
    copy = replace(runs["fit_a"], name="held")
    with pytest.raises(UserError, match="held has the samples of fit_a, which is fitted"):
        two_sides(model, [runs["fit_a"], runs["fit_b"]], [copy])


def test_no_run_is_refused(model):
    with pytest.raises(UserError, match="no run to fit, expected at least one"):
        two_sides(model, [], [])


def test_another_arm_is_refused(runs, model):
    run = runs["fit_a"]
    one = Recording("odd", run.t, run.q[:, :1], run.tau[:, :1])
    with pytest.raises(UserError, match="odd: 1 joints, expected 2 as in model m0"):
        two_sides(model, [one], [])


def recorded(run, angle):
    q = run.q.copy()
    q[:, 1] = angle
    return Recording("odd", run.t, q, run.tau)


@pytest.mark.parametrize(
    ("angle", "why"),
    [
        (lambda t: 0.3 + 0.0 * t, "joint 2 never moves in the data to judge by"),
        (lambda t: 0.3 + 1e-3 * np.sin(t), "joint 2 never moves in the data to judge by"),
        (
            lambda t: 0.3 + 0.4 * np.clip(t - t[-1] + 0.3, 0.0, 0.3),
            r"joint 2 moves only within 0\.\d+ s of the ends of the data to judge by",
        ),
        # a motor that cogs moves all the time; a band of 8 Hz only cannot see it
        (
            lambda t: 0.3 + 0.05 * np.sin(2 * np.pi * 9.0 * t),
            r"joint 2 turns round or stands so often .* 8 Hz .* strokes of 0\.2 s and more",
        ),
        (
            lambda t: 0.3 + 0.3 * np.sin(2 * np.pi * 0.4 * np.clip(t - 10.0, 0.0, 0.5)),
            r"\d+ independent samples of joint 2 in motion in the data to judge by",
        ),
    ],
)
def test_a_joint_of_which_the_data_says_nothing_does_not_keep_the_others_from_it(
    runs, model, angle, why
):
    run = runs["fit_a"]
    _, held, _ = two_sides(model, [run], [recorded(run, angle(run.t))])
    assert list(held.silent) == [1]
    assert re.match(why, held.silent[1])
    assert [len(tau) > 0 for tau in held.tau] == [True, False]


def test_a_joint_whose_one_stroke_a_cut_falls_into_did_move(runs, model):
    """It was said to never move, beside a run in which it swings."""
    run = runs["fit_a"]
    once = recorded(run, 0.6 * np.clip((run.t - 14.0) / 0.4, 0.0, 1.0))
    _, held, _ = two_sides(model, [once], [])
    assert held.silent[1].startswith("joint 2 moves too little in blocks of time of one run")
    still = two_sides(model, [recorded(run, 0.3)], [])[1]
    assert held.silent.keys() == still.silent.keys()
    assert "never moves" in still.silent[1]


def test_data_that_says_nothing_of_any_joint_is_refused(runs, model):
    run = runs["fit_a"]
    still = Recording("still", run.t, np.full_like(run.q, 0.3), run.tau)
    told = "joint 1 never moves in the data to judge by.*no other joint"
    with pytest.raises(UserError, match=told):
        two_sides(model, [run], [still])


@pytest.mark.long
def test_the_others_are_diagnosed_beside_a_joint_at_rest():
    """Joint 2 rests in all runs and is held by torques that no model knows; joint 1 cogs."""
    still = {name: at_rest(seed) for seed, name in enumerate(("fit", "judge"))}
    model = identify([still["fit"]], robot(), name="m0", cutoff=CUTOFF)
    found = diagnose(model, [still["fit"]], [still["judge"]])
    (only,) = found.findings
    assert (only.term.effect_id, only.term.joints) == ("torque_ripple", (0,))
    moved, rested = found.remaining
    assert moved.ratio < 1.2
    assert rested.sentence == (
        "Nothing was looked for on joint 2: joint 2 never moves in the data to fit: use runs in "
        "which it does."
    )
    assert not rested.significant
    assert np.isnan(rested.ratio)
    promise = found.model.notes.delivery
    assert promise.promised[1] == promise.achieved[1]
    assert not promise.worse


def at_rest(seed):
    rng = np.random.default_rng(seed)
    t, q, dq, ddq = motion(seed)
    for x, rest in ((q, 0.4), (dq, 0.0), (ddq, 0.0)):
        x[:, 1] = rest
    tau = textbook_torque(q, dq, ddq) + 0.02 * rng.standard_normal(q.shape)
    tau[:, 0] += 0.2 * np.sin(9.0 * q[:, 0])
    tau[:, 1] += 0.5 + 0.3 * seed
    return Recording(f"r{seed}", t, q, tau)


def test_scatter_puts_rows_back_where_they_were(runs, model):
    state = state_of(runs, model)
    side = state.train
    back = side.scatter({j: side.tau[j] for j in range(2)})
    for values, run in zip(back, side.runs, strict=True):
        np.testing.assert_array_equal(values, np.where(run.keep, run.driven, 0.0))


def test_shift_of_a_side_moves_its_torque(runs, model):
    side = state_of(runs, model).train
    before = side.runs[0].tau.copy()
    factor = side.runs[0].lowpass.factor
    moved = side.shifted(factor / RATE)  # one sample of the equation
    middle = slice(20, -20)
    np.testing.assert_allclose(
        moved.runs[0].tau[middle], np.roll(before, -1, axis=0)[middle], atol=2e-2
    )
    assert moved.runs[0].shift == factor / RATE
    assert side.runs[0].shift == 0.0
    np.testing.assert_array_equal(side.runs[0].tau, before)


def test_a_bare_state_goes_its_own_way(runs, model):
    """Problem and sides are constant: what becomes of a part leaves the whole alone."""
    state = state_of(runs, model)
    torque, terms, beta = state.train.tau[0].copy(), state.terms, state.fit.beta.copy()
    part = state.bare(2)
    part.train, part.held = part.train.shifted(0.01), part.held.shifted(0.01)
    part.relook()
    part.refit()
    state.refit()
    np.testing.assert_array_equal(state.train.tau[0], torque)
    assert [t.label for t in state.terms] == [t.label for t in terms]
    np.testing.assert_allclose(state.fit.beta, beta, rtol=0.02, atol=1e-3 * np.abs(beta).max())


def test_a_spring_so_soft_that_its_link_runs_away_says_nothing(runs, model):
    """A short recording leads the search there; it must come back, and find nothing better."""
    state = state_of(runs, model)
    spring = effect("joint_elasticity")
    stiff = {s.name: np.sqrt(s.lower * s.upper) for s in spring.shapes} | {"K": 1e4, "zeta": 0.1}
    columns = state.train.columns(spring, (0,), [stiff | {"K": 1e-3}])
    assert columns
    assert not any(np.any(c) for c in columns.values())
    (partial,) = partials(state.fit, columns, spring, len(spring.coefficients))
    assert not partial.identifiable
    assert partial.gain == 0.0
