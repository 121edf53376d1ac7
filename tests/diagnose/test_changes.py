"""What changed since a model was made: friction that rose or fell, and how it is said."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from bare_sides import ar1
from two_links import V0, recordings, textbook, textbook_torque

from pa10d.diagnose.outcome.diagnosis import Confusion
from pa10d.diagnose.outcome.words import reason, sentence
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search import with_numbers
from pa10d.diagnose.search.judging import JudgedCandidate
from pa10d.effects import Value, all_effects, effect
from pa10d.effects.base import smooth_sign
from pa10d.model import Term


def sign(dq):
    return np.column_stack([smooth_sign(v, V0) for v in dq.T])


CHANGES = {
    "coulomb rose": ("coulomb", 1, 0.4, lambda dq: [0.0, 0.4] * sign(dq)),
    "coulomb fell": ("coulomb", 0, -0.8, lambda dq: [-0.8, 0.0] * sign(dq)),
    "viscous rose": ("viscous", 0, 0.6, lambda dq: [0.6, 0.0] * dq),
    "viscous fell": ("viscous", 1, -0.5, lambda dq: [0.0, -0.5] * dq),
    "rotor rose": ("rotor_inertia", 0, 0.25, None),
}


def asked(reference, runs):
    fit, judge = [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    return diagnose(reference, fit, judge, frozen=True)


LONG = set(CHANGES) - {"coulomb fell"}


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(k, marks=[pytest.mark.long] * (k in LONG)) for k in CHANGES]
)
def test_what_rose_or_fell_is_named_with_its_size(name):
    kind, joint, size, torque = CHANGES[name]
    rotor = size * np.eye(2)[joint]
    runs = recordings(3, lambda t, q, dq, ddq: torque(dq) if torque else rotor * ddq)
    found = asked(textbook(recordings(4)), runs)
    assert (found.verdict, found.unexplained) == ("missing", ())
    (finding,) = found.findings
    assert (finding.term.effect_id, finding.term.joints) == (kind, (joint,))
    value = finding.parameters[effect(kind).coefficients[0].name]
    assert abs(value.value - size) < 4 * value.std_error + 0.02 * abs(size)
    assert finding.rms_after[joint] < 0.1 * finding.rms_before[joint]
    way = "more" if size > 0 else "less"
    assert finding.sentence.startswith(f"Joint {joint + 1} now has {way} ")


@pytest.mark.long
def test_a_change_of_which_not_one_number_is_known_is_not_named(monkeypatch):
    """A clean arm "now has Stribeck friction", with Fs, vs and delta all not determined."""
    monkeypatch.setattr(with_numbers, "not_one", lambda term, found: bool(found))
    torque = CHANGES["coulomb rose"][-1]
    found = asked(textbook(recordings(4)), recordings(3, lambda t, q, dq, ddq: torque(dq)))
    assert found.findings == ()
    assert found.left.rms[1] > 2.0 * found.left.floor.values[1]


@pytest.mark.parametrize(
    ("kind", "name", "value", "kept"),
    [
        ("encoder_offset", "offset", 0.587, True),
        ("encoder_offset", "offset", 0.2, False),
        ("rotor_inertia", "Ia", -0.1, False),
    ],
)
def test_a_change_is_not_told_less_for_being_larger_than_it_may_be(kind, name, value, kept):
    """A zero that was off by 0.29 rad was named, and twice as much was "this data cannot say"."""
    named = effect(kind)
    term = Term(kind, (2,), np.array([value]), {})
    beyond = abs(value) > 0.5 or value < 0.0
    told = Value(value, 0.1, named.coefficients[0].unit, determined=False, beyond=beyond)
    assert with_numbers.too_large(term, {name: told}) is kept


@pytest.mark.long
def test_friction_that_came_at_low_speed_is_named_with_its_shape():
    """A joint that ran dry: it was "something that no effect of the library explains"."""

    def torque(t, q, dq, ddq):
        return [0.0, 0.8] * np.exp(-((dq / 0.3) ** 2)) * sign(dq)

    found = asked(textbook(recordings(4)), recordings(3, torque))
    (finding,) = found.findings
    assert (finding.term.effect_id, finding.term.joints) == ("stribeck", (1,))
    assert finding.sentence.startswith("Joint 2 now has Stribeck friction")
    for name, true in (("Fs", 0.8), ("vs", 0.3)):
        value = finding.parameters[name]
        assert abs(value.value - true) < 4 * value.std_error
        assert value.std_error < 0.3 * true


@pytest.mark.long  # test_as_it_stood has another
def test_a_doubtful_model_does_not_swallow_a_change():
    """Its coefficients are known to a few percent, as where it lacks something. Thousands of
    samples pulled them far away, and a motor that reads 6 % too high was denied."""
    reference = textbook(recordings(4))
    doubtful = replace(
        reference, covariance=3000.0 * reference.covariance, noise=np.array([0.2, 0.1])
    )

    def torque(t, q, dq, ddq):
        return [0.06, 0.0] * textbook_torque(q, dq, ddq)

    (finding,) = asked(doubtful, recordings(5, torque)).findings
    assert (finding.term.effect_id, finding.term.joints) == ("torque_gain", (0,))
    gain = finding.parameters["gain"]
    assert abs(gain.value - 0.06) < 3 * gain.std_error < 0.006


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_where_nothing_changed_friction_did_not(seed):
    def colour(rng, samples):
        return ar1(rng, samples, 0.95)

    found = asked(textbook(recordings(200 + seed)), recordings(100 + seed, colour=colour))
    assert (found.verdict, found.findings) == ("none", ())


@pytest.mark.long
def test_a_new_model_never_has_friction_below_nothing():
    """Less friction than the model has is a change of a frozen one; a refit just has less."""
    runs = recordings(3, lambda t, q, dq, ddq: [-0.8, 0.0] * sign(dq))
    fit, judge = [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    found = diagnose(textbook(recordings(4)), fit, judge)
    assert found.verdict == "none"
    for term in found.model.terms:
        assert term.effect_id != "coulomb" or term.coefficients[0] > 0


def said(
    kind: str, frozen: bool, size: float = 1.0, rivals: tuple[str, ...] = (), rms: float = 0.499
) -> str:
    one = effect(kind)
    joints = {"joint": (3,), "pair": (4, 5), "robot": ()}[one.scope]
    term = Term(kind, joints, np.full(len(one.coefficients), size))
    before = np.array([0.0, 0.0, 0.0, rms, 0.0, 0.0])
    after = before / 2
    doubts = [Confusion(other, joints, "alike") for other in rivals]
    return sentence(term, before, after, Value(0.4321, 0.01, "N·m"), doubts, frozen)


def test_a_sentence_says_what_where_how_much_and_what_it_takes_away():
    assert said("stribeck", False) == (
        "Joint 4 shows Stribeck friction (extra friction at low speed): about 0.43 N·m that the "
        "model lacks; with it 75 % of joint 4's squared error is gone."
    )
    assert said("coupling_inertia", False).startswith("Joints 5 and 6 show coupled rotor inertia (")
    assert said("payload", True).startswith(
        "The arm now has a payload: about 0.43 N·m that its model does not know;"
    )
    assert said("viscous", True, -1.0).startswith(
        "Joint 4 now has less viscous friction (friction in proportion to the speed) than its model"
    )
    doubtful = said("spring", False, rivals=("torque_offset", "contact"))
    assert doubtful.endswith(
        "This data cannot yet tell it from a contact beyond one angle or a torque offset."
    )


def test_a_spring_that_pushes_away_is_doubted():
    assert "It pushes away from q0" in said("spring", False, -1.0)
    assert "pushes" not in said("spring", False) + said("spring", True, -1.0)


def test_what_other_terms_stand_in_for_is_not_called_lacking():
    """Hysteresis is as large as the dry friction whose place it takes; an error is much less."""
    text = said("presliding_hysteresis", False, rms=0.1)
    assert "about 0.43 N·m, of which the model lacks 0.087 N·m; with it 75 %" in text
    assert "lacks" not in said("backlash", False, rms=0.1)


def test_what_bends_the_rest_is_lacking_more_than_itself():
    text = said("stribeck", False, rms=1.0)
    assert "about 0.43 N·m, and the model without it lacks 0.87 N·m; with it 75 %" in text


def test_the_same_effect_elsewhere_is_a_rival_with_its_place():
    one = Confusion("torque_gain", (1,), "alike")
    term, before = Term("torque_gain", (0,), np.array([0.1])), np.array([0.2, 0.1])
    text = sentence(term, before, before / 2, Value(0.4, 0.01, "N·m"), [one], False)
    assert text.endswith("This data cannot yet tell it from one of another size on joint 2.")


@pytest.mark.parametrize("kind", sorted(all_effects()))
def test_every_effect_has_a_sentence_of_one_breath(kind):
    for frozen in (False, True):
        text = said(kind, frozen)
        always = " Or it was there all along, where the model's own runs do not show it."
        no_change = effect(kind).question == "missing" and not effect(kind).also_changes
        assert text.endswith(always) is (frozen and no_change)
        text = text.removesuffix(always)
        assert 80 < len(text) < 240
        assert text.count(".") == text.count("0.43") + 1
        assert "_" not in text


def test_two_places_of_one_effect_are_confused_for_a_reason_in_words():
    spring = effect("spring")
    assert reason(spring, spring) == (
        "on this data both ask for nearly the same torque, and leave as small an error"
    )
    assert reason(spring, effect("contact")) == spring.confounders["contact"]


@pytest.mark.long  # as Stribeck friction above, of another effect
def test_what_came_of_the_rest_of_the_library_is_named_too():
    """A chipped tooth: "no effect of the library explains" it, and the library has it."""

    def torque(t, q, dq, ddq):
        return np.column_stack([np.zeros(len(q)), 0.4 * np.sin(9.0 * q[:, 1] + 0.5)])

    found = asked(textbook(recordings(4)), recordings(3, torque))
    (finding,) = found.findings
    assert (finding.term.effect_id, finding.term.joints) == ("torque_ripple", (1,))
    assert finding.sentence.startswith("Joint 2 now has torque ripple")
    for name, true in (("N", 9.0), ("amplitude", 0.4)):
        value = finding.parameters[name]
        assert abs(value.value - true) < 4 * value.std_error + 0.002 * true


@pytest.mark.parametrize(
    ("helped", "counts"), [((0.2, 0.29), False), ((0.2, 0.1), True), ((0.85, 0.1), True)]
)
def test_what_helps_only_where_the_model_lacked_as_much_before_is_no_change(helped, counts):
    """A base that leans, of an arm that did not change: joint 2 alone keeps more than usual."""
    seen = SimpleNamespace(
        before=np.array([0.85, 0.3]), after=np.array(helped), p_value=1e-9, slope=1.0, worse=()
    )
    leans = SimpleNamespace(effect=effect("base_tilt"), joints=(), shape={})
    judged = JudgedCandidate(leans, seen, 1e-9, usual=np.array([1.65, 0.25]))
    assert judged.acceptable == counts


@pytest.mark.parametrize(("leaves", "counts"), [(0.3, True), (2.2, False)])
def test_what_takes_more_than_a_joint_may_keep_is_no_slow_noise(leaves, counts):
    """An encoder zero that took 15 N·m of a real arm, where its model had left 1.8 on its own runs:
    "this data cannot say", for noise as slow as gravity would do as well, were there so much."""
    seen = SimpleNamespace(
        before=np.array([2.4, 0.1]),
        after=np.array([leaves, 0.1]),
        p_value=0.08,
        slope=0.9,
        worse=(),
    )
    leans = SimpleNamespace(effect=effect("base_tilt"), joints=(), shape={})
    at_most = np.array([1.0, 0.2])
    judged = JudgedCandidate(leans, seen, 0.3, usual=np.array([0.0, np.inf]), at_most=at_most)
    assert judged.acceptable == counts
    assert not replace(judged, at_most=None).acceptable


@pytest.mark.parametrize(("as_given", "counts"), [((0.149, 0.3), False), ((0.5, 0.3), True)])
def test_what_leaves_as_much_as_the_model_that_nothing_was_done_to_is_no_change(as_given, counts):
    """Moved within its own doubt to suit a few seconds it did worse on the others, and a base that
    leans takes that back."""
    seen = SimpleNamespace(
        before=np.array([0.326, 0.3]),
        after=np.array([0.147, 0.3]),
        p_value=1e-9,
        slope=1.0,
        worse=(),
    )
    leans = SimpleNamespace(effect=effect("base_tilt"), joints=(), shape={})
    judged = JudgedCandidate(leans, seen, 1e-9, usual=np.zeros(2), as_given=np.array(as_given))
    assert judged.acceptable == counts
