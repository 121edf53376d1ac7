"""A loop that was starved says so, and one that was not blames nobody else."""

from __future__ import annotations

import numpy as np
from arms import PERIOD, cycles, holding_arm, swing, until

from backends.protocol import BackendFault
from pa10d.control.punctuality import Punctuality
from pa10d.control.states import ArmState


def second(delays):
    punctuality = Punctuality(PERIOD)
    for delay in delays:
        punctuality.note(delay)
    return punctuality


def test_a_quiet_machine_is_not_starved():
    rng = np.random.default_rng(0)
    assert second(rng.exponential(1e-4, 2000)).starved() is None
    assert second([*[1e-4] * 400, 4 * PERIOD, *[1e-4] * 90]).starved() is None  # now and then


def test_one_long_pause_explains_a_fault_for_a_second():
    punctuality = second([*[1e-4] * 400, 0.08])
    starved = punctuality.starved()
    assert starved.late == 1
    assert starved.latest == 0.08
    assert "came late, by up to 80 ms: this machine does not keep 500 Hz" in starved.cause
    for _ in range(510):
        punctuality.note(0.0)
    assert punctuality.starved() is None


def test_many_short_ones_do_and_the_rate_that_would_fit_is_offered():
    starved = second([0.0, 0.004] * 250).starved()
    assert starved.cycles == 501
    assert starved.kept == 100  # 4 ms are within half of 10 ms
    assert "lower control.rate to 100" in starved.remedy


def test_the_cycle_under_way_counts():
    assert second([0.0] * 500).starved(now=0.05).latest == 0.05


def pushed_arm(delays):
    arm, backend = holding_arm()
    punctuality = second(delays)
    arm.starved = punctuality.starved
    arm.run(swing(arm.path.reference.q))
    cycles(arm, 300)
    backend.plant.q[0] -= 0.2
    until(arm, ArmState.FAULT)
    return arm


def test_what_follows_from_late_cycles_is_no_collision():
    fault = pushed_arm([*[1e-4] * 488, *[0.08] * 12]).fault
    assert fault.kind == "starved"
    assert fault.axis is None
    assert "cycles came late, by up to 80 ms: this machine does not keep 500 Hz" in fault.sentence
    assert "joint 1" in fault.sentence  # what followed is told, too
    assert "collision" not in fault.sentence


def test_a_collision_on_a_quiet_machine_is_one():
    fault = pushed_arm([1e-4] * 500).fault
    assert (fault.kind, fault.axis) == ("following_error", 0)
    assert "collision" in fault.sentence


def test_a_drive_that_says_what_is_wrong_with_itself_is_believed():
    arm, backend = holding_arm()
    arm.starved = second([0.08] * 12).starved
    backend.fail["read"] = [BackendFault("joint 2: EMCY 0x2310 (overcurrent)", 1, kind="emcy")]
    arm.cycle()
    assert arm.fault.kind == "emcy"


def test_one_that_missed_us_is_no_riddle():
    arm, backend = holding_arm()
    arm.starved = second([0.3]).starved
    backend.fail["read"] = [BackendFault("joint 2: EMCY 0x8700 (SYNC missing)", 1, kind="emcy")]
    arm.cycle()
    until(arm, ArmState.FAULT)
    assert arm.fault.kind == "starved"
    assert "SYNC missing" in arm.fault.sentence
