"""Something was changed between two runs that were both fitted: it is said, and as what."""

from __future__ import annotations

import numpy as np
import pytest
from bare_sides import ar1
from foreign_laws import stress_that_relaxes
from two_links import RATE, motion, recordings, robot, state_of, textbook, textbook_torque

from pa10d.diagnose.outcome.words import unexplained
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.suspects import suspects
from pa10d.diagnose.unknown.between_runs import _brought, contradiction, unlike_fitted
from pa10d.dynamics import inverse_dynamics
from pa10d.effects import effect
from pa10d.effects.base import Value
from pa10d.measurement.recording import Recording
from pa10d.report.finding_section import Asked
from pa10d.report.unexplained_section import unexplained_section
from pa10d.report.verdict import headline

MOMENT = 6.0  # s into a run
HELD_OUT = 7.4  # s into a run, of which blocks of five seconds judge by turns


def told_of(runs):
    """Whatever the noise floor is."""
    return contradiction(state_of(runs), suspects(True, 2), np.zeros(2)).told


def more_mass(t, q, dq, ddq):
    """0.8 kg, 0.3 m along the second link."""
    mass, com = 0.8, np.array([0.0, 0.0, 0.3])
    about = mass * (com @ com * np.eye(3) - np.outer(com, com))
    bodies = np.array(robot().parameters, dtype=float).reshape(2, 10)
    bodies[1] += np.r_[mass, mass * com, about[np.triu_indices(3)]]
    told = inverse_dynamics(robot(), bodies.reshape(np.shape(robot().parameters)), q, dq, ddq)
    return told - inverse_dynamics(robot(), robot().parameters, q, dq, ddq)


CHANGES = {
    "a payload": (more_mass, (0, 1)),
    "Coulomb friction": (
        lambda t, q, dq, ddq: np.outer(np.tanh(dq[:, 1] / 0.01), [0.0, 0.5]),
        (1,),
    ),
    "viscous friction": (lambda t, q, dq, ddq: np.outer(dq[:, 0], [0.8, 0.0]), (0,)),
    "a torque offset": (lambda t, q, dq, ddq: np.outer(np.ones(len(t)), [0.8, 0.0]), (0,)),
}


def changed_between(change, seed=5):
    """The second fitted run has it alone."""
    return {**recordings(seed), "fit_b": recordings(seed, change)["fit_b"]}


@pytest.mark.by_default("a payload")
@pytest.mark.parametrize("name", CHANGES)
def test_what_one_run_asks_for_by_itself_is_told_with_its_joints(name):
    change, joints = CHANGES[name]
    told = told_of(changed_between(change))
    assert tuple(one.joint for one in told) == joints
    for one in told:
        assert (one.effects, one.others, one.runs) == ((name,), ("fit_a",), ("fit_b",))
        assert one.share > 0.98


@pytest.mark.long
@pytest.mark.by_default("False-where0")
@pytest.mark.parametrize(
    ("before", "where"), [(False, ("fit_a", "fit_b")), (False, ("fit_b",)), (True, ("fit_a",))]
)
def test_what_an_arm_picks_up_on_its_way_is_told_with_the_moment(before, where):
    def held(t, q, dq, ddq):
        return more_mass(t, q, dq, ddq) * ((t < MOMENT) == before)[:, None]

    own = recordings(5, held)
    runs = {**recordings(5), **{name: own[name] for name in where}}
    if before:  # put down in the first, never there in the second: as if it were a part of all
        runs["fit_b"] = recordings(5, more_mass)["fit_b"]
    told = told_of(runs)
    assert tuple(one.joint for one in told) == (0, 1)
    for one in told:
        assert one.effects == ("a payload",)
        assert set(one.runs) == {*where}
        assert one.at == pytest.approx(MOMENT, abs=0.3)
        assert one.share > 0.95
        assert f"a payload came or went {one.at:.1f} s into {where[0]}" in one.words


@pytest.mark.by_default("True")
@pytest.mark.parametrize("frozen", [True, False])
def test_the_moment_is_told_where_it_lies_in_a_block_that_judges(frozen):
    """A frozen model was told of a payload that is everywhere, of two thirds of the mass; and of a
    run cut into blocks the moment was the end of the last one that was fitted."""
    day = recordings(5, lambda t, *moved: more_mass(t, *moved) * (t > HELD_OUT)[:, None])["fit_b"]
    model = textbook(recordings(5))
    train, held, _ = two_sides(model, [day], [])
    state = SearchState.start(model, train, held, frozen)
    told = contradiction(state, suspects(True, 2), np.zeros(2)).told
    assert tuple(one.joint for one in told) == (0, 1)
    for one in told:
        assert one.effects == ("a payload",)
        assert one.at == pytest.approx(HELD_OUT, abs=0.15)


def rising_by(times):
    """Dry friction of joint 2 in N·m, as it goes with the time."""
    return lambda t, q, dq, ddq: np.outer(times(t) * np.tanh(dq[:, 1] / 0.01), [0.0, 1.0])


