"""Of a table of cases those run by default that it names, and each name is one of its cases."""

from __future__ import annotations

import pytest
from by_default import chosen

CASES = ("one", "another", "a third")


@pytest.mark.by_default("another")
@pytest.mark.parametrize("case", CASES)
def test_the_others_are_long(case, request):
    assert ("long" in request.keywords) == (case != "another")


def test_a_case_is_named_whole_or_by_its_beginning():
    ids = ["1-0.5", "1-0.7", "10-0.5", "2"]
    assert chosen(ids, ["1"]) == {"1-0.5", "1-0.7"}
    assert chosen(ids, ["10-0.5", "2"]) == {"10-0.5", "2"}


@pytest.mark.parametrize("named", [[], ["3"], ["2", "1-"]])
def test_a_name_of_no_case_is_refused(named):
    with pytest.raises(ValueError, match="names no case"):
        chosen(["1-0.5", "2"], named)
