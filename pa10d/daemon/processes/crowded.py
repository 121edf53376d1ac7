"""More is asked for than is taken on at a time."""


class Crowded(Exception):
    """Asked for later it will work; nothing was begun."""

    RETRY_AFTER = 5  # s
