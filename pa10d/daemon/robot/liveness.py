"""Does the control process go on? It hangs where its backend does; nobody holds the arm then."""

from __future__ import annotations

HANGS = 15.0  # s without a word and without a cycle; a machine may stand still for a while
COMMANDED = 75.0  # s of them while a command is carried out: configuring drives takes its time


class Liveness:
    """``tick`` again and again; time that the daemon itself stood still does not count."""

    def __init__(self, every: float) -> None:
        """every: s between ticks, at least."""
        self._every = every
        self._quiet, self._written, self._patience = 0, -1, HANGS

    @property
    def quiet(self) -> float:
        """s without a word and without a cycle."""
        return self._quiet * self._every

    def heard(self) -> None:
        """It said something."""
        self._quiet, self._patience = 0, HANGS

    def tick(self, written: int, commanded: bool) -> str | None:
        """Why it is to be ended, or None. written: cycles that it has noted down in all;
        commanded: whether it carries something out. Whoever asked for that may give up waiting
        before it is done."""
        if written != self._written:
            self.heard()
        else:
            self._quiet += 1
        self._written = written
        if commanded:
            self._patience = COMMANDED
        if self.quiet <= self._patience:
            return None
        return (
            f"nothing was heard of it for {self._patience:g} s; its backend hangs, or this machine "
            "gives it no time; the log says what it was at"
        )
