"""A virtual arm that hides something: the night in which it may change, and the end of the secret.

What is hidden goes to the simulator's process alone; who asks the daemon learns it when he says
that he wants to know. Which arm it is, and which day, stays with the data that it was recorded
into: a daemon that begins again goes on with the same arm.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

from pa10d.common.disk import disk_words
from pa10d.common.errors import UserError
from pa10d.profile import Profile
from pa10d.store.entries import read_entry
from pa10d.store.folders import write_text

FILE, LARGEST = "hidden_arm.json", 4096  # bytes

log = logging.getLogger("pa10d")


@dataclass(frozen=True)
class Drawn:
    """The arm with a secret that a data folder knows. hide: as it was asked for; day: 2 once its
    night has passed."""

    profile: str
    hide: str
    seed: int
    day: int = 1
    revealed: bool = False

    def same_arm(self, other: Drawn) -> bool:
        """Whatever day it is."""
        return (self.profile, self.hide, self.seed) == (other.profile, other.hide, other.seed)


def drawn_before(data: Path) -> Drawn | None:
    """The arm of this folder; None where there is none, UserError where that is not known: its file
    is damaged."""
    place = data / FILE
    if not os.path.lexists(place):
        return None
    try:
        kept = Drawn(**json.loads(read_entry(place, LARGEST)))
    except (ValueError, TypeError, RecursionError) as error:
        raise _damaged(place) from error
    whole = isinstance(kept.seed, int) and kept.day in (1, 2) and isinstance(kept.revealed, bool)
    if not whole or not isinstance(kept.profile, str) or not isinstance(kept.hide, str):
        raise _damaged(place)
    return kept


def _damaged(place: Path) -> UserError:
    return UserError(
        f"{place}: found no virtual arm in it, expected the one that these data were recorded "
        "from: name it as it was (--hide EFFECT --seed N), or take another data folder (--data)"
    )


@dataclass(frozen=True)
class Secret:
    """later: the profile whose simulator is the arm on the next day; words: what is hidden;
    changes: whether it comes with the night, so that only a comparison with before shows it."""

    later: Profile
    words: str
    changes: bool
    drawn: Drawn | None = None


@dataclass
class Night:
    """The days of a virtual arm. secret: None where it hides nothing; data: where its day is kept,
    None: nowhere."""

    secret: Secret | None
    data: Path | None = None
    day: int = 1
    revealed: bool = False
    _passing: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        drawn = None if self.secret is None else self.secret.drawn
        if drawn is not None:
            self.day, self.revealed = drawn.day, drawn.revealed
        try:
            self._keep()
        except OSError as error:  # a full disk keeps no daemon from its arm
            log.warning("%s", disk_words(error, "the next daemon does not know this virtual arm"))

    def document(self) -> dict[str, object]:
        """For clients: what is hidden only once it was revealed."""
        secret = self.secret
        return {
            "hides": secret is not None,
            "day": self.day,
            "hidden": secret.words if secret is not None and self.revealed else None,
            "since_the_night": secret.changes if secret is not None and self.revealed else None,
        }

    def reveal(self) -> None:
        """Tell what is hidden, from now on."""
        self._known()
        self.revealed = True
        self._keep()

    async def passes(self, switched: Callable[[Profile], Awaitable[None]]) -> None:
        """The arm is switched off and on again by ``switched``, as it is on the next day."""
        secret = self._known()
        if self.day > 1 or self._passing:
            raise UserError("the night is over: it is day 2; what was to change has changed")
        self._passing = True
        try:
            await switched(secret.later)
            self.day = 2
            self._keep()
        finally:
            self._passing = False

    def _keep(self) -> None:
        drawn = None if self.secret is None else self.secret.drawn
        if drawn is None or self.data is None:
            return
        now = replace(drawn, day=self.day, revealed=self.revealed)
        with contextlib.suppress(UserError):  # a damaged file is written anew
            if now == drawn_before(self.data):
                return
        self.data.mkdir(parents=True, exist_ok=True)
        write_text(self.data / FILE, json.dumps(asdict(now), indent=2) + "\n")

    def _known(self) -> Secret:
        if self.secret is None:
            raise UserError(
                "this arm hides nothing; 'pa10d serve --hide any' starts a virtual one that does"
            )
        return self.secret
