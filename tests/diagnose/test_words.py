"""The verdict in words."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from two_links import motion, recordings, robot, state_of, textbook, textbook_torque

from pa10d.diagnose.outcome.diagnosis import Finding
from pa10d.diagnose.outcome.doubts import _beside_more, _or_base
from pa10d.diagnose.outcome.found import _size, _size_told, sized
from pa10d.diagnose.outcome.words import none_found, nothing, sentence
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.candidates import absorbed
from pa10d.diagnose.unknown.remaining import Remaining
from pa10d.dynamics import robot_from_profile
from pa10d.effects import Value, effect
from pa10d.figures.of_diagnosis import shown_joint
from pa10d.measurement.recording import Recording
from pa10d.model import Term
from pa10d.profile import load_profile


def test_noise_is_noise():
    said = nothing([0.1, 0.2, 0.3], [0.1, 0.19, 0.25], frozen=False)
    assert (
        said == "Nothing is missing: what the model leaves over on new data is measurement noise."
    )


def test_what_only_a_new_fit_took_away_is_said_too():
    """The noise of the refitted model is no praise of the one that was given."""
    said = nothing([0.1, 0.2], [0.1, 0.2], frozen=False, as_given=[0.14, 0.2])
    assert "as it was given, it keeps up to 1.4 times the noise on joint 1" in said
    assert nothing([0.1], [0.1], False, as_given=[0.11]) == nothing([0.1], [0.1], False)
    assert "given" not in nothing([0.1], [float("nan")], False, as_given=[0.3])


def test_what_reversals_leave_is_said_where_they_are_left_out():
    """Friction of low speeds may hide there: 25 N·m beside 60 were called nothing. Or nothing does:
    a clean arm that turns round within a sample had "sticking, or friction that the model lacks".
    """
    said = nothing([0.1, 0.2], [0.1, 0.2], False, with_reversals=[0.24, 0.2])
    assert "with them, there is up to 2.4 times the noise on joint 1:" in said
    assert "or turning round faster than the samples follow" in said
    assert nothing([0.1], [0.1], False, with_reversals=[0.11]) == nothing([0.1], [0.1], False)


def test_an_error_that_follows_nothing_is_owned_up_to():
    said = nothing([0.1, 0.16, 0.34], [0.1, 0.1, 0.2], frozen=True)
    assert said.startswith("Nothing has changed that this data can show. Joints 2 and 3 keep up")
    assert "1.7 times the noise" in said
    assert nothing([0.1, 0.17], [0.1, 0.1], frozen=False).count("Joint 2 keeps") == 1


@pytest.mark.parametrize(("frozen", "asked"), [(True, "has changed"), (False, "is missing")])
def test_many_times_the_noise_are_not_called_nothing(frozen, asked):
    said = nothing([0.1, 0.5, 0.6], [0.1, 0.1, 0.2], frozen=frozen)
    assert said.startswith(f"This data cannot say whether something {asked}: joints 2 and 3 keep")
    assert "5.0 times the noise" in said
    assert ("ask what has changed" in said) != frozen


def test_no_noise_floor_is_no_claim():
    assert "keep" not in nothing([0.1, 0.47], [float("nan"), 0.4], frozen=False)
    assert "keep" not in nothing([0.1, 0.47], [0.0, 0.4], frozen=False)


def test_a_size_that_reaches_zero_is_owned_up_to():
    said = [
        sentence(
            Term("torque_offset", (0,), np.array([0.8])), np.array([1.0]), np.array([0.5]),
            Value(0.8, 0.1, "N·m"), (), frozen=False, sized=so,
        )
        for so in (True, False)
    ]  # fmt: skip
    assert said[1].startswith(said[0])
    assert "How large it is, this data hardly says" in said[1].removeprefix(said[0])


@pytest.mark.parametrize(
    ("values", "covariance", "expected"),
    [
        ([0.78], [[0.76**2]], False),
        ([0.78], [[0.39**2]], True),
        ([1.0, 1.0], [[1.0, 0.0], [0.0, 1.0]], False),
        ([1.0, 1.0], [[1.0, -0.9], [-0.9, 1.0]], True),  # each as good as zero, their sum is not
    ],
)
def test_coefficients_are_told_from_zero_together(values, covariance, expected):
    model = SimpleNamespace(
        terms=[SimpleNamespace(coefficients=np.array(values))],
        term_slice=lambda _: slice(0, len(values)),
        covariance=np.array(covariance),
    )
    assert sized(model, 0) is expected


def test_one_suspicion_that_is_not_confirmed_says_nothing_of_others():
    found = SimpleNamespace(only="a torque offset", stood="", absorbed=False)
    assert none_found(found) == (
        "This data does not show a torque offset; nothing else was looked for."
    )


def test_what_the_model_takes_for_its_own_is_not_said_not_to_be_there():
    """Nearly upright a spring is a weight: "this data does not show a spring" hid 60 N·m/rad."""
    t, q, dq, ddq = motion(7)
    q, dq, ddq = 0.05 * q + [0.3, -0.2], 0.05 * dq, 0.05 * ddq
    noise = 0.002 * np.random.default_rng(7).standard_normal(q.shape)
    near = Recording("near", t, q, textbook_torque(q, dq, ddq) + noise)
    train, held, _ = two_sides(model := textbook(recordings(7)), [near], [])
    spring = [(effect("spring"), (1,))]
    assert absorbed(SearchState.start(model, train, held), spring)
    assert not absorbed(state_of(recordings(7)), spring)
    found = SimpleNamespace(only="a spring", stood="", absorbed=True)
    assert none_found(found).startswith("This data cannot tell a spring from what the model has")


def test_one_joint_is_told_by_its_sentence_its_cards_and_its_plots():
    """A finding in joint 2 that takes 14 % there: the cards told of 1 % of joint 1's."""
    term = Term("load_friction", (1,), np.array([0.1]), {"v0": 0.01})
    before, after = np.array([2.0, 0.2]), np.array([1.98, 0.1855])
    found = SimpleNamespace(
        findings=[SimpleNamespace(term=term, rms_before=before, rms_after=after)]
    )
    assert shown_joint(found, 0) == 1
    said = sentence(term, before, after, Value(0.07, 0.01, "N·m"), [], False)
    assert "with it 14 % of joint 2's squared error is gone" in said


