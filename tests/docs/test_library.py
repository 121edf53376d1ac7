"""The library's page and the notebook, run as they stand: on an arm that lacks one effect.

With --long also on a recording of a real machine, which lacks several.
"""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest
from documents import ROOT, blocks
from sprung_arm import URDF, recording

import pa10d


@pytest.fixture(params=["simulated", pytest.param("real", marks=pytest.mark.long)])
def beside(request, tmp_path, monkeypatch):
    """A folder with a robot and two recordings, as the texts have them; 0-based, which joint lacks
    something."""
    monkeypatch.chdir(tmp_path)
    if request.param == "real":
        source = request.getfixturevalue("half_a_minute")
        for name in ("robot.urdf", "train.csv", "valid.csv"):
            (tmp_path / name).symlink_to(source / name)
        return 0
    (tmp_path / "robot.urdf").write_text(URDF)
    recording(tmp_path / "train.csv", 1)
    recording(tmp_path / "valid.csv", 2)
    return 1


def shown(source: str, names: dict) -> object:
    """Run a cell; the value of its last line, as a notebook shows it."""
    *body, last = ast.parse(source).body
    exec(compile(ast.Module(body, []), "cell", "exec"), names)
    if not isinstance(last, ast.Expr):
        exec(compile(ast.Module([last], []), "cell", "exec"), names)
        return None
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names)


@pytest.mark.long
def test_the_page(beside, capsys):
    names: dict = {}
    for block in blocks("docs/library.md", "python"):
        exec(compile(block, "library.md", "exec"), names)
    assert names["better"].achieved[beside] < names["compared"].rms[beside]
    assert {p.name for p in Path().iterdir()} >= {"m1.yaml", "arm.py"}


@pytest.mark.long
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
