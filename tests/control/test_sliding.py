"""What sliding to and fro tells: friction, whatever else acts on the way, and a link that sways."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.control.gains import BUS_DELAY
from pa10d.experiments.joint_response import Response, fitted_response, friction_of, response_of
from pa10d.experiments.seen import slid
from pa10d.experiments.sliding import Sway, own_sways, slid_friction

RATE = 250.0
DRY, WET, INERTIA = 2.4, 3.0, 2.0  # N·m, N·m·s/rad, kg·m²
SOFTEST = 5.0  # N·m/rad
STROKES = ((0.2, 1.3), (-0.2, 1.3), (0.5, 0.55), (-0.5, 0.55))  # rad/s and s


def path(rate: float = RATE) -> np.ndarray:
    """rad: a joint stands, strokes to and fro slowly, then faster, and stands between."""
    speed = [np.zeros(round(0.3 * rate))]
    for fastest, seconds in STROKES:
        t = np.arange(round(seconds * rate)) / rate
        ramp = np.clip(np.minimum(t, seconds - t) / 0.1, 0.0, 1.0)
        speed += [fastest * ramp**2 * (3.0 - 2.0 * ramp), np.zeros(round(0.3 * rate))]
    return np.cumsum(np.concatenate(speed)) / rate


def sent(needed: np.ndarray, rate: float = RATE) -> np.ndarray:
    """N·m that act so much later."""
    t = np.arange(len(needed)) / rate
    return np.interp(t + BUS_DELAY / rate, t, needed)


@pytest.mark.parametrize("slope", [0.0, -70.0, 70.0])
def test_gravity_and_inertia_on_the_way_are_no_friction(slope: float) -> None:
    q = path()
    dq = np.gradient(q) * RATE
    wanted = DRY * np.sign(dq) + WET * dq + INERTIA * np.gradient(dq) * RATE + slope * q + 5.0
    wanted[dq == 0.0] += 0.9 * DRY  # what sticks holds whatever it likes
    found = slid_friction(q, sent(wanted), RATE, SOFTEST, DRY)
    assert found is not None
    friction, sway = found
    assert (friction.coulomb, friction.viscous) == pytest.approx((DRY, WET), rel=0.03)
    assert sway is None


def test_a_joint_that_slid_to_one_side_only_tells_nothing() -> None:
    q = path()
    q[round(1.7 * RATE) :] = q[round(1.7 * RATE)]
    assert slid_friction(q, np.ones_like(q), RATE, SOFTEST, DRY) is None


ROTOR, LINK, STIFFNESS = 0.25, 1.5, 130.0  # the link sways at 1.5 Hz, its motor held


def swayed(slope: float = 0.0, fine: int = 8) -> tuple[np.ndarray, np.ndarray]:
    """Angle and sent torque of a motor that keeps to the path, its link behind a spring in gravity
    (``slope`` N·m/rad pulls it away); integrated, in small steps."""
    q = path(fine * RATE)
    dq = np.gradient(q) * fine * RATE
    ddq, h = np.gradient(dq) * fine * RATE, 1.0 / (fine * RATE)
    loss, x, v, pull = 0.02 * np.sqrt(STIFFNESS * LINK), 0.0, 0.0, np.zeros_like(q)
    for k in range(len(q)):
        pull[k] = STIFFNESS * (q[k] - x) + loss * (dq[k] - v)
        v += h * (pull[k] + slope * x) / LINK
        x += h * v
    wanted = DRY * np.sign(dq) + WET * dq + ROTOR * ddq + pull
    return q[::fine], sent(wanted[::fine])


@pytest.mark.parametrize("slope", [0.0, 40.0, -40.0])
def test_a_link_that_sways_slower_than_any_line_is_seen(slope: float) -> None:
    found = slid_friction(*swayed(slope), RATE, SOFTEST, DRY)
    assert found is not None
    friction, sway = found
    assert sway is not None
    true = np.sqrt((STIFFNESS - slope) / LINK) / (2.0 * np.pi)
    assert sway.hertz == pytest.approx(true, rel=0.03)
    assert sway.stiffness == pytest.approx(STIFFNESS, rel=0.1)
    assert (sway.rotor, sway.link) == pytest.approx((ROTOR, LINK), rel=0.15)
    assert friction.coulomb == pytest.approx(DRY, rel=0.05)
    assert friction.viscous == pytest.approx(WET, rel=0.3)


def test_a_gear_that_no_gear_is_as_soft_as_is_none() -> None:
    found = slid_friction(*swayed(), RATE, 2.0 * STIFFNESS, DRY)
    assert found is not None
    assert found[1] is None


def test_a_neighbour_that_is_pushed_along_does_not_sway_by_itself() -> None:
    """As seen: joint 2 behind its spring, joint 4 by it; joint 6 sways for itself."""
    seen = {
        1: Sway(2.59, 0.46, 5.5, 1540.0),
        3: Sway(2.60, 0.33, 0.45, 139.0),
        5: Sway(4.0, 0.01, 0.02, 12.0),
    }
    assert sorted(own_sways(seen)) == [1, 5]


def test_lines_above_a_sway_show_a_spring_whether_it_was_seen_or_not() -> None:
    """From 8 Hz on there is little but the rotor, and a link as light as would explain that is far
    from what the URDF says."""
    lines = np.array([8.0, 11.0, 15.0, 20.0, 27.0])
    s = 2j * np.pi * lines
    through = LINK * s**2 * STIFFNESS / (LINK * s**2 + STIFFNESS)
    value = np.exp(-s * BUS_DELAY / RATE) / (ROTOR * s**2 + WET * s + through)
    one = Response(lines, value, np.full(len(lines), 0.2), 1.3, 0.0)
    assert fitted_response([one], ROTOR, WET, RATE).stiffness == pytest.approx(STIFFNESS, rel=0.1)
    hertz = np.sqrt(STIFFNESS / LINK) / (2.0 * np.pi)
    fit = fitted_response([one], ROTOR, WET, RATE, Sway(hertz, ROTOR, LINK, STIFFNESS))
    assert fit.stiffness == pytest.approx(STIFFNESS, rel=0.1)
    assert 1.3 * fit.link == pytest.approx(LINK, rel=0.1)


def test_a_stroke_in_which_the_joint_stuck_shows_no_response() -> None:
    """Of the arm that was looked at: joint 2 waited for 0.7 s of a window of 1 s, then slid."""
    t = np.arange(round(RATE)) / RATE
    shaken = 0.2 * t + 0.01 * np.sin(2 * np.pi * 3 * t)  # slower and faster, but it moves on
    assert slid(shaken, RATE, 0.2)
    assert slid(-shaken, RATE, -0.2)
    assert not slid(-shaken, RATE, 0.2)
    assert not slid(np.maximum(t - 0.7, 0.0), RATE, 0.2)
    assert not slid(0.2 * np.minimum(t, 0.85), RATE, 0.2)


def test_what_a_slow_ring_adds_to_the_lowest_line_counts_as_its_error() -> None:
    """A link that rings at 1.1 Hz within the window: one line is wrong, and says so."""
    t = np.arange(round(RATE)) / RATE
    lines = np.array([2.0, 6.0, 11.0])
    torque = sum(np.cos(2 * np.pi * f * t + f) for f in lines)
    true = 1e-3 * np.exp(-1j * lines)
    q = sum(
        abs(one) * np.cos(2 * np.pi * f * t + f + np.angle(one))
        for f, one in zip(lines, true, strict=True)
    )
    ringing = q + 5e-3 * np.sin(2 * np.pi * 1.1 * t) * np.exp(-t)
    seen = [
        response_of(angle[None, :, None], torque[None], RATE, lines, (0.0, 0.0), 0, np.ones((1, 1)))
        for angle in (q, ringing)
    ]
    assert np.abs(seen[0].value / true - 1.0).max() < 0.05
    assert seen[0].error.max() < 0.4
    off = np.abs(seen[1].value / true - 1.0)
    assert off[0] > 0.2
    assert seen[1].error[0] > 0.3 * off[0]
    assert seen[1].error[2] < 0.2


def one_way(viscous, slope=0.0, rate=250.0, noise=2e-3):
    """rad and N·m of a joint that is pressed ever harder, slides up three times and sticks when it
    is to come back; slope: N·m/rad that it bears the more."""
    t = np.arange(0.0, 6.0, 1.0 / rate)
    speed = sum(v * np.clip(1.0 - np.abs(t - at) / 0.2, 0.0, 1.0) for v, at in
                ((0.08, 1.0), (0.14, 2.5), (0.2, 4.0)))  # fmt: skip
    q = np.cumsum(speed) / rate
    stuck = 0.2 * np.sin(2.0 * np.pi * t / 1.5)
    rises = 0.003 * np.gradient(speed, 1.0 / rate)
    torque = np.where(speed > 0.0, 0.22 + viscous * speed + rises, stuck) + slope * q
    return np.round(q / 5e-6) * 5e-6, torque + noise * np.random.default_rng(3).normal(size=len(t))


@pytest.mark.parametrize("slope", [0.0, 0.4])
def test_a_joint_that_slides_one_way_tells_its_viscous_friction(slope):
    """It counted as none, and the servo was too soft for it ever after: an arm whose excitation
    ended with "weak gains" each time."""
    q, torque = one_way(0.29, slope)
    found = friction_of(q, torque, 250.0, 0.003)
    assert 0.5 * 0.29 < found.viscous < 1.1 * 0.29
    assert found.coulomb == pytest.approx(0.22, abs=0.05)


def test_a_joint_that_slides_one_way_is_given_no_more_viscous_friction_than_is_sure():
    found = friction_of(*one_way(0.0), 250.0, 0.003)
    assert found.viscous < 0.03
