"""Decisions name the tests that hold them: those tests exist, and every rule has one."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted((ROOT / "docs").rglob("*.md"))
NAMED = re.compile(r"\b(tests/[\w/]+\.py)(?:::(\w+))?")
POLICY = ROOT / "docs" / "decisions" / "0070-how-a-finding-is-judged.md"


def _functions(path: Path) -> set[str]:
    return {
        node.name for node in ast.parse(path.read_text()).body if isinstance(node, ast.FunctionDef)
    }


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_names_exists(page):
    missing = [
        f"{path}::{test}" if test else path
        for path, test in NAMED.findall(page.read_text())
        if not (ROOT / path).is_file() or (test and test not in _functions(ROOT / path))
    ]
    assert not missing


def test_every_rule_of_the_policy_names_the_tests_that_hold_it():
    rules = POLICY.read_text().split("\n### ")[1:]
    assert len(rules) == 30
    for number, rule in enumerate(rules, 1):
        assert rule.startswith(f"{number}. ")
        held = rule.split("\n## ")[0].partition("**Held by**")[2]
        assert NAMED.search(held), f"rule {number} names no test"
