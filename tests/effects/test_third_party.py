"""Effects of other packages, as docs/add-an-effect.md tells to make them."""

import importlib
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from effect_motions import arm_context

from pa10d.common.errors import UserError
from pa10d.effects import all_effects, effect
from pa10d.effects.pages import page
from pa10d.effects.portrait import portrait
from pa10d.model import Term

ROOT = Path(__file__).resolve().parents[2]
GUIDE = (ROOT / "docs" / "add-an-effect.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w*)\n(.*?)```", GUIDE, re.DOTALL)
CLASS, CHECK, LAW = (text for kind, text in BLOCKS if kind == "python")
PYPROJECT = next(tomllib.loads(text) for kind, text in BLOCKS if kind == "toml")
(MODULE,) = re.findall(r"^`(\w+)\.py`:", GUIDE, re.MULTILINE)


def install(folder: Path, code: str, points: dict[str, str]) -> None:
    """What pip leaves behind: a module and its metadata."""
    project = PYPROJECT["project"]
    (folder / f"{MODULE}.py").write_text(code, encoding="utf-8")
    info = folder / f"{MODULE}-{project['version']}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    lines = [f"{name} = {value}" for name, value in points.items()]
    (info / "entry_points.txt").write_text("[pa10d.effects]\n" + "\n".join(lines) + "\n")


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Install code as a package of its own; undone afterwards."""

    def do(code=CLASS, points=None):
        install(tmp_path, code, points or PYPROJECT["project"]["entry-points"]["pa10d.effects"])
        monkeypatch.syspath_prepend(tmp_path)
        importlib.invalidate_caches()
        all_effects.cache_clear()

    yield do
    all_effects.cache_clear()
    sys.modules.pop(MODULE, None)


def test_the_guides_effect_is_found_and_is_one_of_the_library(installed):
    before = set(all_effects())
    installed()
    assert set(all_effects()) == before | {"creeping_hose"}
    assert list(all_effects())[-1] == "creeping_hose"
    assert effect("creeping_hose").title == "Creeping hose"


def test_the_guides_check_of_its_columns_holds(installed):
    installed()
    exec(compile(CHECK, "docs/add-an-effect.md", "exec"), {})


def test_it_works_in_a_model_and_has_a_page(installed):
    installed()
    context = arm_context(seed=31, seconds=2.0)
    torque = Term("creeping_hose", (1,), np.array([40.0]), {"T": 2.0}).torque(context)
    assert torque[:, 1].any()
    assert not np.delete(torque, 1, axis=1).any()
    kind = effect("creeping_hose")
    text = page(kind, {"spring": "Spring"}, portrait(kind, context.robot))
    assert "# Creeping hose" in text
    assert "[Spring](spring.md)" in text
    assert "| `T` | s | 0.1 | 100 |" in text


def test_a_fresh_process_finds_it(tmp_path):
    install(tmp_path, CLASS, {"creeping_hose": f"{MODULE}:CreepingHose"})
    found = subprocess.run(
        [
            sys.executable,
            "-c",
            "from pa10d.effects import effect; print(effect('creeping_hose').id)",
        ],
        env=os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert found.stdout.strip() == "creeping_hose", found.stderr


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('    source = "', '    origin = "', "'source' is missing, expected a text"),
        ('id = "creeping_hose"', 'id = "Hose!"', "id 'Hose!', expected small letters"),
        ('id = "creeping_hose"', 'id = "spring"', "effect 'spring' exists already"),
        ('title = "Creeping hose"', "title = 7", "'title' is 7, expected a text"),
        (
            "    signature =",
            '    scope = "arm"\n    signature =',
            "'scope' is 'arm', expected one of",
        ),
        ("    signature =", '    scope = "pair"\n    signature =', "needs reaches_other_joints"),
        ('(Coefficient("k", "N·m/rad", lower=0.0),)', "()", "expected at least one Coefficient"),
        ("def starts", "def begins", "expected a method 'starts'"),
        ("def columns", "def column", "cannot be loaded: Can't instantiate abstract class"),
        ("(Effect)", "", "CreepingHose is no subclass of pa10d.effects.Effect"),
        ("import numpy", "import numpie", "cannot be loaded: No module named 'numpie'"),
    ],
)
def test_what_is_wrong_with_it_is_one_line_with_its_name(installed, old, new, message):
    assert old in CLASS
    installed(CLASS.replace(old, new, 1))
    with pytest.raises(UserError) as told:
        all_effects()
    assert message in str(told.value)
    assert str(told.value).startswith("creeping-hose: entry point pa10d.effects creeping_hose = ")
    assert "\n" not in str(told.value)


def test_an_entry_point_that_leads_nowhere(installed):
    installed(points={"gone": f"{MODULE}:Gone"})
    with pytest.raises(UserError, match=r"creeping-hose: .*cannot be loaded: .*Gone"):
        all_effects()


def test_an_unknown_id_names_the_known_ones():
    with pytest.raises(UserError, match=r"^stribek: no such effect; expected one of .*stribeck"):
        effect("stribek")
