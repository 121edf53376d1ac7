"""A virtual arm that hides something: the night in which it may change, and the end of the secret.

What is hidden goes to the simulator's process alone; who asks the daemon learns it when he says
that he wants to know.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field

from pa10d.common.errors import UserError
from pa10d.profile import Profile


@dataclass(frozen=True)
class Secret:
    """later: the profile whose simulator is the arm on the next day; words: what is hidden;
    changes: whether it comes with the night, so that only a comparison with before shows it."""

    later: Profile
    words: str
    changes: bool


@dataclass
class Night:
    """The days of a virtual arm. secret: None where it hides nothing."""

    secret: Secret | None
    day: int = 1
    revealed: bool = False
    _passing: bool = field(default=False, repr=False)

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

    async def passes(self, switched: Callable[[Profile], Awaitable[None]]) -> None:
        """The arm is switched off and on again by ``switched``, as it is on the next day."""
        secret = self._known()
        if self.day > 1 or self._passing:
            raise UserError("the night is over: it is day 2; what was to change has changed")
        self._passing = True
        try:
            await switched(secret.later)
            self.day = 2
        finally:
            self._passing = False

    def _known(self) -> Secret:
        if self.secret is None:
            raise UserError(
                "this arm hides nothing; 'pa10d serve --hide any' starts a virtual one that does"
            )
        return self.secret
