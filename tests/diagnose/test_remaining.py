"""What is left on a joint, numbers in: what is claimed, and what is said where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pa10d.compare.phrases import sentence
from pa10d.compare.places import Place
from pa10d.compare.quantities import Quantity
from pa10d.compare.regions import Region
from pa10d.diagnose.evidence.held_out import Evidence
from pa10d.diagnose.outcome.words import nothing
from pa10d.diagnose.unknown.as_it_stood import OneChange, alone_words
from pa10d.diagnose.unknown.claims import Unnamed, doubtful, material, unnamed
from pa10d.diagnose.unknown.of_joint import KnownBesides
from pa10d.diagnose.unknown.remaining import remaining
from pa10d.diagnose.unknown.structure import Structure
from pa10d.judgement import Judgement, NoiseFloor, Repeatable, Turning
from pa10d.model import Term

SURE, CHANCE = Repeatable(1e-9, 0.35, 500), Repeatable(0.3, 0.02, 500)


def judged(*ratios: float, source: str | None = "repeated motion", slow: float = 1.0) -> Judgement:
    """Of a model that leaves so many times a floor of 0.1 N·m."""
    floor = np.full(len(ratios), 0.1 if source else np.nan)
    known = NoiseFloor(floor, (source,) * len(ratios), 0.01 * floor, np.full(len(ratios), slow))
    return Judgement("m", ("run",), 10.0, 0.1 * np.array(ratios), known)


def claims(left: Judgement, again, doubt=0.0):
    return unnamed(left, again, [], np.full(len(left.rms), doubt))


def line(ratio: float, seen, source: str | None = "repeated motion"):
    left = judged(ratio, source=source)
    return remaining(left, [seen], claims(left, [seen]), ["N·m"])[0]


@pytest.mark.parametrize("ratio", [1.25, 1.4, 3.0])
def test_what_comes_again_is_claimed_from_where_it_matters(ratio):
    (said,) = claims(judged(ratio), [SURE])
    assert said.joint == 0
    assert line(ratio, SURE).significant


def test_a_map_of_a_small_part_does_not_speak_for_the_rest():
    left = judged(8.6)

    def sentence(share: float) -> str:
        seen = Unnamed(0, share, 0.1, 1e-9, "motion", ("dq1", "dq2"))
        return remaining(left, [None], [seen], ["N·m"])[0].sentence

    assert "what the rest, 8.2 times that floor, depends on is not known" in sentence(0.08)
    assert "the rest" not in sentence(0.99)


@pytest.mark.parametrize(
    ("ratio", "share", "claimed"),
    [(1.0, 0.06, False), (1.0, 0.4, True), (1.4, 0.06, True), (float("nan"), 0.06, True)],
)
def test_a_trace_in_an_error_that_is_noise_is_told_and_not_claimed(ratio, share, claimed):
    """A coarse encoder, nothing hidden: "unknown", at 1.0 times the floor."""
    seen = judgement_of_a_map(share)
    left = judged(ratio) if np.isfinite(ratio) else judged(1.0, source=None)
    worth, slight = material(left, [seen])
    assert [bool(worth), bool(slight)] == [claimed, not claimed]
    if slight:
        (said,) = remaining(left, [None], worth, ["N·m"], KnownBesides(slight=slight))
        assert said.significant
        assert said.material is False
        assert "explained to the floor. 6 % of its squared error depends on dq2" in said.sentence


def judgement_of_a_map(share: float, beyond: float = 0.0) -> Structure:
    nothing = np.zeros(1)
    evidence = Evidence(1.0, 9.0, 1e-9, nothing, nothing, (), 9.0, nothing)
    return Structure(
        0, ("dq2",), share, 0.1, 1e-9, (nothing,), nothing, evidence, np.ones(1, bool), 0.01,
        share / (1.0 - beyond), beyond,
    )  # fmt: skip


def test_error_where_the_fit_side_has_not_been_is_no_error_of_the_maps():
    """ "79 % of it depends on q3", where 80 % of it lay beyond the angles of the fit side."""
    seen = judgement_of_a_map(0.15, beyond=0.8)
    (said,) = remaining(judged(9.6), [None], [seen], ["N·m"])
    assert "15 % of its squared error depends on dq2" in said.sentence
    assert "80 % lies where the fit side has not been" in said.sentence
    assert "the rest, 8.9 times that floor" in said.sentence
    (said,) = remaining(judged(9.6), [None], [judgement_of_a_map(0.15)], ["N·m"])
    assert "has not been" not in said.sentence


def test_findings_that_follow_the_angle_may_be_parts_of_the_curve_that_is_left():
    """A counterbalance that the library lacks was a contact and two ripples."""
    left, found = judged(2.1), [Term(kind, (0,), np.zeros(2)) for kind in ("contact", "spring")]

    def sentence(variable: str, terms: list[Term]) -> str:
        seen = Unnamed(0, 0.56, 0.1, 1e-9, "motion", (variable,))
        return remaining(left, [None], [seen], ["N·m"], KnownBesides(found=terms))[0].sentence

    assert "may be no more than parts of one such curve" in sentence("q1", found)
    assert "parts" not in sentence("q1", found[:1]) + sentence("dq1", found)


def test_what_swings_on_beside_a_spring_that_was_found_is_first_of_all_that_spring():
    """It was "a liquid or a load that is not tight", alone."""
    ring = Unnamed(0, 0.5, 0.1, 1e-4, "ring", hertz=7.6)
    shape = {"K": 1000.0, "zeta": 0.02}
    spring = Term("joint_elasticity", (1,), np.zeros(0), shape)
    said = remaining(judged(5.0), [None], [ring], ["N·m"], KnownBesides(found=[spring]))[0].sentence
    assert "the spring that was found in joint 2, if it is other than its law has it" in said
    assert "found in" not in remaining(judged(5.0), [None], [ring], ["N·m"])[0].sentence


def test_what_does_not_come_again_or_does_not_matter_is_no_claim():
    assert claims(judged(1.15, 1.9), [SURE, CHANCE]) == []


@pytest.mark.parametrize("seen", [None, CHANCE])
@pytest.mark.parametrize("source", ["repeated motion", "high frequencies", "standstill"])
def test_an_error_of_many_times_the_floor_is_never_called_nothing(source, seen):
    """Whatever nobody can name: 39.8 times the floor was once "nothing is missing"."""
    (claim,) = claims(judged(12.0, source=source), [seen])
    assert (claim.witness, claim.variables) == ("size", ())
    assert claim.share == pytest.approx(1 - 1 / 144)
    assert bool(claims(judged(5.0, source=source), [seen])) == (source == "repeated motion")
    said = line(12.0, seen, source)
    assert said.significant
    assert "more than the noise that can be seen" in said.sentence
    assert "explained" not in said.sentence


def test_a_floor_that_is_hardly_known_makes_no_claim_by_size():
    left = judged(2.5)
    vague = replace(left.floor, errors=0.2 * left.floor.values)
    assert claims(left, [None])
    assert not claims(replace(left, floor=vague), [None])
    assert not claims(judged(5.0, source=None), [None])
    assert not claims(judged(70.0, slow=80.0), [None]), "slow noise may be that much stronger"
    assert not claims(judged(70.0, slow=np.inf), [None])
    assert claims(judged(100.0, slow=80.0), [None]), "no noise that grows like this is as strong"
    assert not claims(left, [None], doubt=0.2)


def test_many_joints_make_an_accident_likelier():
    near = Repeatable(5e-4, 0.35, 500)
    assert claims(judged(1.4), [near])
    assert not claims(judged(1.4, 1.0, 1.0), [near, CHANCE, CHANCE])


def test_what_the_coefficients_own_uncertainty_makes_is_nothing_missing():
    """It comes again as well: the same wrong coefficients meet the same motion."""
    left = judged(1.4)
    assert claims(left, [SURE], doubt=0.05)
    assert not claims(left, [SURE], doubt=0.1)


def test_coefficients_are_no_excuse_where_the_fit_itself_leaves_much():
    """320 times the floor was "no more than uncertain coefficients may leave", and "none": so were
    the runs that they had been fitted to."""
    left, doubt = judged(30.0, 30.0, source="high frequencies"), np.array([9.0, 9.0])
    fitted = np.array([0.1, 3.0])  # N·m; noise may be 1 N·m and a little
    assert doubtful(left, fitted, doubt).tolist() == [9.0, 0.0]
    said = unnamed(left, [None, None], [], doubtful(left, fitted, doubt))
    assert [one.joint for one in said] == [1]
    nobody_knows = judged(30.0, 30.0, source=None)
    assert doubtful(nobody_knows, fitted, doubt).tolist() == [9.0, 9.0]


@pytest.mark.parametrize("source", ["high frequencies", None])
def test_what_little_data_leaves_open_asks_for_more_data_to_fit(source):
    """26 times its floor after a fit to ten seconds: neither slow noise nor something missing."""

    def sentence(doubt: float) -> str:
        left = judged(8.0, source=source)
        return remaining(left, [None], [], ["N·m"], KnownBesides(doubt=np.array([doubt])))[
            0
        ].sentence

    assert sentence(0.9).endswith("may leave as much: fit to more data.")
    assert "fit to more data" not in sentence(0.5)


@pytest.mark.parametrize("source", ["repeated motion", "high frequencies", "standstill"])
@pytest.mark.parametrize("seen", [None, CHANCE])
def test_no_large_ratio_is_called_noise_without_a_witness(source, seen):
    """Nor the floor's own way of being seen passed over: fast wavering is no proof of slow."""
    said = line(1.8, seen, source)
    assert not said.significant
    assert said.material
    assert "noise or what" in said.sentence or "this data cannot" in said.sentence
    assert "explained" not in said.sentence


