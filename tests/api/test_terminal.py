"""What a terminal tells all that was started in it, its end too, is for the daemon alone."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from pa10d.common.terminal import SAYS
from pa10d.daemon.presence import present

OUTLIVES = """
import os, signal
from pa10d.common.terminal import SAYS, hang_up_ends, leave_terminal_to_daemon
assert hang_up_ends()
leave_terminal_to_daemon()
for number in SAYS:
    os.kill(os.getpid(), number)
assert not hang_up_ends(), "as 'nohup' has it"
"""


def test_nothing_of_it_ends_or_suspends_a_process_of_ours():
    subprocess.run([sys.executable, "-c", OUTLIVES], check=True, timeout=20)


@pytest.mark.usefixtures("arm")
def test_so_has_each_process_of_a_daemon(data_of_arm):
    children = psutil.Process(present(data_of_arm).pid).children()
    assert len(children) >= 3, "control, recorder, virtual arm; workers as they are needed"
    for child in children:
        status = Path(f"/proc/{child.pid}/status").read_text()
        ignored = int(status.partition("SigIgn:")[2].split()[0], 16)
        heard = [number.name for number in SAYS if not ignored >> (number - 1) & 1]
        assert not heard, f"{child.cmdline()}: {heard}"
