"""What docs/exports.md shows works as it stands there."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from documents import blocks

from pa10d.export.endings import FORMATS
from pa10d.export.formats import export
from pa10d.services.models import write_export

sys.path.append(str(Path(__file__).parents[1] / "models"))
import model_examples as examples

PAGE = "docs/exports.md"


def test_every_format_is_described():
    text = (Path(__file__).parents[2] / PAGE).read_text(encoding="utf-8")
    assert all(f"| `{name}` |" in text for name in FORMATS)


def test_the_python_lines(tmp_path, monkeypatch):
    model = examples.with_effects(examples.textbook("arm"), "presliding_hysteresis")
    (tmp_path / "arm.py").write_text(export(model, "python").text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    space: dict = {}
    exec(compile(blocks(PAGE, "python")[0], PAGE, "exec"), space)
    sys.modules.pop("arm")
    q, dq, ddq, t = (space[name] for name in ("q", "dq", "ddq", "t"))
    expected = model.torque(q, dq, ddq, t, parameters="feasible")
    assert space["motion"] == pytest.approx(expected, abs=1e-9)
    assert np.max(np.abs(space["motion"] - space["many"])) > 1e-3


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc on this machine")
def test_the_c_lines(tmp_path):
    (tmp_path / "arm.h").write_text(export(examples.textbook("arm"), "c").text, encoding="utf-8")
    (tmp_path / "use.c").write_text(blocks(PAGE, "c")[0], encoding="utf-8")
    subprocess.run(["gcc", "-std=c99", "-Wall", "-Werror", "-c", "use.c"], cwd=tmp_path, check=True)


@pytest.mark.skipif(shutil.which("g++") is None, reason="no g++ on this machine")
def test_the_cpp_lines(tmp_path):
    write_export(export(examples.textbook("arm"), "ros2_control"), tmp_path)
    (tmp_path / "use.cpp").write_text(blocks(PAGE, "cpp")[0], encoding="utf-8")
    command = ["g++", "-std=c++17", "-Wall", "-Werror", "-Iinclude", "-c", "use.cpp"]
    subprocess.run(command, cwd=tmp_path, check=True)