@pytest.mark.parametrize(("ratio", "claimed"), [(4.0, False), (40.0, True)])
def test_where_an_error_is_larger_is_said_and_claims_nothing_by_itself(ratio, claimed):
    """compare said so, and the diagnosis that motion does not predict it."""
    speed = Quantity("|dq|", 0, "rad/s")
    region = Region(speed, 0.0, 0.1, True, False, 0.94, 0.17)
    place = Place(0, region, sentence(0, region, "N·m"), 1e-3)
    left = judged(ratio, source="high frequencies")
    found = claims(left, [None])
    assert bool(found) == claimed
    (said,) = remaining(left, [None], found, ["N·m"], KnownBesides(stand_out=[place]))
    assert "; joint 1 below 0.10 rad/s carries 94 % of its squared error" in said.sentence
    assert "does not predict" not in said.sentence
    assert said.significant == claimed


@pytest.mark.parametrize(("share", "beside"), [(0.1, True), (0.7, False)])
def test_where_more_lies_than_a_witness_speaks_of_is_said_with_what_acts_there(share, beside):
    """Play: a tenth of it swings on, and four fifths lie where the load changes its sign."""
    region = Region(Quantity("load", 0, "N·m"), -0.9, 0.8, False, False, 0.82, 0.21)
    place = Place(0, region, sentence(0, region, "N·m"), 1e-3)
    left = judged(31.0, source="high frequencies")
    swings = Unnamed(0, share, 0.1, 1e-6, "ring", hertz=6.5)
    (said,) = remaining(left, [None], [swings], ["N·m"], KnownBesides(stand_out=[place]))
    assert "swings at about 6.5 Hz" in said.sentence
    assert ("carries 82 % of its squared error" in said.sentence) == beside
    assert ("play, or a gear or a belt that gives" in said.sentence) == beside
    assert ("a liquid or a load that is not tight" in said.sentence) != beside


