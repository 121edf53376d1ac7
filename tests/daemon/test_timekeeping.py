"""A machine that is too slow for real time gets simulated time, and one line that says so."""

from __future__ import annotations

import numpy as np

from pa10d.daemon.timekeeping import _bare_loop, kept_time
from pa10d.profile import load_profile


def in_real_time():
    profile = load_profile("pa10-sim")
    simulation = profile.simulation.model_copy(update={"clock": "real"})
    return profile.model_copy(update={"simulation": simulation})


def test_a_slow_machine_gets_simulated_time():
    profile, said = kept_time(in_real_time(), lambda period, _: np.full(200, 2.0 * period))
    assert profile.simulation.clock == "simulated"
    assert "does not keep 500 Hz" in said
    assert "4.0 ms late" in said
    assert "\n" not in said


def test_a_quick_one_stays_in_real_time():
    profile, said = kept_time(in_real_time(), lambda period, _: np.full(200, 0.1 * period))
    assert (profile.simulation.clock, said) == ("real", None)


def test_real_drives_are_left_alone():
    profile = load_profile("pa10-7c")
    assert kept_time(profile, lambda *_: np.full(10, 1.0)) == (profile, None)


def test_a_virtual_arm_on_a_real_bus_keeps_its_clock():
    profile = in_real_time()
    can = profile.can.model_copy(update={"interface": "socketcan", "channel": "vcan0"})
    profile = profile.model_copy(update={"can": can})
    assert kept_time(profile, lambda *_: np.full(10, 1.0)) == (profile, None)


def test_the_bare_loop_measures():
    late = _bare_loop(0.002, 0.05)
    assert len(late) >= 25
    assert (late >= 0).all()
