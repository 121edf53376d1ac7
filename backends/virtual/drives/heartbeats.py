"""How a virtual drive and its master watch each other: heartbeats or node guarding (CiA 301)."""

from __future__ import annotations

from backends.virtual.drives.object_dictionary import LiveDictionary, key_of


def watched_node(entry: int) -> int:
    """The node that an entry of 0x1016 names, 0 where it names none (CiA 301: 1 to 127)."""
    node = entry >> 16 & 0xFF
    return node if node <= 127 else 0


class Producer:
    """Says every 0x1017 milliseconds that the node lives."""

    def __init__(self) -> None:
        self._left = 0.0

    def due(self, dt: float, period_ms: int) -> bool:
        """Whether a heartbeat is due after ``dt`` more seconds."""
        if not period_ms:
            return False
        self._left -= dt
        if self._left > 1e-9:
            return False
        self._left = max(self._left + period_ms / 1000.0, 0.0)
        return True

    def restart(self, period_ms: int) -> None:
        """The period was written: count it from now."""
        self._left = period_ms / 1000.0


class Consumer:
    """Watches the nodes that 0x1016 names; each from its first heartbeat on (CiA 301)."""

    def __init__(self) -> None:
        self._left: dict[int, float | None] = {}  # node -> s until it counts as lost
        self._limit: dict[int, float] = {}

    def configure(self, dictionary: LiveDictionary) -> None:
        """Take over 0x1016."""
        count = dictionary.number(0x1016)
        known = [k for k in range(1, count + 1) if key_of(0x1016, k) in dictionary.entries]
        entries = [dictionary.number(0x1016, k) for k in known]
        watched = {watched_node(e): (e & 0xFFFF) / 1000.0 for e in entries if watched_node(e)}
        self._limit = {node: limit for node, limit in watched.items() if limit > 0}
        self._left = {node: self._left.get(node) for node in self._limit}

    @property
    def nodes(self) -> list[int]:
        return list(self._limit)

    def heard(self, node: int) -> None:
        """A heartbeat of ``node`` came."""
        if node in self._limit:
            self._left[node] = self._limit[node]

    def lost(self, dt: float) -> int | None:
        """The node that fell silent during ``dt`` more seconds; told once, until heard again."""
        silent = None
        for node, left in self._left.items():
            if left is None:
                continue
            self._left[node] = left - dt
            if left - dt <= 0:
                self._left[node], silent = None, node
        return silent


class Guard:
    """Node guarding: the master asks, and is missed when it no longer does."""

    def __init__(self) -> None:
        self._toggle = 0
        self._life = 0.0  # s, guard time times life time factor; 0: nobody is missed
        self._left: float | None = None  # s, once asked

    def configure(self, dictionary: LiveDictionary) -> None:
        """Take over 0x100C and 0x100D."""
        self._life = dictionary.number(0x100C) * dictionary.number(0x100D) / 1000.0
        if not self._life:
            self._left = None

    def asked(self, state: int) -> bytes:
        """The answer to a remote frame: the state, and a bit that turns over each time."""
        answer = bytes([state | self._toggle])
        self._toggle ^= 0x80
        self._left = self._life or None
        return answer

    def lost(self, dt: float) -> bool:
        """Whether the master fell silent during ``dt`` more seconds; told once."""
        if self._left is None:
            return False
        self._left -= dt
        if self._left > 0:
            return False
        self._left = None
        return True