def test_what_is_there_around_reversals_is_told_unless_the_fit_leaves_as_much_open():
    """The same witness, with and without doubt of the model's own that covers it."""
    around = Turning(p_value=1e-9, share=0.5, larger=40, strokes=40)
    left = judged(1.9)
    said = unnamed(left, [None], [], np.zeros(1), turned=[around])
    assert [(one.joint, one.witness) for one in said] == [(0, "turning")]
    (told,) = remaining(left, [None], said, ["N·m"])
    assert "50 % of its squared error is there around reversals and gone" in told.sentence
    assert unnamed(left, [None], [], np.full(1, 2.0), turned=[around]) == []


@pytest.mark.parametrize(("as_given", "told"), [(0.15, True), (0.3, False)])
def test_a_frozen_model_that_was_moved_away_from_the_held_out_runs_says_what_it_left(
    as_given, told
):
    left = judged(3.26)
    (said,) = remaining(left, [None], [], ["N·m"], KnownBesides(as_given=np.array([as_given])))
    assert ("Where it was not moved the model leaves 0.15 N·m there" in said.sentence) is told


@pytest.mark.parametrize(("share", "told"), [(0.78, True), (0.3, False)])
def test_what_a_map_outdid_is_told_where_it_took_most(share, told):
    """``compare`` said "off by a constant, 77 %" beside "no effect … explains it"."""
    left, seen = judged(4.8), judgement_of_a_map(0.89)
    outdone = {0: (("a torque offset",), share)}
    (said,) = remaining(left, [None], [seen], ["N·m"], KnownBesides(outdone=outdone))
    looks = "What looks like a torque offset there (78 % of its squared error) is part of that:"
    assert (looks in said.sentence) is told


