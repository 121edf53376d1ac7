"""Two processes that share memory: in order, complete, and nobody is left behind.

In processes of their own, because the test runner's threads keep ``shared_map`` from forking.
"""

import signal
import subprocess
import sys

import pytest

from pa10d.common.parallel import process_map

HEAD = """
import os, signal, threading
from pa10d.common.parallel import shared_map
os.sched_getaffinity = lambda _: {0, 1}
me = os.getpid()
"""


def run(code):
    return subprocess.run(
        [sys.executable, "-c", HEAD + code], capture_output=True, text=True, timeout=60, check=True
    ).stdout.split()


def test_results_come_in_order_from_two_processes():
    code = "got = shared_map(lambda x: (x * x, os.getpid() == me), range(7))\nprint(*got, sep='')"
    assert run(code) == "".join(str((x * x, x % 2 == 0)) for x in range(7)).split()


def test_what_a_child_that_was_killed_left_undone_is_done_here():
    code = """
def work(x):
    if os.getpid() != me:
        os.kill(os.getpid(), signal.SIGKILL)
    return x + 1
print(*shared_map(work, range(5)))
"""
    assert run(code) == list("12345")


@pytest.mark.parametrize("item", [0, 1])
def test_an_error_arrives_from_either_process(item):
    code = f"""
def work(x):
    if x == {item}:
        raise ValueError("no", "way")
    return x
try:
    shared_map(work, range(4))
except ValueError as error:
    print(*error.args)
try:
    os.waitpid(-1, os.WNOHANG)
except ChildProcessError:
    print("alone")
"""
    assert run(code) == ["no", "way", "alone"]


def test_cancelling_ends_the_child():
    code = """
def tick(share):
    raise KeyboardInterrupt
def work(x):
    if os.getpid() != me:
        signal.pause()
try:
    shared_map(work, range(4), tick)
except KeyboardInterrupt:
    print("cancelled")
try:
    os.waitpid(-1, os.WNOHANG)
except ChildProcessError:
    print("alone")
"""
    assert run(code) == ["cancelled", "alone"]


def test_a_process_with_threads_does_it_all_itself():
    code = """
done = threading.Event()
threading.Thread(target=done.wait).start()
print(*{os.getpid() == me for _ in [0]} | set(shared_map(lambda x: os.getpid() == me, range(4))))
done.set()
"""
    assert run(code) == ["True"]


def test_workers_do_not_hear_what_a_terminal_sends_to_all():
    """Their tracebacks stood above the command's own word, and the terminal's prompt."""
    with process_map(2) as each:
        for mask in each(signal.pthread_sigmask, [signal.SIG_BLOCK] * 3, [()] * 3):
            assert signal.SIGINT in mask
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