@pytest.mark.parametrize(
    ("others", "told"),
    [([1], "of joint 2, and"), ([1, 2], "of joints 2 and 3, each as far as it weighs the same")],
)
def test_a_gain_is_held_against_those_that_weigh_the_same(others, told):
    """Joints 1, 2, 5 and 6 were told as one, of which the wrist read 14 % less than the others."""
    term = Term("torque_gain", (0,), np.array([0.1]))
    left = np.array([1.0, 0.1, 0.1]), np.array([0.1, 0.1, 0.1])
    said = sentence(term, *left, Value(0.5, 0.01, "N·m"), [], False, others)
    assert f"this one is against that {told}" in said


def test_what_helps_only_beside_what_came_later_is_told_by_that():
    """It was told that "the model lacks 0 N·m; with it -2 % of joint 1's squared error is gone"."""
    term = Term("presliding_hysteresis", (0,), np.array([0.35]), {"zs": 0.002})
    came = np.array([0.0372]), np.array([0.03748])
    told = sentence(term, *came, Value(0.35, 0.04, "N·m"), [], False)
    assert "with it -2 % of joint 1's squared error is gone." in told
    last = np.array([0.0185]), np.array([0.0148])
    told = sentence(term, *came, Value(0.35, 0.04, "N·m"), [], False, beside=last)
    assert "of which the model lacks 0.011 N·m; with it 36 % of joint 1's squared error is" in told
    assert told.endswith("is gone, beside what follows: when it came, hardly any was.")
    told = sentence(term, *last, Value(0.35, 0.04, "N·m"), [], False, beside=last)
    assert told.endswith("36 % of joint 1's squared error is gone.")