def test_where_no_floor_is_known_noise_is_no_more_than_the_fitted_runs_keep():
    """5.7 N·m beside 0.33 on the fitted run: "this data cannot say how much of it is noise"."""
    left = judged(57.0, source=None)

    def said(most: float) -> str:
        return remaining(left, [None], [], ["N·m"], KnownBesides(most_noise=np.array([most])))[
            0
        ].sentence

    assert "Hardly more than 0.33 N·m is noise as it was on the runs that" in said(0.33)
    assert "cannot say how much of it is noise" in said(5.5)


def test_two_angles_that_pull_at_one_joint_may_pull_at_another():
    """A hose to the elbow: "no one or two quantities do" beside "depends on q1 and q2"."""
    left = judged(3.5, 6.7)
    foretold = Unnamed(0, 0.64, 0.2, 1e-9, "motion", best_from="joint 1's position and speed")
    pulled = replace(judgement_of_a_map(0.7), joint=1, variables=("q1", "q2"))
    said, _ = remaining(left, [None, None], [foretold, pulled], ["N·m"] * 2)
    assert said.sentence.endswith("surely does. Or it is q1 and q2, as on joint 2.")
    alone, _ = remaining(left, [None, None], [foretold], ["N·m"] * 2)
    assert "best from joint 1's position and speed; no map" in alone.sentence
    assert alone.sentence.endswith("surely does.")


def test_a_frozen_joint_that_keeps_what_it_lacked_is_told_its_knocks_and_what_the_band_hides():
    """Its line was cut down to "the model lacked about as much", whatever else was known."""

    def said(**more) -> str:
        seen = judgement_of_a_map(0.7)
        left = judged(5.0)
        return remaining(
            left, [None], [seen], ["N·m"], KnownBesides(usual=np.array([1.0]), **more)
        )[0].sentence

    assert "depends on" not in said()
    assert said().endswith("ask what is missing, not what changed.")
    assert said(lacked=np.array([0.45])) == said()
    assert "the model left 0.28 N·m, and another motion" in said(lacked=np.array([0.28]))
    assert "72 times a turn" in said(faster={0: "an error that comes again 72 times a turn"})
    left = judged(5.0)
    (line,) = remaining(
        left,
        [None],
        [],
        ["N·m"],
        KnownBesides(usual=np.array([1.0]), knocked={0: "87 % lies in 0.6 of 11 s"}),
    )
    assert "87 % lies in 0.6 of 11 s" in line.sentence


