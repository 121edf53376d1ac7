"""However slowly an arm comes to rest after an experiment: it is not left powered."""

from __future__ import annotations

import pytest
from loops import run_apart

from pa10d.daemon.motions.experiment import Experiment
from pa10d.experiments.outcome import Outcome


class SlowRobot:
    """One whose stop is not over when its time is."""

    moving, state = True, "stopping"

    def __init__(self):
        self.told = []

    def stop(self):
        self.told.append("stop")

    async def until(self, *states, timeout):
        return self.state

    async def disable(self):
        self.told.append("disable")

    def unheld(self):
        return []


@pytest.mark.parametrize(("power_off", "told"), [(True, ["stop", "disable"]), (False, ["stop"])])
def test_a_stop_that_takes_long_still_ends_unpowered(power_off, told):
    experiment = Experiment.__new__(Experiment)
    experiment._robot, experiment.result = SlowRobot(), Outcome("tracking")
    run_apart(experiment._come_to_rest(power_off))
    assert experiment._robot.told == told
