"""Formulae written out with all that they stand on, and those that cannot be."""

import importlib
import sys

import numpy as np
import pytest

from pa10d.effects import Effect
from pa10d.export.source import NotWritable, SourceText

HEAD = """
import math
import numpy as np
import scipy.signal
from functools import cache
from math import tau as FULL
from numba import njit

from pa10d.effects import Coefficient, Effect


class Base(Effect):
    id = "odd"
    title = equation = signature = experiment = source = "odd"
    coefficients = (Coefficient("a", "N·m"),)
"""
ONE = (
    HEAD
    + """
LIMIT, TABLE, NEVER = 2.0, {"a": (1.0,), "b": np.array([3.0])}, float("inf")


@njit(
    cache=True,
)
def helper(x):
    out = np.empty(len(x))
    for k in range(len(x)):
        out[k] = LIMIT * x[k] + (lambda v: v + FULL)(0.0)
    return out


@cache
def twice():
    return 2.0 * math.pi


class One(Base):
    scale = 4.0

    def columns(self, context, joints, shape):
        return (self.scaled(helper(context.q[:, 0])) + self.shift)[:, None]

    @staticmethod
    def other(x):
        return np.minimum(x, NEVER)

    @property
    def shift(self):
        return TABLE["a"][0] + TABLE["b"][0] + twice()

    def scaled(self, x, by=LIMIT):
        return self.scale * self.other(x) * by
"""
)
TWO = (
    HEAD
    + """
LIMIT = -1.0


def helper(x):
    return LIMIT * x


class Two(Base):
    def columns(self, context, joints, shape):
        helper_of = {"LIMIT": helper}
        return helper_of["LIMIT"](context.q)
"""
)


class Seen:
    q = np.linspace(-1.0, 1.0, 6)[:, None]


@pytest.fixture
def written(tmp_path, monkeypatch):
    """Effects of these modules, and what their text gives when it runs."""
    monkeypatch.syspath_prepend(tmp_path)

    def load(name, code):
        (tmp_path / f"{name}.py").write_text(code, encoding="utf-8")
        importlib.invalidate_caches()
        found = importlib.import_module(name)
        return next(
            v for v in vars(found).values()
            if isinstance(v, type) and issubclass(v, Effect) and v.__module__ == name
            and "columns" in vars(v)
        )()  # fmt: skip

    yield load
    for name in ("module_one", "module_two"):
        sys.modules.pop(name, None)


def test_two_modules_of_the_same_names_stay_two(written):
    kinds = [written("module_one", ONE), written("module_two", TWO)]
    source = SourceText()
    names = [source.add_effect(kind) for kind in kinds]
    assert [source.add_effect(kind) for kind in kinds] == names
    text, space = source.text(), {}
    assert "numba" not in text
    assert "scipy" not in text
    assert text.count("def helper(") == text.count("def helper_module_two(") == 1
    exec(compile(text, "written", "exec"), space)
    for kind, name in zip(kinds, names, strict=True):
        found = space[name]().columns(Seen, (0,), {})
        assert found == pytest.approx(kind.columns(Seen, (0,), {}))
        assert space[name].sensing is False


BODY = '        return helper_of["LIMIT"](context.q)'


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("        return scipy.signal.hilbert(context.q)", "its formula uses scipy"),
        ("        return super().columns(context, joints, shape)", "call the class above it"),
        ("        return self.coefficients[0].lower + context.q", "coefficients, a Coeff"),
        ("        return made(context.q)", "inner is made inside another function"),
        ("        return OPEN.read(context.q)", "uses OPEN, a Thing that is no plain number"),
    ],
)  # fmt: skip
def test_what_cannot_be_written_says_why_and_leaves_nothing(written, body, why):
    more = """
def maker():
    kept = 2.0
    def inner(x):
        return kept * x
    return inner

made = maker()

class Thing:
    pass

OPEN = Thing()

class Two"""
    kind = written("module_two", TWO.replace(BODY, body).replace("\nclass Two", more, 1))
    source = SourceText()
    with pytest.raises(NotWritable, match=why):
        source.add_effect(kind)
    assert source.text().strip() == ""


def test_a_class_without_source_says_so(written):
    kind = written("module_two", TWO)
    space: dict = {"Base": type(kind).__mro__[1], "np": np}
    exec(
        "class Two(Base):\n    def columns(self, context, joints, shape):\n        return 1", space
    )
    with pytest.raises(NotWritable, match="the source of columns cannot be read"):
        SourceText().add_effect(space["Two"]())
