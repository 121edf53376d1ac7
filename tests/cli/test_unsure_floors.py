"""A floor that is hardly known is told with its doubt, where errors are held against it."""

import pytest

from pa10d.cli.models import _against


@pytest.mark.parametrize(
    ("error", "told"),
    [(0.0042, "0.0088 ± 48 %"), (0.0004, "0.0088"), (None, "0.0088"), (float("nan"), "0.0088")],
)
def test_a_floor_is_told_with_what_it_may_be_off_by(error, told):
    """An error of exactly its floor, known to a half of itself, was "1.00" times that and no more
    was said."""
    assert _against(0.0088, 0.0088, error) == (told, "1.00")


def test_a_floor_that_is_not_known_is_none():
    assert _against(0.0088, None, None) == ("not known", "–")
