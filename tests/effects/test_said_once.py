"""What is particular to one effect stands in its class, and in no table elsewhere."""

import ast
from pathlib import Path

from pa10d.effects import all_effects

ROOT = Path(__file__).resolve().parents[2]
BESIDE = {
    ("pa10d/effect_kit/numbers.py", "coulomb"),  # a model for an effect to be tried in
    ("pa10d/effect_kit/numbers.py", "viscous"),
    ("pa10d/diagnose/search/timing.py", "torque_delay"),  # measures each joint's delay by it
    ("pa10d/api/schemas/models.py", "stribeck"),  # an example in the API's description
    ("pa10d/case_study/arm.py", "stribeck"),  # an entry for the simulator
    ("pa10d/daemon/hanging.py", "payload"),  # likewise
    ("pa10d/services/weighing/apply.py", "torque_gain"),  # a key of profiles
}


def test_no_module_outside_the_library_names_an_effect():
    ids = set(all_effects())
    found = set()
    for file in (ROOT / "pa10d").rglob("*.py"):
        if "effects/library" in file.as_posix():
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and node.value in ids:
                found.add((file.relative_to(ROOT).as_posix(), node.value))
    assert found == BESIDE