def told_of_the_day(extra):
    """By a model that stays as it was."""
    model = textbook(recordings(5))
    train, held, _ = two_sides(model, [recordings(5, extra)["fit_b"]], [])
    state = SearchState.start(model, train, held, frozen=True)
    return contradiction(state, suspects(True, 2), np.zeros(2)).told


def test_friction_that_rises_at_a_moment_is_told_with_its_size():
    """It "follows its velocity", and had no name."""
    (one,) = told_of_the_day(rising_by(lambda t: 0.6 * (t > HELD_OUT)))
    assert (one.joint, one.effects) == (1, ("Coulomb friction",))
    assert one.at == pytest.approx(HELD_OUT, abs=0.15)
    said, error = one.came.removesuffix(" N·m").split(" ± ")
    size = float(said.removeprefix("Coulomb friction rose by "))
    assert abs(size - 0.6) < 2.0 * float(error) < 0.1
    assert f"as if {one.came} {one.at:.1f} s into fit_b" in one.words


def test_friction_that_rises_in_a_fitted_run_is_told_likewise():
    risen = recordings(5, rising_by(lambda t: 0.6 * (t > MOMENT)))["fit_b"]
    (one,) = told_of({**recordings(5), "fit_b": risen})
    assert (one.joint, one.runs) == (1, ("fit_b",))
    assert one.at == pytest.approx(MOMENT, abs=0.15)
    assert one.came.startswith(("Coulomb friction rose by 0.59", "Coulomb friction rose by 0.60"))


@pytest.mark.long
def test_friction_that_falls_at_a_moment_falls():
    (one,) = told_of_the_day(rising_by(lambda t: -0.6 * (t > HELD_OUT)))
    assert one.came.startswith("Coulomb friction fell by 0.")


def test_what_comes_on_slowly_did_not_come_at_a_moment():
    assert told_of_the_day(rising_by(lambda t: 0.8 * (1.0 - np.exp(-t / 9.0)))) == ()


def test_what_a_frozen_models_arm_had_all_day_did_not_come_on_its_way():
    model = textbook(recordings(5))
    train, held, _ = two_sides(model, [recordings(5, more_mass)["fit_b"]], [])
    state = SearchState.start(model, train, held, frozen=True)
    assert contradiction(state, suspects(True, 2), np.zeros(2)).told == ()


@pytest.mark.long
def test_what_acts_beyond_a_place_did_not_come_at_the_moment_the_arm_went_there():
    """A servo that went up once and stayed was "another one from one moment on"."""
    runs = {}
    for number, name in enumerate(("fit_a", "fit_b", "valid_a", "valid_b")):
        t, q, dq, ddq = motion(500 + number)
        over = np.tanh(4.0 * (t - MOMENT))
        way = np.array([1.5, 0.0])
        q = 0.3 * q + way * over[:, None]
        dq = 0.3 * dq + way * 4.0 * (1.0 - over**2)[:, None]
        ddq = 0.3 * ddq - way * 32.0 * (over * (1.0 - over**2))[:, None]
        lacks = more_mass(t, q, dq, ddq) * (q[:, :1] > 0.0)
        noise = 0.05 * np.random.default_rng(number).standard_normal(q.shape)
        runs[name] = Recording(name, t, q, textbook_torque(q, dq, ddq) + lacks + noise)
    assert told_of(runs) == ()


def test_runs_that_go_elsewhere_do_not_contradict_each_other():
    """Friction that another joint's angle sets "came or went" where one run held that elsewhere."""
    runs = {}
    for number, name in enumerate(("fit_a", "fit_b", "valid_a", "valid_b")):
        t, q, dq, ddq = motion(550 + number)
        q[:, 1] += 1.5 * (name == "fit_b")
        rubs = 0.8 * np.tanh(q[:, 1] / 0.3) * np.tanh(dq[:, 0] / 0.01)
        noise = 0.05 * np.random.default_rng(number).standard_normal(q.shape)
        tau = textbook_torque(q, dq, ddq) + np.outer(rubs, [1.0, 0.0]) + noise
        runs[name] = Recording(name, t, q, tau)
    assert told_of(runs) == ()


@pytest.mark.long
def test_the_moment_is_said_once_for_all_joints_and_what_to_do():
    runs = recordings(5, lambda t, *moved: more_mass(t, *moved) * (t > MOMENT)[:, None])
    found = asked(runs)
    assert found.verdict == "unknown"
    at = f"{found.contradicted[0].at:.1f} s into fit_a and fit_b"
    assert f": something came or went {at}" in unexplained(found)
    said = headline(found)
    assert said.count("as if a payload came or went") == 1
    assert f"joints 1 and 2 as if a payload came or went {at}." in said
    assert any("--leave-out" in line for line in found.warnings)


@pytest.mark.by_default("0.99")
@pytest.mark.parametrize("phi", [0.0, 0.99, 0.9995])
def test_runs_of_one_arm_do_not_contradict_each_other(phi):
    runs = recordings(41, colour=lambda rng, samples: ar1(rng, samples, phi))
    assert told_of(runs) == ()


def test_what_a_model_lacks_is_no_change():
    """A sheath that creeps asks one run for other viscous friction than the other, a little."""
    runs = recordings(61, stress_that_relaxes(np.random.default_rng(1)))
    assert told_of(runs) == ()


