"""The exceptions that a caller is meant to see."""


class UserError(Exception):
    """Something the user can mend: the message says what, where, and what was expected.

    The command line prints it as one line and exits with status 1; the API turns it into a
    problem document. Anything else that escapes is a bug of ours.
    """


class Busy(UserError):
    """Somebody else holds for a while what is needed; the same may work later."""


class Cancelled(Exception):
    """The caller asked a long computation to stop; nothing was stored."""
