"""An arm that is simulated anew stands elsewhere than the old one did, and is the demo's own."""

from __future__ import annotations

import pytest
from lost_zero import turn

from pa10d.demo.bench import Bench
from pa10d.demo.hidden import Hidden
from pa10d.profile import load_profile


@pytest.mark.long
def test_it_can_be_powered_when_time_has_passed(tmp_path):
    bench = Bench(load_profile("pa10-sim"), Hidden(()), seed=5)
    with bench.running(tmp_path):
        client = bench.client
        client.wait_for_robot("inactive")
        client.disconnect()
        turn(3, 0.5, bench.channel)  # as if it had been moved
        client.connect()
        client.wait_for_robot("inactive")
        client.confirm()
        bench.time_passes()
        assert client.enable()["state"] == "holding"
