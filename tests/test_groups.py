"""A group of tests is collected whole, and without the files that have none of it."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from groups import (
    asked_for,
    left_out,
    may_be_in,
    pytest_collection_modifyitems,
    pytest_ignore_collect,
)

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize(
    ("expression", "groups"),
    [
        ("alone and browser", ["alone", "browser"]),
        ("alone and not browser and not realtime", ["alone"]),
        ("not alone and not realtime", []),
        ("realtime", ["realtime"]),
        ("alone or realtime", []),
        ("not (alone and browser)", []),
        ("", []),
    ],
)
def test_what_every_test_of_an_expression_is_in(expression, groups):
    assert asked_for(expression) == groups


def test_what_no_test_of_an_expression_is_in():
    assert left_out("alone and not browser and not realtime") == ["browser", "realtime"]
    assert left_out("not alone and not realtime") == ["alone", "realtime"]
    assert left_out("not (alone and browser)") == left_out("not alone or realtime") == []


def test_a_file_is_not_read_where_all_of_it_is_in_a_group_that_is_left_out(tmp_path):
    asked = SimpleNamespace(option=SimpleNamespace(markexpr="not alone and not realtime"))
    whole, part = tmp_path / "test_whole.py", tmp_path / "test_part.py"
    whole.write_text("pytestmark = [pytest.mark.alone, pytest.mark.timeout(9)]\n")
    part.write_text("@pytest.mark.alone\ndef test_it():\n    pass\n")
    assert pytest_ignore_collect(whole, asked) is True
    assert pytest_ignore_collect(part, asked) is None
    (tmp_path / "conftest.py").write_text("item.add_marker(pytest.mark.alone)\n")
    assert pytest_ignore_collect(part, asked) is True


def test_the_script_s_groups_are_found_by_their_files():
    told = re.findall(r'-m (?!pytest)"?([a-z ]+)"? "\$@"', (ROOT / "scripts" / "test").read_text())
    assert [asked_for(one.strip()) for one in told] == [
        [], ["alone", "browser"], ["alone"], ["realtime"]
    ]  # fmt: skip


def test_a_file_is_read_where_it_or_the_conftest_beside_it_has_the_marker(tmp_path):
    asked = SimpleNamespace(option=SimpleNamespace(markexpr="alone and not browser"))
    plain, marked = tmp_path / "test_plain.py", tmp_path / "test_marked.py"
    plain.write_text("def test_it():\n    pass\n")
    marked.write_text("pytestmark = pytest.mark.alone\n")
    assert pytest_ignore_collect(plain, asked) is True
    assert pytest_ignore_collect(marked, asked) is None
    assert pytest_ignore_collect(tmp_path, asked) is None
    (tmp_path / "conftest.py").write_text("item.add_marker(pytest.mark.alone)\n")
    assert pytest_ignore_collect(plain, asked) is None
    assert not may_be_in(plain, "browser")


def test_a_marker_that_no_text_tells_is_refused(tmp_path):
    file = tmp_path / "test_far.py"
    file.write_text("pytestmark = MARKS_FROM_ELSEWHERE\n")
    item = SimpleNamespace(keywords={"alone"}, path=file, nodeid="test_far.py::test_it")
    with pytest.raises(pytest.UsageError, match=r"marked alone by neither its file nor"):
        pytest_collection_modifyitems([item])
