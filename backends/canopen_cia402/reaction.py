"""How a drive comes to rest at a fault that it finds by itself (0x605E), also as we die (0x6007).

Its ramp is a speed loop with its own motor and encoder: a joint whose torque acts the wrong way
round is driven on by it, and no command ends that. Until the sign of a joint is known its drive
takes the power away at once, and its brake closes, or it coasts where it has none.
"""

from __future__ import annotations

from collections.abc import Callable, Collection

from backends.cia402 import FaultReaction

REACTION = 0x605E
AGAIN = 0.2  # s after which a drive that did not confirm its reaction is told once more …
TIMES = 10  # … so many times: it keeps the one it has, then, which is told


def reaction(trusted: bool) -> FaultReaction:
    """Of an axis whose sign is known, or not yet."""
    return FaultReaction.QUICK_STOP if trusted else FaultReaction.DISABLE


class Reactions:
    """``tell(axis, reaction)`` sends it; ``on_silence(axis)`` hears of a drive that confirms none,
    however often it was told."""

    def __init__(
        self, tell: Callable[[int, FaultReaction], None], on_silence: Callable[[int], None]
    ) -> None:
        self.trusted: frozenset[int] = frozenset()
        self._tell, self._on_silence = tell, on_silence
        self._open: dict[int, tuple[float, int]] = {}  # axis -> s when it was told last, how often

    def trust(self, axes: Collection[int]) -> None:
        """All whose sign is known; whoever shall have another reaction is told with ``insist``."""
        changed = self.trusted.symmetric_difference(axes)
        self.trusted = frozenset(axes)
        self._open |= dict.fromkeys(changed, (float("-inf"), 0))

    def set_up(self, axis: int) -> None:
        """The drive was configured with what it shall have."""
        self._open.pop(axis, None)

    taken = refused = set_up  # answered: there is nothing left to tell

    def insist(self, now: float) -> None:
        """Once a cycle, ``now`` in s: who has not answered is told again."""
        if not self._open:
            return
        for axis, (told_at, times) in list(self._open.items()):
            if now - told_at < AGAIN:
                continue
            if times >= TIMES:
                del self._open[axis]
                self._on_silence(axis)
                continue
            self._open[axis] = now, times + 1
            self._tell(axis, reaction(axis in self.trusted))
