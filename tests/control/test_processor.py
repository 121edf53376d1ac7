"""A thread that keeps real time stays where it is; the others of its process are not concerned."""

import os
import threading

import pytest

from pa10d.common.processor import stay_on_one


def test_one_thread_stays_on_the_last_allowed_processor():
    allowed, seen = os.sched_getaffinity(0), []
    if len(allowed) < 2:
        pytest.skip("this machine gives us one processor only")

    def stay():
        stay_on_one()
        seen.append(os.sched_getaffinity(0))

    thread = threading.Thread(target=stay)
    thread.start()
    thread.join()
    assert seen == [{max(allowed)}]
    assert os.sched_getaffinity(0) == allowed
