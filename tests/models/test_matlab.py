"""The MATLAB function against what it stands for: its statements read one by one, and Octave where
it is installed."""

import math
import re
import shutil
import subprocess

import model_examples as examples
import numpy as np
import pytest

from pa10d.dynamics import inverse_dynamics
from pa10d.effects import all_effects
from pa10d.export.formats import export

STATEMENT = re.compile(r"  (\w+|tau\(end \+ 1\)) = (.+);")
SPACE = {name: getattr(math, name) for name in ("sin", "cos", "tanh", "exp", "sqrt", "log", "asin")}
SPACE |= {"abs": abs, "max": max, "min": min, "double": float, "sign": np.sign}


def read(text, q, dq, ddq):
    """tau and gravity, as the language's manual has these operators."""
    space: dict = {**SPACE, "tau": []}
    for line in text.split("\n"):
        found = STATEMENT.fullmatch(line)
        if line.strip().startswith("%") or found is None:
            continue
        name, value = found.groups()
        value = re.sub(r"\b(q|dq|ddq)\((\d+)\)", lambda m: f"{m[1]}[{int(m[2]) - 1}]", value)
        value = value.replace("^", "**").replace("~=", "!=")
        result = eval(value, {"__builtins__": {}}, {**space, "q": q, "dq": dq, "ddq": ddq})
        if name == "tau(end + 1)":
            space["tau"] = [*space["tau"], result]
        else:
            space[name] = result
    return space["tau"], space["gravity"]


def test_every_effect_agrees():
    model = examples.with_effects(examples.textbook(), *sorted(all_effects()))
    made = export(model, "matlab", "free", "test")
    motion = examples.motion()
    assert made.not_carried == ()
    assert made.text.startswith("function [tau, gravity] = m1(q, dq, ddq)\n")
    assert "backlash of joint 2 remembers" in made.text
    for k in (3, 111, 287):
        given = [x[k] for x in (motion.q, motion.dq, motion.ddq)]
        tau, gravity = read(made.text, *given)
        assert tau == pytest.approx(model.torque(*given), abs=1e-9)
        rest = np.zeros((1, 4))
        expected = inverse_dynamics(model.robot, model.rigid, given[0][None], rest, rest)[0]
        assert gravity == pytest.approx(expected, abs=1e-10)


@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="no Octave on this machine")
def test_it_agrees_in_octave(tmp_path):
    model, motion = examples.with_effects(examples.textbook(), "stribeck"), examples.motion()
    (tmp_path / "m1.m").write_text(export(model, "matlab", "free").text, encoding="utf-8")
    given = [x[17] for x in (motion.q, motion.dq, motion.ddq)]
    rows = ", ".join(str(list(map(float, x))) for x in given)
    done = subprocess.run(
        ["octave-cli", "--eval", f'printf("%.17g\\n", m1({rows}))'],
        cwd=tmp_path, capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    assert list(map(float, done.stdout.split())) == pytest.approx(model.torque(*given), abs=1e-9)
