"""A low-pass that identification took for a delay is told beside what was found."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy
from two_links import NAMES, recordings, robot, textbook_torque

from pa10d.diagnose.evidence import stated as errors
from pa10d.diagnose.evidence.stated import stated
from pa10d.diagnose.regression.behind import perhaps_smoothed
from pa10d.diagnose.regression.clear_of_knocks import clear_of_knocks
from pa10d.diagnose.regression.shaken import Shaken
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search import channel
from pa10d.diagnose.search.channel import (
    agree_by_now,
    behind_channel,
    beside_springs,
    channel_words,
    tuned,
)
from pa10d.diagnose.search.refining import refine
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.unknown.among_knocks import among_knocks
from pa10d.effects import effect
from pa10d.effects.context import Context
from pa10d.effects.library.backlash import CONTACT_HZ
from pa10d.effects.twist import twisted_torque
from pa10d.identify import channel as identify_channel
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import delayed
from pa10d.measurement.torque_filter import TorqueFilter
from pa10d.model import Term

HERTZ = 8.0
HALF = 0.01  # rad, of a gap
LATE = 0.5 / np.pi / HERTZ


def smoothed(run: Recording, joints: tuple[int, ...]) -> Recording:
    """These joints behind a first-order low-pass, as firmware steps it; the others as late."""
    pole = np.exp(-2 * np.pi * HERTZ / run.rate)
    passed, _ = scipy.signal.lfilter([1 - pole], [1, -pole], run.tau, axis=0, zi=pole * run.tau[:1])
    tau = delayed(run.tau, LATE, run.rate)
    tau[:, joints] = passed[:, joints]
    return Recording(run.name, run.t, run.q, tau)


@cache
def made_and_identified():
    made = recordings(3)
    return made, identify([made[name] for name in NAMES[:2]], robot(), name="m0")


def between_hard_teeth(t, q, dq, ddq):
    """What a gap in joint 2 adds, its teeth nearly twice as hard as the effect takes them to be."""
    rigid, torque = np.array(robot().parameters), textbook_torque(q, dq, ddq)
    context = Context(robot(), t, q, dq, ddq, rigid, torque)
    stiffness = float(context.typical_inertia[1]) * (2 * np.pi * 1.8 * CONTACT_HZ) ** 2
    return twisted_torque(context, 1, stiffness, 0.2, [[HALF]])[:, :, 0]


@cache
def with_a_gap() -> SearchState:
    """A gap is found, and the model knows of the delay alone."""
    made, late = recordings(3, between_hard_teeth), made_and_identified()[1]
    runs = [smoothed(made[name], (0, 1)) for name in NAMES]
    train, held, _ = two_sides(replace(late, shift=LATE, channel=None), runs[:2], runs[2:])
    state = SearchState.start(late, train, held)
    state.push(Term("backlash", (1,), np.ones(1), {"b": HALF}))
    state.refit()
    state.relook()
    state.refit()
    return state


@cache
def taken_for_late(joints: tuple[int, ...]) -> SearchState:
    """Seen by a model that knows of the delay alone."""
    made, late = made_and_identified()
    runs = [smoothed(made[name], joints) for name in NAMES]
    model = replace(late, shift=LATE, channel=None)
    train, held, _ = two_sides(model, runs[:2], runs[2:])
    return SearchState.start(model, train, held)


def test_what_all_joints_have_passed_is_found():
    found = behind_channel(taken_for_late((0, 1)))
    assert found.model.channel.kind == "first order"
    assert 0.5 / np.pi / found.model.channel.seconds == pytest.approx(HERTZ, rel=0.2)
    assert np.all(found.fit.rms() < 0.9 * taken_for_late((0, 1)).fit.rms())


@pytest.mark.parametrize("joints", [(), (0,)])
def test_what_is_late_alone_or_smoothed_on_one_joint_is_no_channel(joints):
    assert behind_channel(taken_for_late(joints)) is None


STEP = 3e-4  # rad, of an encoder: they make a torque about as large as what is left without them


@cache
def through_coarse_encoders() -> SearchState:
    """Behind an analogue low-pass (its equation, not steps of it), angles in steps."""
    made, late = made_and_identified()
    passes = scipy.signal.lti([1.0], [LATE, 1.0])
    runs = []
    for run in (made[name] for name in NAMES):
        tau = [scipy.signal.lsim(passes, x, run.t, X0=x[0] * LATE)[1] for x in run.tau.T]
        runs.append(replace(run, q=STEP * np.round(run.q / STEP), tau=np.column_stack(tau)))
    model = replace(late, shift=LATE, channel=TorqueFilter("first order", LATE))
    return SearchState.start(model, *two_sides(model, runs[:2], runs[2:])[:2])


def test_noise_of_the_angles_asks_for_no_softer_channel(monkeypatch):
    state = through_coarse_encoders()

    def asked_for() -> float:
        found, _ = channel._of_kind("first order", LATE, channel._asking(state, {}))
        return 0.5 / np.pi / found.seconds

    assert asked_for() == pytest.approx(HERTZ, rel=0.15)
    monkeypatch.setattr(channel, "shaken", lambda state, side: Shaken(side, []))
    assert asked_for() < 0.8 * HERTZ


def test_what_knocks_are_off_by_is_no_smoothness():
    """A knock that comes a little early or late is nearer to the torque the softer it is."""
    found = behind_channel(with_a_gap())
    assert found.model.channel.kind == "first order"
    assert 0.5 / np.pi / found.model.channel.seconds == pytest.approx(HERTZ, rel=0.25)


def test_knocks_are_few_samples_and_keep_most_of_the_error():
    state = with_a_gap().behind(TorqueFilter("first order", LATE))
    (clear,) = clear_of_knocks(state)
    for joint in range(2):
        assert 0.5 < len(clear.train.tau[joint]) / len(state.train.tau[joint]) < 0.95
    assert np.all(clear.fit.rms() < 0.7 * state.fit.rms())
    found = among_knocks(state)[1]
    assert found.of == (1,)
    assert found.share > 0.5 > found.part
    left = state.held_residual()[1]
    kept = found.rest**2 * (1.0 - found.part)
    assert found.share == pytest.approx(1.0 - kept / np.mean(left**2))


def test_a_model_without_a_gap_looks_everywhere():
    state = taken_for_late((0, 1))
    assert clear_of_knocks(state) == (state,)
    assert among_knocks(state) == {}


def test_a_low_pass_that_does_not_show_beside_what_was_found_goes():
    """Identification took what a spring lacked for one."""
    made, late = made_and_identified()
    runs = [replace(run, tau=delayed(run.tau, LATE, run.rate)) for run in map(made.get, NAMES)]
    passed = TorqueFilter("first order", LATE)
    train, held, _ = two_sides(replace(late, shift=LATE, channel=passed), runs[:2], runs[2:])
    state = SearchState.start(replace(late, shift=LATE, channel=passed), train, held)
    assert state.train.runs[0].lowpass.channel == passed
    assert behind_channel(state).model.channel is None


@pytest.mark.parametrize(("loses", "kind"), [(1.0, "first order"), (40.0, "mean")])
def test_of_kinds_that_are_hardly_told_apart_one_as_late_as_torque_is_taken(
    monkeypatch, loses, kind
):
    """A crane behind a first-order low-pass of 16 ms had "passed a mean over 57 ms", half of which
    is 28: angles would be late by 13 ms."""
    state = taken_for_late((0, 1))
    few = np.ones(2)
    first = TorqueFilter("first order", LATE), (90.0 * few, few)
    mean = TorqueFilter("mean", 3.5 * LATE), (92.0 * few, few)
    monkeypatch.setattr(channel, "_asking", lambda *_: lambda _: (-loses * few, 2.0 * few))
    assert channel._as_late(state, [first, mean])[0].kind == kind
    known = {"first order": {1.0: (92.0 - loses) * few}, "mean": {1.75: 92.0 * few}}
    assert identify_channel._as_late(known) == kind


def test_a_low_pass_is_told_with_its_error():
    words = channel_words(tuned(taken_for_late((0, 1)).behind(TorqueFilter("first order", LATE))))
    value, error = (float(x) for x in words.split(" at ")[1].removesuffix(" Hz").split(" ± "))
    assert abs(value - HERTZ) < 2.0 * error < 0.2 * HERTZ
    assert channel_words(taken_for_late((0, 1))) == ""


@pytest.mark.long
def test_a_search_goes_on_behind_it():
    """Nothing is missing there, and bristles are no stand-in."""
    state = taken_for_late((0, 1)).copy()
    asked = [(effect("presliding_hysteresis"), (j,)) for j in (0, 1)]
    search = Search(state, asked, len(state.terms))
    search.run(1)
    assert search.state.model.channel is not None
    assert len(search.state.terms) == len(state.terms)


def test_a_channel_is_tuned_with_shapes_that_followed_another_one():
    """Settled beside half the delay, they and it would each keep the other where it is."""
    state = taken_for_late((0, 1)).behind(TorqueFilter("first order", 0.5 * LATE))
    for index, term in enumerate(state.terms):
        if term.effect.smoothed_over:
            refine(state, 0, index)
    state.refit()
    better = tuned(state)
    assert better.model.channel.seconds == pytest.approx(LATE, rel=0.15)


def test_what_is_known_of_the_channel_is_in_the_errors_beside_it(monkeypatch):
    """How sharply friction turns round, and what a low-pass smears, go for each other."""
    state = behind_channel(taken_for_late((0, 1)))
    everything = range(len(state.terms))
    with_it = stated(state, everything)
    none = {j: basis[:, :0] for j, basis in state.fit.basis.items()}
    monkeypatch.setattr(errors, "channel_slopes", lambda _: none)
    without = stated(state, everything)
    more = np.diag(with_it.covariance) / np.diag(without.covariance)
    assert np.all(more > 0.99), "more that is free, but for noise that is not white"
    sharp = [
        with_it.shape_errors[i]["v0"] / without.shape_errors[i]["v0"] for i in with_it.shape_errors
    ]
    assert max(sharp) > 1.05
    assert max(more) > 2.0


def test_an_offset_in_time_that_was_not_taken_out_is_in_the_errors(monkeypatch):
    """The way of bristles was 0.6 % off, four of its errors, on an arm that was 0.08 ± 0.06 ms
    late, which is no offset as far as anybody knows."""
    made, late = made_and_identified()
    runs = [made[name] for name in NAMES]
    train, held, _ = two_sides(replace(late, shift=0.0, channel=None), runs[:2], runs[2:])
    state = SearchState.start(late, train, held)
    everything = range(len(state.terms))
    with_it = stated(state, everything)
    none = {j: basis[:, :0] for j, basis in state.fit.basis.items()}
    monkeypatch.setattr(errors, "channel_slopes", lambda _: none)
    more = np.diag(with_it.covariance) / np.diag(stated(state, everything).covariance)
    assert np.all(more > 0.999)
    assert np.max(more) > 1.05


def off_by(joints: tuple[int, ...]) -> np.ndarray:
    """Of each coefficient, beside those behind the true channel, in stated standard errors."""
    state = taken_for_late(joints)
    true = state.behind(TorqueFilter("first order", LATE))
    errors_of = np.sqrt(np.diag(stated(state, range(len(state.terms))).covariance))
    return np.abs(state.fit.beta - true.fit.beta) / errors_of


def test_a_low_pass_that_may_hide_behind_a_delay_is_in_the_errors(monkeypatch):
    """Torque that is late may be smoothed, whether or not the data can prove it."""
    assert max(off_by((0, 1))) < 2.0
    none = {j: basis[:, :0] for j, basis in taken_for_late((0, 1)).fit.basis.items()}
    monkeypatch.setattr(errors, "perhaps_smoothed", lambda _: none)
    assert max(off_by((0, 1))) > 3.0


def test_what_is_not_late_is_not_smoothed():
    made, late = made_and_identified()
    runs = [made[name] for name in NAMES]
    train, held, _ = two_sides(replace(late, shift=0.0, channel=None), runs[:2], runs[2:])
    columns = perhaps_smoothed(SearchState.start(late, train, held))
    assert {c.shape[1] for c in columns.values()} == {0}


@pytest.mark.parametrize(("joints", "agreed"), [((0, 1), True), ((1,), False)])
def test_what_a_spring_has_taken_the_part_of_is_asked_once_that_is_fitted_behind_it(joints, agreed):
    """A first order at 16.3 Hz beside a spring: the spring's joint did not ask for it, for K was
    482 ± 15 for 537 by then and the rotor 0.068 ± 0.006 for 0.043."""
    late = taken_for_late(joints)
    assert beside_springs(late) is None
    sprung = late.copy()
    sprung.push(Term("joint_elasticity", (0,), np.ones(1), {"K": 1e6, "zeta": 0.05}))
    sprung.refit()
    behind = beside_springs(sprung)
    if agreed:
        assert behind.model.channel.kind == "first order"
        assert 0.5 / np.pi / behind.model.channel.seconds == pytest.approx(HERTZ, rel=0.2)
    one = late.behind(TorqueFilter("first order", 0.5 / np.pi / HERTZ))
    assert agree_by_now(late, one) == agreed
