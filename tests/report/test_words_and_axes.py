"""Numbers and axes as a person reads them."""

import pytest

from pa10d.common.words import times
from pa10d.figures.plotly import log_axis


@pytest.mark.parametrize(
    ("ratio", "said"),
    [(1.04, "1.0 times"), (9.94, "9.9 times"), (9.96, "10 times"), (24.4, "24 times"),
     (4960.0, "5000 times")],
)  # fmt: skip
def test_a_ratio_has_as_many_digits_as_say_something(ratio, said):
    assert times(ratio) == said


def test_a_wide_axis_is_labelled_at_powers_of_ten_alone():
    narrow, wide = log_axis("RMS", [0.1, 2.0]), log_axis("RMS", [5e-5, 4.0])
    assert {"0.2", "0.5", "1"} <= set(narrow["ticktext"])
    assert set(wide["ticktext"]) < set(log_axis("RMS", [])["ticktext"])
    assert not {"0.2", "0.5"} & set(wide["ticktext"])
    assert {"0.1", "1"} <= set(wide["ticktext"])
