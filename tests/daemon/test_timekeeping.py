"""A machine that is too slow for real time gets simulated time, and one line that says so."""

from __future__ import annotations

import numpy as np

from pa10d.daemon.timekeeping import _bare_loop, kept_time, slower
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
    kept, said = kept_time(profile, slow_by(1.0))
    assert kept == profile
    assert "write control.rate: 250" in said


def test_a_virtual_arm_on_a_real_bus_keeps_its_clock():
    profile = in_real_time()
    can = profile.can.model_copy(update={"interface": "socketcan", "channel": "vcan0"})
    profile = profile.model_copy(update={"can": can})
    kept, said = kept_time(profile, slow_by(1.0))
    assert kept == profile
    assert "write control.rate: 250" in said


def slow_by(periods):
    return lambda period, _: np.full(200, periods * period)


def test_a_real_arm_keeps_its_rate_and_a_person_is_told_which_one_to_write():
    real = load_profile("pa10-7c")
    assert slower(real, slow_by(0.1)) is None
    said = slower(real, slow_by(1.0))
    assert "does not keep 500 Hz" in said
    assert "2.0 ms late" in said
    assert "write control.rate: 250, or end" in said
    assert "\n" not in said
    assert "nor 50 Hz" in slower(real, slow_by(20.0))


def test_what_depends_on_the_rate_is_named_with_it():
    real = load_profile("pa10-7c")
    gains = real.control.gains.model_copy(update={"kp": [100.0] * 7})
    control = real.control.model_copy(update={"gains": gains, "bandwidth_hz": 4.0})
    said = slower(real.model_copy(update={"control": control}), slow_by(2.0))
    assert "write control.rate: 125, control.gains anew (they were set at 500 Hz)" in said
    assert "control.bandwidth_hz: 1.25 at most" in said


def test_simulated_time_and_data_alone_need_no_rate():
    simulated = in_real_time().simulation.model_copy(update={"clock": "simulated"})
    assert slower(in_real_time().model_copy(update={"simulation": simulated}), slow_by(9)) is None
    assert slower(in_real_time().model_copy(update={"drives": None}), slow_by(9)) is None


def test_the_bare_loop_measures():
    late = _bare_loop(0.002, 0.05)
    assert len(late) >= 25
    assert (late >= 0).all()
