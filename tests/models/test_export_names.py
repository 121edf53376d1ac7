"""Names that people give: none of them breaks a file that carries it."""

from __future__ import annotations

import shutil
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from model_examples import textbook

from pa10d.export.formats import export

NAMES = [
    'a"""b',
    "--",
    "a -->b",
    "---",
    'x"',
    "{0} {name}",
    "*/ x",
    "*" + "/" * 3,
    "7",
    "ä",
    "#",
    "%",
]


def _model(name):
    model = textbook(name)
    joints = tuple(model.robot.joint_names)
    return replace(model, robot=replace(model.robot, joint_names=('j"""1', r"\N{x}", *joints[2:])))


@pytest.mark.by_default("*/ x", 'x"', "7")
@pytest.mark.parametrize("name", NAMES)
def test_python_and_c(name, tmp_path):
    module = export(_model(name), "python", "free", about=f"{name} of run {name}").text
    compile(module, "exported", "exec")
    header = tmp_path / "model.h"
    header.write_text(export(_model(name), "c", "free", about=name).text, encoding="utf-8")
    if shutil.which("cc"):
        done = subprocess.run(["cc", "-fsyntax-only", "-x", "c", header], capture_output=True)
        assert done.returncode == 0, done.stderr.decode()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("format", ["urdf", "mjcf", "sdf"])
def test_xml(name, format):
    model = textbook(name)
    model = replace(model, standard=model.robot.parameters, feasible=True)
    text = export(model, format, about=f"{name} - {name}").text
    ET.fromstring(text)