def asked(runs):
    return diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )


@pytest.mark.long
def test_it_is_said_on_the_joint_in_the_headline_and_what_to_do():
    """It was "more than the noise that can be seen, but it follows no quantity of the motion"."""
    found = asked(changed_between(CHANGES["a torque offset"][0]))
    assert (found.verdict, found.findings) == ("unknown", ())
    assert unexplained(found).startswith("The fitted runs contradict each other")
    (line,) = (one for one in found.remaining if one.significant)
    said = "contradict each other: as if a torque offset came or went between fit_a and fit_b"
    assert line.joint == 0
    assert said in line.sentence
    assert "joint 1 as if a torque offset came or went between fit_a and fit_b." in headline(found)
    (one,) = found.contradicted
    section = unexplained_section(found, one, None, Asked("m0", ["fit_a", "fit_b"], ["valid_a"]))
    assert section.title == "Joint 1: the fitted runs contradict each other"
    (what,) = found.warnings
    assert "parameters of joint 1," in what
    assert "fit to one side alone" in what


@pytest.mark.long
def test_a_spring_that_stood_in_for_a_payload_is_dropped():
    found = asked(changed_between(more_mass))
    assert found.findings == ()
    assert [one.joint for one in found.contradicted] == [0, 1]


def held_out_with(change, seed=7):
    """The held-out runs alone have it."""
    plain, other = recordings(seed), recordings(seed, change)
    return {name: (other if name.startswith("valid") else plain)[name] for name in plain}


def unlike(runs):
    state = state_of(runs)
    return unlike_fitted(state, len(state.terms), suspects(True, 2), np.zeros(2))


@pytest.mark.long
@pytest.mark.by_default("viscous friction")
@pytest.mark.parametrize("name", CHANGES)
def test_what_the_held_out_runs_alone_have_is_told(name):
    """A kilogram on a real arm left 4.8 N·m on its shoulder: "motion does not predict it"."""
    change, joints = CHANGES[name]
    told = unlike(held_out_with(change))
    assert tuple(one.joint for one in told) == joints
    for one in told:
        assert (one.effects, one.held_out) == ((name,), True)
        assert (one.others, one.runs) == (("fit_a", "fit_b"), ("valid_a", "valid_b"))
        assert one.who == "the runs held out contradict the fitted ones"


@pytest.mark.by_default("extra")
@pytest.mark.parametrize("law", [None, stress_that_relaxes(np.random.default_rng(1))])
def test_held_out_runs_of_the_same_arm_do_not_contradict_the_fitted_ones(law):
    assert unlike(recordings(41, law)) == ()


def at_one_frequency(name: str, seed: int) -> Recording:
    """Motion in which a spring and an inertia are one torque; the spring is on the second joint."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(30.0 * RATE)) / RATE
    w, amplitude = 2 * np.pi * 0.3, rng.uniform(0.5, 0.9, 2)
    angle = w * t[:, None] + rng.uniform(0, 2 * np.pi, 2)
    q, dq, ddq = (
        amplitude * x for x in (np.sin(angle), w * np.cos(angle), -(w**2) * np.sin(angle))
    )
    tau = textbook_torque(q, dq, ddq) + sprung(t, q, dq, ddq)
    return Recording(name, t, q, tau + 0.05 * rng.standard_normal(tau.shape))


def sprung(t, q, dq, ddq):
    return np.outer(q[:, 1] - 0.2, [0.0, 4.0])


@pytest.mark.long
def test_what_all_runs_have_came_and_went_in_none():
    """A real arm's spring, for which the fitted run's one frequency let a rotor stand in."""
    runs = recordings(7, sprung)
    runs |= {name: at_one_frequency(name, k) for k, name in enumerate(("fit_a", "fit_b"))}
    told = {one.joint: one for one in unlike(runs)}
    assert all(one.all_along for one in told.values())
    assert told[1].effects == ("a spring",)
    assert told[1].words == "as if a spring were there in all of them"


@pytest.mark.parametrize(
    ("kind", "size", "before", "said"),
    [
        ("payload", Value(1.4, 0.07, "kg"), False, "a payload of 1.4 ± 0.07 kg came"),
        ("payload", Value(1.4, 0.07, "kg"), True, "a payload of 1.4 ± 0.07 kg went"),
        ("payload", Value(-0.6, 0.03, "kg"), False, "a payload of 0.6 ± 0.03 kg went"),
        ("payload", Value(-0.6, 0.03, "kg"), True, "a payload of 0.6 ± 0.03 kg came"),
        ("coulomb", Value(-0.5, 0.1, "N·m"), False, "Coulomb friction fell by 0.5 ± 0.1 N·m"),
        ("torque_offset", Value(-0.2, 0.1, "N·m"), False, "a torque offset of -0.2 ± 0.1 N·m came"),
    ],
)
def test_a_load_that_the_model_had_goes_and_none_weighs_less_than_nothing(kind, size, before, said):
    """ "A payload of -0.6 kg came" was what an arm did that put its load down."""
    assert _brought(effect(kind), size, before) == said
