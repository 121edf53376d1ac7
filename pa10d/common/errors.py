"""The exceptions that a caller is meant to see."""

from __future__ import annotations

from pa10d.common.jsonable import JsonObject


class UserError(Exception):
    """Something the user can mend: the message says what, where, and what was expected.

    The command line prints it as one line and exits with status 1; the API turns it into a
    problem document. Anything else that escapes is a bug of ours.
    """


class NotNow(UserError):
    """What is in the way passes, or somebody takes it away: what was asked is right in itself."""


class Busy(NotNow):
    """Somebody else holds for a while what is needed; the same may work later."""


class NoRoom(NotNow):
    """The disk does not take what is to be stored; nothing was."""


class Taken(UserError):
    """There is one of that name already."""


class Unsound(UserError):
    """A recording has errors against it; whoever knows better may force it.

    findings: what the checks said, as documents.
    """

    def __init__(self, message: str, findings: list[JsonObject]) -> None:
        super().__init__(message)
        self.findings = findings

    @property
    def warnings(self) -> list[JsonObject]:
        """Those that would be mended with the errors, and are not in the message."""
        return [finding for finding in self.findings if finding["severity"] == "warning"]


class Stopped(UserError):
    """Somebody wished what was under way to end: nothing went wrong."""


class Cancelled(Exception):
    """The caller asked a long computation to stop; nothing was stored."""
