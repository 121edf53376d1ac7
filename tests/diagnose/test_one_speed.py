"""A motor that turns on at one speed: its ripple shakes it, and the inertia takes the line."""

from __future__ import annotations

import numpy as np

from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.judging import Judging
from pa10d.diagnose.search.looking import look
from pa10d.diagnose.search.ripple import order_peaks
from pa10d.diagnose.search.suspects import suspects
from pa10d.dynamics import robot_from_urdf
from pa10d.identify import identify
from pa10d.measurement.recording import Recording

ORDER, SPEED, RATE = 12.0, 5.3, 200.0  # cycles a turn, rad/s, Hz
INERTIA, FRICTION = 1e-3, 0.3  # kg·m², N·m
RIPPLE, NOISE = 0.04, 0.02  # N·m


def motor():
    """About a vertical axis."""
    return robot_from_urdf(
        '<robot name="motor"><link name="a"/><link name="b"/><joint name="j" type="continuous">'
        '<parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
        '<limit effort="2" velocity="20"/></joint></robot>'
    )


def turning(seed: int, ripple: float = RIPPLE, shaken: float = 0.02) -> Recording:
    """15 s; its angle swings by ``shaken`` rad at the ripple's order, and wanders slowly."""
    rng = np.random.default_rng(seed)
    t = np.arange(15 * round(RATE)) / RATE
    hertz, phase = rng.uniform(0.1, 1.0, 4), rng.uniform(0.0, 2.0 * np.pi, 4)
    slow = (0.02 / hertz) * np.sin(2.0 * np.pi * hertz * t[:, None] + phase)
    q = SPEED * t + slow.sum(axis=1)
    q += shaken * np.sin(ORDER * q + 0.7)
    dq = np.gradient(q, t)
    tau = INERTIA * np.gradient(dq, t) + FRICTION + 0.01 * dq + ripple * np.sin(ORDER * q)
    tau += NOISE * rng.standard_normal(len(t))
    return Recording(f"r{seed}", t, q[:, None], tau[:, None])


def begun(*runs: Recording) -> SearchState:
    model = identify([runs[0]], motor(), name="m0", cutoff=12.0)
    fit, held, _ = two_sides(model, [runs[0]], [runs[1]])
    return SearchState.start(model, fit, held)


def test_a_line_that_the_inertia_takes_is_named():
    """12 periods a turn were passed over for 8 that there are not, and for a soft gear."""
    state = begun(turning(1), turning(2))
    assert not any(
        abs(order - ORDER) < 0.1 for order in order_peaks(state.train, state.train_residual(), 0, 1)
    )
    asked = [one for one in suspects(False, 1) if one[0].id == "torque_ripple"]
    good, _ = look(Judging(state, asked, len(state.terms)))
    (found,) = good
    assert abs(found.candidate.shape["N"] - ORDER) < 0.02
    assert abs(np.hypot(*found.candidate.partial.theta) - RIPPLE) < 0.3 * RIPPLE


def test_a_line_of_the_motion_alone_is_no_ripple():
    """Its speed is commanded to swing as often; nothing but the inertia answers."""
    state = begun(turning(3, ripple=0.0), turning(4, ripple=0.0))
    asked = [one for one in suspects(False, 1) if one[0].id == "torque_ripple"]
    good, _ = look(Judging(state, asked, len(state.terms)))
    assert good == []
