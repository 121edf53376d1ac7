"""A terminal speaks to every process that was started in it: Ctrl-C, Ctrl-Z, Ctrl-\\, and its end.

That is for the one that a person started, who tells its own processes. An arm whose control process
is suspended, or gone together with the daemon, is left to its drives; a run ends where it is.
"""

from __future__ import annotations

import signal

SAYS = (
    signal.SIGINT, signal.SIGQUIT, signal.SIGHUP,
    signal.SIGTSTP, signal.SIGTTIN, signal.SIGTTOU,
)  # fmt: skip


def leave_terminal_to_daemon() -> None:
    """This process is told by its pipe what to do, and when to end."""
    for number in SAYS:
        signal.signal(number, signal.SIG_IGN)


def hang_up_ends() -> bool:
    """Whether the end of its terminal is to end this process: not where 'nohup' started it."""
    return signal.getsignal(signal.SIGHUP) != signal.SIG_IGN
