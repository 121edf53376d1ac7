"""Joints whose torque may act the wrong way round, by what control saw of them, for the control
process that comes next: an old measurement speaks for their sign, and their drives would ramp them
on. Who exchanges two phases starts everything anew.
"""

from __future__ import annotations

import contextlib
from pathlib import Path

from pa10d.daemon.robot.for_the_next import ForTheNext
from pa10d.profile import Profile


class DoubtedSigns:
    """``known``: joints, from 1."""

    def __init__(self, profile: Profile, data: Path) -> None:
        n = len(profile.drives or [])
        self._file = ForTheNext(
            profile, data, "doubted",
            "which joints may turn the wrong way round is not kept",
            "joints count as doubted that were seen to turn the right way round",
        )  # fmt: skip
        self.known: tuple[int, ...] = ()
        with contextlib.suppress(ValueError, TypeError):
            read = tuple(int(joint) for joint in self._file.read() or ())
            self.known = tuple(joint for joint in read if 1 <= joint <= n)

    def becomes(self, profile: Profile) -> None:
        """The profile is another one now: of other drives nothing is known."""
        if self._file.becomes(profile):
            self.known = ()

    def note(self, doubted: tuple[int, ...]) -> None:
        """What control says of its joints, from when on it knows what is known here."""
        if doubted == self.known:
            return
        self.known = doubted
        if doubted:
            self._file.keep(doubted)
        else:
            self._file.remove()

    def close(self) -> None:
        """What is being written is written to its end."""
        self._file.close()
