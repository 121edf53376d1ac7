"""What is found is told as what it is: corners of friction, springs, contacts, screws' ripple."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from two_links import V0, recordings, state_of, textbook

from pa10d.diagnose.outcome.words import unexplained
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search.bent_laws import bent_laws
from pa10d.diagnose.search.candidates import scan, sharpened
from pa10d.diagnose.search.judging import JudgedCandidate, Judging, _acts
from pa10d.diagnose.search.refining import refine
from pa10d.diagnose.search.ripple import order_peaks
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import suspicion
from pa10d.diagnose.unknown.remaining import remaining
from pa10d.effects import effect
from pa10d.judgement import Judgement, NoiseFloor
from pa10d.measurement.signals import Lowpass
from pa10d.model import Term

CLEAN = recordings(5)
SIDES = [CLEAN["fit_a"], CLEAN["fit_b"]], [CLEAN["valid_a"], CLEAN["valid_b"]]


def with_corner(v0, error):
    """The textbook model with another corner in joint 2's friction, as sure as that."""
    model = textbook(CLEAN)
    terms = [
        replace(t, shape={**t.shape, "v0": v0}, shape_errors={"v0": error})
        if (t.effect_id, t.joints) == ("coulomb", (1,))
        else t
        for t in model.terms
    ]
    return replace(model, terms=tuple(terms))


@pytest.mark.long
def test_a_corner_that_was_open_is_settled_before_anything_is_missing():
    found = diagnose(with_corner(0.2, np.inf), *SIDES)
    assert found.verdict == "none"
    (corner,) = (t.shape["v0"] for t in found.model.terms if t.label == "coulomb J2")
    assert V0 < corner < 0.06, "what the fit side hardly tells stays on the blunt side"


def test_friction_that_changed_keeps_its_corner():
    """Asked of what is missing its shape is open; of what changed it is the one that is there."""
    more = recordings(5, lambda t, q, dq, ddq: 0.5 * np.tanh(dq / 0.2) * [0.0, 1.0])
    state = state_of(more, textbook(CLEAN), frozen=True)
    known = {t.label: t.shape["v0"] for t in state.terms if t.effect_id == "coulomb"}
    for candidate in sharpened(state, scan(state, suspicion(("coulomb", ()), 2))):
        assert candidate.shape["v0"] == known[candidate.term.label]
        state.push(candidate.term)
        state.refit()
        refine(state, len(known), len(state.terms) - 1)
        assert state.terms[-1].shape["v0"] == known[candidate.term.label]
    kept = state.same_before(effect("stribeck"), (0,))
    assert kept is None, "its shape is more than a corner"


@pytest.mark.by_default("0.2")
@pytest.mark.parametrize(("qs", "name"), [(-9.0, "spring"), (0.2, "contact")])
def test_a_contact_that_is_touched_everywhere_is_a_spring(qs, name):
    springy = recordings(6, lambda t, q, dq, ddq: 4.0 * q * [0.0, 1.0])
    state = state_of(springy)
    given = len(state.terms)
    search = Search(state, suspicion(("spring", (1,)), 2), given)
    state.push(Term("contact", (1,), np.array([4.0]), {"qs": qs, "side": 1.0}))
    state.refit()
    touched = Judging(state, search.suspects, given).term(given)
    assert touched.is_itself is (name == "contact")
    search._call_by_name()
    assert search.state.terms[given].effect_id == name


@pytest.mark.by_default("0.0-True")
@pytest.mark.parametrize(("place", "seen"), [(0.0, True), (9.0, False)])
def test_a_spot_where_the_joint_has_not_been_is_none(place, seen):
    """ "A worn spot at 2.97 ± 4.1 rad" was named of a joint that ends at 2.4."""
    rubbing = recordings(6, lambda t, q, dq, ddq: np.tanh(dq / 0.02) * np.exp(-q * q) * [0.0, 2.0])
    state = state_of(rubbing)
    given = len(state.terms)
    search = Search(state, suspicion(("position_friction", (1,)), 2), given)
    shape = {"qc": place, "w": 1.4, "wave": 0.0}
    state.push(Term("position_friction", (1,), np.array([2.0]), shape))
    state.refit()
    judging = Judging(state, search.suspects, given)
    assert judging.term(given).is_itself is seen
    search._call_by_name()  # it has no other name, and stays what it is until it is pruned
    assert search.state.terms[given].effect_id == "position_friction"
    in_waves = Term("position_friction", (1,), np.array([2.0]), shape | {"wave": 1.0})
    assert judging.is_itself(in_waves.effect, (1,), in_waves.shape)


def test_what_has_no_torque_held_out_is_not_seen():
    """It helps there by what the bodies became beside it."""
    theta, moved = np.ones(1), {0: np.ones(50), 1: np.ones(50)}
    assert _acts({0: np.ones((50, 1))}, theta, moved)
    assert not _acts({0: np.zeros((50, 1))}, theta, moved)
    assert not _acts({0: 0.05 * np.ones((50, 1))}, theta, moved)


def test_what_the_fitted_runs_alone_show_is_told_as_that():
    """A spring that is wound beyond 1 rad on a fitted run only: "no effect that was looked for
    explains it", while to add a contact brought the joint from 2.5 to 1.0 times its floor."""
    touches = SimpleNamespace(
        effect=effect("contact"), joints=(0,), shape={"qs": 1.0, "side": 1.0}, gain=100.0
    )
    helps = SimpleNamespace(
        before=np.array([0.25, 0.1]),
        after=np.array([0.11, 0.1]),
        p_value=1e-9,
        slope=1.0,
        worse=(),
    )
    one = JudgedCandidate(touches, helps, 1e-9, acts=False)
    assert one.unseen
    assert not one.acceptable
    assert not one.bent
    assert JudgedCandidate(touches, helps, 1e-9).acceptable
    (told,) = bent_laws([one])
    assert (told.witness, told.variables) == ("unseen", ("q1",))
    floor = NoiseFloor(np.full(2, 0.1), ("standstill",) * 2, np.full(2, 0.001), np.ones(2))
    left = Judgement("m", ("run",), 10.0, np.array([0.25, 0.1]), floor)
    said = remaining(left, [None, None], [told], ["N·m"] * 2)[0].sentence
    assert "gone with a contact beyond one angle, which the fitted runs ask for" in said
    assert "Hold out motion that does" in said
    whole = SimpleNamespace(
        only="", contradicted=(), misplaced=(), stood="", frozen=False, unexplained=(told,)
    )
    assert unexplained(whole).startswith("The fitted runs ask for a contact beyond one angle in")


@pytest.mark.parametrize("slides", [False, True])
def test_a_screw_s_ripple_is_looked_for_on_slides_alone(slides):
    """A pitch of 10 mm: 628 rad/m, more than any gear has cycles in a turn."""
    t = np.arange(6000) / 200.0
    q = -0.05 + 0.07 * np.sin(0.5 * t)
    left = 0.2 * np.sin(628.3 * q) + np.random.default_rng(1).normal(0.0, 0.1, len(t))
    seen = SimpleNamespace(q=q[:, None], dq=np.gradient(q, t)[:, None])
    run = SimpleNamespace(context=seen, lowpass=Lowpass(len(t), 200.0, 90.0))
    robot = SimpleNamespace(prismatic=[slides])
    side = SimpleNamespace(
        runs=[run],
        contexts=[SimpleNamespace(robot=robot)],
        gathered=lambda parts, _: np.concatenate(parts),
    )
    (peak,) = order_peaks(side, {0: left[:: run.lowpass.factor]}, 0, 1)
    assert bool(abs(peak - 628.3) < np.pi / np.ptp(q)) is slides
