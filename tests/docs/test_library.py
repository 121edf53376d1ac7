"""The library's page and the notebook, run as they stand on a recording of a real machine."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest
from documents import ROOT, blocks

import pa10d


@pytest.fixture
def beside(tmp_path, monkeypatch, half_a_minute):
    """A folder with a robot and two recordings, as the texts have them."""
    for name in ("robot.urdf", "train.csv", "valid.csv"):
        (tmp_path / name).symlink_to(half_a_minute / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def shown(source: str, names: dict) -> object:
    """Run a cell; the value of its last line, as a notebook shows it."""
    *body, last = ast.parse(source).body
    exec(compile(ast.Module(body, []), "cell", "exec"), names)
    if not isinstance(last, ast.Expr):
        exec(compile(ast.Module([last], []), "cell", "exec"), names)
        return None
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names)


def test_the_page(beside, capsys):
    names: dict = {}
    for block in blocks("docs/library.md", "python"):
        exec(compile(block, "library.md", "exec"), names)
    assert names["better"].achieved[0] < names["compared"].rms[0]
    assert {p.name for p in Path().iterdir()} >= {"m1.yaml", "arm.py"}


def test_the_notebook(beside, capsys):
    notebook = json.loads((ROOT / "docs" / "tour.ipynb").read_text())
    sources = ["".join(c["source"]) for c in notebook["cells"] if c["cell_type"] == "code"]
    assert sum(len(source.splitlines()) for source in sources) <= 25, "short enough to be read"
    names: dict = {}
    values = [shown(source, names) for source in sources]
    assert isinstance(names["better"], pa10d.Improvement)
    for value in values[2:4]:
        page = value._repr_html_()
        assert page.startswith("<iframe")
        assert "plotly" in page
