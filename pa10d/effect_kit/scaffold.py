"""A package for an effect of one's own: it works as it stands, and is to be changed."""

from __future__ import annotations

import keyword
import re
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.effects import all_effects

MODULE = '''"""{title}."""

import numpy as np

from pa10d.effects import Coefficient, Effect, Example, ShapeParameter, View


class {name}(Effect):
    """Say in plain words what it is: this opens its page. As it stands: something pulls the joint
    back to the middle of its range, softly near it and with the torque A far from it; w is how
    far the soft part reaches."""

    id = "{id}"
    title = "{title}"
    noun = "{title_in_words}"  # as in "Joint 4 shows …", with its article
    equation = "τ = A·tanh(q/w)"
    coefficients = (Coefficient("A", "N·m", lower=0.0),)  # what the torque is linear in
    shapes = (ShapeParameter("w", "rad", 0.02, 2.0, "log"),)  # everything else, with its bounds
    signature = "What the error looks like to a person, against which quantity."
    confounders = {{"spring": "close to the middle both pull back in proportion to the angle"}}
    experiment = "What separates it from those, in words."
    experiment_kind = "point_to_point"
    source = "Where the equation comes from"
    remedy = "What a technician may do about it."
    view = View("q")  # what a finding of it is drawn against
    example = Example((6.0,), against="q", shape={{"w": 0.3}})  # a typical case, for its page

    def columns(self, context, joints, shape):
        """Torque per unit of each coefficient, (N, k): the one formula, for fit, controller and
        export. NumPy alone, so that an export can carry it."""
        return np.tanh(context.q[:, joints[0]] / shape["w"])[:, None]

    def starts(self, context, joints):
        """Shapes at which a search begins."""
        return [{{"w": w}} for w in (0.05, 0.2, 0.8)]
'''

HIDDEN = '''"""{title} as the simulated arm hides it: from the physics, apart from the formula."""

import math


class {name}Law:
    """As it stands: the joint is pulled back to zero, softly near it."""

    where = "joint"
    parameters = {{"A": None, "w": 0.3}}  # with None an entry has to state it

    @staticmethod
    def draw(rng, arm):
        """A joint (from 1) and sizes that show, by the arm's own friction and reach."""
        j = int(rng.integers(arm.n))
        A = rng.uniform(0.6, 1.2) * arm.book.coulomb[j]
        return {{"joint": j + 1, "A": A, "w": rng.uniform(0.15, 0.4) * arm.reach.half[j]}}

    def __init__(self, A, w):
        self.A, self.w = A, w

    def torque(self, dt, q, dq):
        """N·m against the motion over the next dt s, from rad and rad/s of its own joints."""
        return [self.A * (1.0 - 2.0 / (1.0 + math.exp(2.0 * angle / self.w))) for angle in q]
'''

TEST = '''"""{title}: the conformance kit, and the formula written a second time."""

import math

import numpy as np
import pytest

from pa10d.effect_kit import check
from pa10d.effects import effect
from pa10d.effects.context import posed
from pa10d.dynamics import robot_from_profile
from pa10d.profile import load_profile


def test_it_conforms():
    assert [v for v in check(effect("{id}")) if not v.passed] == []


def test_columns_are_the_formula():
    robot = robot_from_profile(load_profile("pa10-sim"))
    q = np.random.default_rng(0).uniform(-2.0, 2.0, (50, robot.n))
    found = effect("{id}").columns(posed(robot, q, 0 * q, 0 * q), (1,), {{"w": 0.4}})
    assert found[:, 0] == pytest.approx([math.tanh(angle / 0.4) for angle in q[:, 1]])
'''

PROJECT = """[project]
name = "{package}"
version = "0.1.0"
description = "{title}: an effect for pa10d"
requires-python = ">=3.11"
dependencies = ["pa10d"]

[project.entry-points."pa10d.effects"]
{id} = "{id}:{name}"

[project.entry-points."pa10d.hidden"]
{id} = "{id}_hidden:{name}Law"

[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[tool.hatch.build.targets.wheel]
include = ["{id}.py", "{id}_hidden.py"]
"""


def scaffold(name: str, folder: Path) -> list[Path]:
    """Write package, law, test and page for the effect ``name`` into a new folder; the files."""
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or keyword.iskeyword(name):
        raise UserError(f"{name!r}: expected small letters, digits and underscores")
    if name in all_effects():
        raise UserError(f"{name}: there is such an effect already; expected a new name")
    if folder.exists():
        raise UserError(f"{folder}: there is such a file or folder already; expected a new one")
    words = name.replace("_", " ")
    told = {
        "id": name,
        "name": "".join(part.capitalize() for part in name.split("_")),
        "title": words.capitalize(),
        "title_in_words": ("an " if words[0] in "aeiou" else "a ") + words,
        "package": name.replace("_", "-"),
    }
    texts = {
        f"{name}.py": MODULE.format(**told),
        f"{name}_hidden.py": HIDDEN.format(**told),
        f"tests/test_{name}.py": TEST.format(**told),
        "pyproject.toml": PROJECT.format(**told),
    }
    texts[f"{name}.md"] = _page(texts[f"{name}.py"], told["name"])
    for file, text in texts.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text, encoding="utf-8")
    return [folder / file for file in texts]


def _page(source: str, name: str) -> str:
    from pa10d.effects.pages import page

    space: dict = {"__name__": name}
    exec(compile(source, name, "exec"), space)
    titles = {kind.id: kind.title for kind in all_effects().values()}
    return page(space[name](), titles, None)