@pytest.mark.parametrize(
    ("ratio", "significant", "before"),
    [
        (10.0, True, 5.0), (10.0, False, 5.0), (1.6, True, 5.0), (11.0, False, 5.0),
        (4.8, False, 0.53), (1.6, False, 0.2), (1.4, False, 0.15),
    ],
)  # fmt: skip
def test_what_is_named_beside_much_that_is_not_may_stand_in_for_it(ratio, significant, before):
    """Another joint's torque in this one's reading: "an offset", 4 standard errors, and 10 times
    the floor left. A cable with a memory: "coupled friction", 17 % of the error, and 4.8 times the
    floor that "motion does not predict"."""
    term = Term("torque_offset", (0,), np.array([-0.004]))
    values = np.array([before]), np.array([0.1 * ratio])
    finding = Finding(
        term, {}, *values, 1e-9, 1.0, Value(0.004, 0.001, "N·m"), (), None, "Joint 1 shows it."
    )
    line = Remaining(0, 0.1 * ratio, 0.1, "high frequencies", significant, True, None, (), "")
    said = _beside_more(finding, [line]).sentence
    doubted = ratio > 10.0 or (ratio > 2.0 and significant) or (ratio > 1.5 and before < 1.0)
    assert said.endswith("for what is missing there.") == doubted
    assert ("times its noise floor" in said) == doubted


def test_a_spring_whose_torque_is_not_its_own_may_stand_in_for_another():
    """Springs in two joints, one found: its share was 1.084, its K four standard errors off."""
    values = np.array([4.7]), np.array([1.9])
    line = Remaining(0, 1.9, 0.8, "high frequencies", False, False, None, (), "")
    for share, doubted in ((1.0, False), (1.084, True)):
        term = Term("joint_elasticity", (0,), np.array([share]), {"K": 5e4, "zeta": 0.015})
        size = Value(5.5, 0.1, "N·m")
        finding = Finding(term, {}, *values, 1e-9, 1.0, size, (), None, "Joint 1 gives.")
        said = _beside_more(finding, [line]).sentence
        assert said.endswith("for what is missing there.") == doubted


@pytest.mark.parametrize(
    ("share", "error", "doubted"),
    [(0.69, 0.044, True), (0.69, 0.1, False), (1.02, 0.001, False), (1.0, 0.05, False)],
)
def test_a_spring_that_does_not_pass_all_of_its_joint_s_torque_is_doubted(share, error, doubted):
    """A base on springs: elasticity of a joint that does not give, its share 7 errors off. Where
    the joint kept 2.3 times its floor only that was said."""
    term = Term("joint_elasticity", (0,), np.array([share]), {"K": 850.0, "zeta": 0.08})
    finding = Finding(
        term,
        {"share": Value(share, error, "1")},
        *(np.array([0.4]), np.array([0.15])),
        *(1e-9, 1.0, Value(0.4, 0.1, "N·m"), (), None, "Joint 1 gives."),
    )
    for floor in (0.1, 0.06):
        line = Remaining(0, 0.15, floor, "high frequencies", False, True, None, (), "")
        said = _beside_more(finding, [line]).sentence
        assert ("a frame that gives" in said) == doubted
        assert ("for what is missing there" in said) or not (doubted and floor < 0.1)


@pytest.mark.parametrize(("error", "doubted"), [(0.028, True), (0.1, False)])
def test_a_gap_whose_torque_is_surely_not_its_own_may_stand_in(error, doubted):
    """A gap of 0.8 mrad: its share was 0.737, nine standard errors off, and nothing was said."""
    line = Remaining(0, 0.2635, 0.0615, "high frequencies", False, False, None, (), "")
    term = Term("backlash", (0,), np.array([0.737]), {"b": 9e-4})
    finding = Finding(
        term,
        {"share": Value(0.737, error, "1")},
        *(np.array([0.4]), np.array([0.26])),
        *(1e-9, 1.0, Value(0.4, 0.1, "N·m"), (), None, "Joint 1 has play."),
    )
    said = _beside_more(finding, [line]).sentence
    assert ("for what is missing there." in said) == doubted


