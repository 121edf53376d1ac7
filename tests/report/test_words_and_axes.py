"""Numbers and axes as a person reads them, and blocks as the page draws them."""

import re
from importlib.resources import files

import numpy as np
import pytest

from pa10d.common.words import counted, joint_words, rounded, sentence, times
from pa10d.figures.plotly import log_axis
from pa10d.report.sheet import BLOCKS


@pytest.mark.parametrize(
    ("ratio", "said"),
    [(1.04, "1.0 times"), (9.94, "9.9 times"), (9.96, "10 times"), (24.4, "24 times"),
     (4960.0, "5000 times")],
)  # fmt: skip
def test_a_ratio_has_as_many_digits_as_say_something(ratio, said):
    assert times(ratio) == said


@pytest.mark.parametrize(
    ("value", "digits", "said"),
    [(350.3, 2, "350"), (12781.0, 4, "12780"), (0.01234, 3, "0.0123"), (-2589.0, 2, "-2600"),
     (9.96, 2, "10"), (1.5e9, 3, "1.5e+09"), (float("nan"), 3, "nan")],
)  # fmt: skip
def test_what_a_large_arm_measures_is_a_plain_number(value, digits, said):
    """ "About 3.5e+02 N·m" was said of an arm of 10 kN·m."""
    assert rounded(value, digits) == said


def test_a_wide_axis_is_labelled_at_powers_of_ten_alone():
    narrow, wide = log_axis("RMS", [0.1, 2.0]), log_axis("RMS", [5e-5, 4.0])
    assert {"0.2", "0.5", "1"} <= set(narrow["ticktext"])
    assert set(wide["ticktext"]) < set(log_axis("RMS", [])["ticktext"])
    assert not {"0.2", "0.5"} & set(wide["ticktext"])
    assert {"0.1", "1"} <= set(wide["ticktext"])


def test_errors_that_are_all_but_the_same_look_so():
    low, high = 10 ** np.array(log_axis("RMS", [1.0, 1.016])["range"])
    assert low < 0.8
    assert high > 1.25
    assert "range" not in log_axis("RMS", [1.0, 10.0])
    assert "range" not in log_axis("RMS", [])


def test_joints_are_named_as_one_says_them():
    assert joint_words([2]) == "joint 3"
    assert joint_words([0, 3]) == "joints 1 and 4"
    assert joint_words([0, 1]) == "joints 1 and 2"
    assert joint_words(range(7)) == "joints 1 to 7"
    assert (counted(1, "run"), counted(2, "run")) == ("1 run", "2 runs")


def test_the_page_draws_every_block_that_a_sheet_may_have():
    text = files("pa10d.web").joinpath("parts/blocks.js").read_text(encoding="utf-8")
    makers = text.partition("const makers = {")[2].partition("\n};")[0]
    inside_a_plot = {"reading"}
    assert set(re.findall(r"^  (\w+): ", makers, re.M)) == set(BLOCKS) - inside_a_plot


@pytest.mark.parametrize(
    ("note", "read"),
    [("joint 4 fell behind", "Joint 4 fell behind."), ("Slower.", "Slower.")],
)
def test_notes_that_follow_each_other_are_sentences(note, read):
    assert sentence(note) == read
