"""What motion foretells is no noise, though the held-out side moves where no fit was made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bare_sides import ar1
from foreign_laws import on, turn
from two_links import NAMES, motion, recordings, robot, state_of, textbook, textbook_torque

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.unknown.foretold import foretold, rubs, sets_of
from pa10d.diagnose.unknown.taken_together import together
from pa10d.dynamics import inverse_dynamics
from pa10d.measurement.recording import Recording

AWAY = np.array([4.0, 4.0])  # rad, by which the held-out side moves around another pose


def squeezed(t, q, dq, ddq):
    """(N, 2) N·m: a bearing that the load of the other joint clamps."""
    load = inverse_dynamics(robot(), robot().parameters, q, dq, ddq)
    return 0.3 * on(1, turn(dq[:, 1]) * np.abs(load[:, 0]))


def elsewhere(seed: int, extra=None, colour=None) -> dict[str, Recording]:
    """Runs of which those to judge by move where the others never do."""
    out = recordings(seed, extra=extra, colour=colour)
    for number, name in enumerate(NAMES[2:], 2):
        _, q, dq, ddq = motion(100 * seed + number)
        noise = out[name].tau - textbook_torque(q, dq, ddq)
        tau = textbook_torque(q + AWAY, dq, ddq) + noise
        out[name] = replace(out[name], q=q + AWAY, tau=tau)
    return out


@pytest.mark.long
def test_what_the_held_out_side_cannot_say_is_said_by_stretches_of_the_fit_side():
    runs = elsewhere(5, extra=squeezed)
    found = diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    assert found.verdict != "none"
    line = found.remaining[1]
    assert 2 < line.ratio < 10  # by its size alone it might be slow noise
    assert line.significant
    assert "from one stretch to another" in line.sentence


COLOURS = {"white": None, "coloured": 0.99, "slow": 0.999, "slower": 0.9995}


@pytest.mark.long
@pytest.mark.parametrize(
    ("names", "seeds"),
    [(["slower"], range(1)), pytest.param(list(COLOURS), range(40), marks=pytest.mark.long)],
    ids=["one", "many"],
)
def test_noise_of_one_stretch_foretells_no_other(names, seeds):
    """However slow: what is beside a stretch in time is not asked about it."""
    said = {
        (name, seed): found
        for name, phi in ((name, COLOURS[name]) for name in names)
        for seed in seeds
        if (
            found := foretold(
                state_of(
                    elsewhere(
                        60 + seed,
                        colour=None if phi is None else lambda rng, n, phi=phi: ar1(rng, n, phi),
                    )
                ),
                [0, 1],
            )
        )
    }
    assert not said


def test_friction_that_follows_how_fast_another_joint_turns_is_foretold_and_told():
    """Three quantities of two joints: 3 times the floor, and the verdict was none."""
    runs = recordings(7, extra=lambda t, q, dq, ddq: on(1, clamped(q, dq)))
    (found,) = foretold(state_of(runs), [1])
    assert not found.elsewhere
    assert found.there > 0.5
    assert rubs(1, 0) in found.names
    assert "joint 2's" in found.unnamed().best_from
    assert "joint 1's speed" in found.unnamed().best_from


@pytest.mark.long
def test_a_product_of_two_quantities_is_foretold_from_one_stretch_to_another():
    """Of fitted runs that leave open what the held-out side asks for: "for want of motion"."""
    runs = recordings(8, extra=lambda t, q, dq, ddq: on(1, 0.15 * q[:, 0] * dq[:, 0]))
    (found,) = foretold(state_of(runs), [], [1])
    assert found.elsewhere
    assert found.share > 0.5
    assert set(found.names) == {"q1", "dq1"}


def clamped(q, dq):
    """(N,) N·m."""
    return 0.4 * turn(dq[:, 1]) * np.sin(q[:, 1]) * np.abs(dq[:, 0])


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (("q2", "dq2"), "joint 2's position and speed"),
        (("q3", "turn3", "turn3·|dq4|", "q4"),
         "joint 3's position and direction and joint 4's speed and position"),
        (("q1", "q1 0.4 s ago", "q1 2 s ago"),
         "joint 1's position, position 0.4 s before and position 2 s before"),
        (("dq1", "dq1 0.2 s before", "work2 1.5 s", "turned1 20 s", "time"),
         "joint 1's speed, speed 0.2 s before and direction over the last 20 s, "
         "joint 2's motion in the last 1.5 s and time"),
    ],
)  # fmt: skip
def test_quantities_in_words(names, words):
    assert together(names) == words


def test_every_quantity_has_its_words():
    for name in {n for joint in range(3) for names in sets_of(joint, 3) for n in names} - {"time"}:
        assert "joint " in together([name])