def test_what_one_change_would_do_is_not_called_unpredicted():
    """ "Motion does not predict it" stood below "a spring alone takes more than 99 % of it"."""
    spring = OneChange(("spring", (0,)), "a spring (k about 0.3 N·m/rad)", np.array([0.98, 0.2]))
    alone = alone_words(np.array([0.356, 0.1]), {0: spring}, ["N·m", "N·m"])
    (said,) = remaining(judged(5.0), [None], [], ["N·m"], KnownBesides(alone=alone))
    assert said.sentence.endswith(
        "; a spring (k about 0.3 N·m/rad) alone takes 98 % of the 0.356 N·m that the model leaves "
        "there as it was given."
    )


@pytest.mark.parametrize(("fitted", "said"), [(1.05, False), (3.2, True), (float("nan"), False)])
def test_what_the_fitted_runs_keep_themselves_is_not_for_want_of_motion(fitted, said):
    """ "Fit to motion like this one" was all that was said of a joint at 3.2 times its floor
    on the very runs that its model was fitted to."""
    (line,) = remaining(judged(6.0), [None], [], ["N·m"], KnownBesides(undetermined={0: fitted}))
    assert "do not determine the arm for this motion" in line.sentence
    assert ("on the fitted runs themselves it keeps 3.2 times" in line.sentence) == said


@pytest.mark.parametrize(
    ("source", "said"),
    [("repeated motion", "(from repeated motion): the fitted runs do not"), (None, ". The fitted")],
)
def test_why_a_floor_is_not_known_is_no_matter_of_motion(source, said):
    """ "Its noise floor is not known from this data: the fitted runs do not determine the arm"."""
    known = KnownBesides(undetermined={0: 1.05})
    (line,) = remaining(judged(2.0, source=source), [None], [], ["N·m"], known)
    assert said in line.sentence


def test_a_floor_that_is_hardly_known_says_so():
    left = judged(1.0)
    unsure = replace(left.floor, errors=0.4 * left.floor.values)
    (said,) = remaining(replace(left, floor=unsure), [None], [], ["N·m"])
    assert "(give or take 40 %, from repeated motion)" in said.sentence
    assert said.sentence.endswith(": explained to the floor, as far as that is known.")
    assert "give or take" not in line(1.0, None).sentence
    assert line(1.0, None).sentence.endswith(": explained to the floor.")


def test_a_floor_that_is_not_known_at_all_asks_for_a_repeat():
    """ "Explained to the floor, as far as that is known" was said of one give or take 664 %."""
    left = judged(1.0, source="high frequencies")
    guessed = replace(left.floor, errors=2.0 * left.floor.values)
    (said,) = remaining(replace(left, floor=guessed), [None], [], ["N·m"])
    assert "explained" not in said.sentence
    assert said.sentence.endswith(
        "this data cannot say how much of it is noise. Record one motion twice: what comes again "
        "is none."
    )


@pytest.mark.parametrize(
    ("source", "error", "hardly"),
    [
        ("high frequencies", 1.2, True),
        ("high frequencies", 0.6, False),
        ("the model's own runs", np.nan, False),
        ("repeated motion", 1.2, False),
    ],
)
def test_headline_and_line_agree_on_how_well_noise_is_known(source, error, hardly):
    """ "What the model leaves over is measurement noise" stood above "this data cannot say how much
    of it is noise", which was also said of a floor that the model's own runs had shown."""
    floor = NoiseFloor(np.array([0.1]), (source,), np.array([0.1 * error]), np.ones(1))
    left = Judgement("m", ("run",), 10.0, np.array([0.1]), floor)
    (said,) = remaining(left, [None], [], ["N·m"])
    assert ("says next to nothing" in said.sentence) == hardly
    assert ("explained to the floor, as far as that is known" in said.sentence) == (not hardly)
    joints = np.flatnonzero(floor.hardly_known).tolist()
    headline = nothing(left.rms, floor.values, frozen=False, hardly_known=joints)
    assert ("of the noise of joint 1 this data says next to nothing" in headline) == hardly
    assert headline.startswith(
        "Nothing is missing that shows: " if hardly else "Nothing is missing: "
    )
