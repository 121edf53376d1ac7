"""How a run ended is said once."""

import pytest

from pa10d.daemon.motions.experiment import how_it_ended


@pytest.mark.parametrize(
    ("status", "reason", "said"),
    [
        ("stopped", "stopped before its end", "run a: stopped before its end"),
        ("aborted", "a fault", "run a: aborted; a fault"),
    ],
)
def test_a_reason_that_says_the_status_is_enough(status, reason, said):
    assert how_it_ended("a", status, reason) == said