@pytest.mark.parametrize(
    ("share", "error", "told"), [(0.834, 0.01, True), (0.834, 0.05, False), (0.95, 0.005, False)]
)
def test_play_whose_torque_is_less_than_its_law_says_tells_so(share, error, told):
    """Play of a small servo at its floor: 0.83 ± 0.01, and nothing was said of that."""
    line = Remaining(0, 0.1, 0.1, "high frequencies", False, False, None, (), "")
    term = Term("backlash", (0,), np.array([share]), {"b": 0.022})
    finding = Finding(
        term,
        {"share": Value(share, error, "1")},
        *(np.array([0.7]), np.array([0.1])),
        *(1e-9, 1.0, Value(0.7, 0.1, "N·m"), (), None, "Joint 1 has play."),
    )
    said = _beside_more(finding, [line]).sentence
    assert ("comes out at 0.83 ± 0.01 and not at 1" in said) == told
    assert said.startswith("Joint 1 has play.")


@pytest.mark.parametrize(
    ("kind", "joint", "gravity", "told"),
    [("encoder_offset", 0, (9.81, 0.0, 0.0), True), ("encoder_offset", 0, (0.0, 0.0, -9.81), False),
     ("encoder_offset", 1, (9.81, 0.0, 0.0), False), ("torque_offset", 0, (9.81, 0.0, 0.0), False)],
)  # fmt: skip
def test_a_zero_of_a_level_first_joint_may_be_the_base(kind, joint, gravity, told):
    """An arm on a wall, rolled by 0.02 rad: "an encoder offset", and no doubt of it."""
    robot = robot_from_profile(load_profile("pa10-sim")).with_gravity(np.array(gravity))
    term, size = Term(kind, (joint,), np.array([0.02]), {}), Value(1.0, 0.1, "N·m")
    values = np.full(7, 2.0), np.full(7, 1.0)
    finding = Finding(term, {}, *values, 1e-9, 1.0, size, (), None, "It has an offset.")
    assert ("A base that has turned" in _or_base(finding, robot).sentence) == told


def test_what_the_band_hides_is_said_where_nothing_was_found_in_it():
    """0.18 N·m of cogging above the low-pass, beside 0.012 that were judged."""
    alone = SimpleNamespace(
        only="",
        stood="",
        beside="",
        frozen=False,
        rms=[0.1, 0.1],
        as_given=SimpleNamespace(rms=[0.1, 0.1]),
        noise_floor=[0.1, 0.1],
        left=SimpleNamespace(floor=SimpleNamespace(hardly_known=np.zeros(2, dtype=bool))),
        with_reversals=None,
        knocked=(0,),
        above_band={1: "an error that comes again 72 times a turn"},
    )
    assert none_found(alone).endswith(
        " Most of what joint 1 leaves lies in a few moments."
        " That is what the low-pass lets through: above it there is more on joint 2."
    )


def test_the_size_of_an_effect_is_as_unsure_as_its_torque_constant():
    """A card told of 3 ± 0.003 N·m, the table below it of F = 3 ± 0.15."""
    term = Term("coulomb", (1,), np.array([3.0]), {"v0": 0.01})
    state = SimpleNamespace(
        blocks=[(None, {1: np.array([[1.0], [-1.0]])})],
        terms=[term],
        model=SimpleNamespace(robot=replace(robot(), gain_error=np.array([0.5, 0.05]))),
    )
    told = _size(state, 0, SimpleNamespace(evidence=SimpleNamespace(slope=1.0, z=1000.0)))
    assert (told.value, told.unit) == (3.0, "N·m")
    assert told.std_error == pytest.approx(np.hypot(0.05 * 3.0, 0.003))


@pytest.mark.parametrize(
    ("known", "share", "other_than_zero", "told"),
    [
        (True, False, False, True),  # K within 9 %: "how large it is, this data hardly says"
        (False, False, False, False),
        (False, True, True, True),
        (False, True, False, False),
    ],
)
def test_the_size_of_what_has_a_share_alone_is_in_its_shape(known, share, other_than_zero, told):
    spring = Term("joint_elasticity", (0,), np.array([1.0]), {"K": 6e4, "zeta": 0.1})
    parameters = {
        "share": Value(1.0, 0.9, "1", determined=share),
        "K": Value(6e4, 5e3, "N·m/rad", determined=known),
    }
    assert _size_told(spring, parameters, other_than_zero) is told
