"""The source of formulae and of all that they stand on, in one text that needs NumPy alone.

What an export says is what the classes say: their methods are written out as they are, with the
functions and constants that they use. Compiled loops lose their compiler and stay the same loops;
rigid bodies have a stand-in. What stands on anything else cannot be written out, and is told why.
"""

from __future__ import annotations

import ast
import builtins
import dis
import inspect
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping
from itertools import accumulate
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numba.core.dispatcher
import numpy as np

from pa10d.effects import Effect
from pa10d.export import bodies

FLAGS = (
    "sensing",
    "reaches_other_joints",
    "rubs",
    "is_rotor",
    "feels_own_heat",
    "uses_model",
    "series_spring",
    "carried",
    "builds_up_over",
    "damped_over",
    "smoothed_over",
)
"""What the sum of a model's effects asks of each."""

STOOD_IN_FOR = "pa10d.dynamics"


class NotWritable(Exception):
    """Why a formula cannot be written out, as the end of a sentence."""


class SourceText:
    """Grows by what is added; ``text`` is what has been added so far, each thing once."""

    def __init__(self) -> None:
        self._names: dict[object, str] = {}
        self._taken: dict[str, object] = {}
        self._imports: dict[str, None] = {}
        self._constants: list[str] = []
        self._definitions: list[str] = []

    def text(self) -> str:
        """Imports, constants, definitions."""
        parts = ["\n".join(sorted(self._imports)), "\n".join(self._constants), *self._definitions]
        return "\n\n\n".join(part for part in parts if part) + "\n"

    def add(self, thing: object, name: str, module: str = "") -> str:
        """The name under which a thing stands in the text; name, module: where it was found."""
        thing = _plain(thing)
        key = _key(thing, name)
        if key not in self._names:
            trial = self._copy()
            trial._write(key, thing, name, module)
            vars(self).update(vars(trial))
        return self._names[key]

    def add_effect(self, kind: Effect) -> str:
        """Name of a class with the effect's columns and what the sum of effects asks of it."""
        trial = self._copy()
        key = type(kind)
        if key in self._names:
            return self._names[key]
        name = trial._name(key, key.__name__, key.__module__)
        head = [f"class {name}:", f'    """{kind.equation}"""', ""]
        head += [f"    {flag} = {getattr(kind, flag)!r}" for flag in FLAGS]
        asked = ["columns", "level"] if kind.carried else ["columns"]
        members = dict.fromkeys(m for method in asked for m in _reached(kind, method))
        found = [trial._member(kind, member) for member in members]
        values = [line for line, method in found if not method]
        methods = [line for line, method in found if method]
        trial._definitions.append("\n\n".join(["\n".join([*head, *values]), *methods]))
        vars(self).update(vars(trial))
        return name

    def _copy(self) -> SourceText:
        """Half of what failed must not stay behind."""
        other = SourceText()
        for key, value in vars(self).items():
            setattr(other, key, value.copy())
        return other

    def _name(self, key: object, name: str, module: str) -> str:
        """A name of its own for a thing; what comes second is called after its module, too."""
        free, number = name, 1
        while self._taken.get(free, key) != key:
            free = f"{name}_{module.rpartition('.')[2]}" + (f"_{number}" if number > 1 else "")
            number += 1
        self._taken[free] = key
        self._names[key] = free
        return free

    def _write(self, key: object, thing: object, name: str, module: str) -> None:
        if isinstance(thing, ModuleType):
            _refuse(thing.__name__)
            self._imports[f"import {thing.__name__} as {self._name(key, name, module)}"] = None
        elif isinstance(thing, FunctionType | type) and not _is_library(thing):
            own = self._name(key, thing.__name__, thing.__module__)
            text = self._definition(thing, own)  # what it stands on comes before it
            self._definitions.append(text)
        elif callable(thing):
            home, called = _home(thing), getattr(thing, "__name__", name)
            _refuse(home)
            own = self._name(key, name, module)
            as_own = "" if own == called else f" as {own}"
            self._imports[f"from {home} import {called}{as_own}"] = None
        else:
            text = _written(thing, name)
            self._constants.append(f"{self._name(key, name, module)} = {text}")

    def _definition(self, thing: FunctionType | type, own: str) -> str:
        """A function or a class as it is written, under its own name."""
        tree, text = _parsed(thing)
        function = thing if isinstance(thing, FunctionType) else None
        space = function.__globals__ if function else vars(sys.modules[thing.__module__])
        used = sorted(_names_in(thing, tree) & space.keys())
        names = {n: self.add(space[n], n, thing.__module__) for n in used}
        text = self._renamed(tree, text, names)
        return text.replace(f" {thing.__name__}", f" {own}", 1) if own != thing.__name__ else text

    def _renamed(self, tree: ast.AST, text: str, names: Mapping[str, str]) -> str:
        changed = {old: new for old, new in names.items() if old != new}
        lines = text.split("\n")
        at = [n for n in ast.walk(tree) if isinstance(n, ast.Name) and n.id in changed]
        for node in sorted(at, key=lambda n: (n.lineno, -n.col_offset)):
            line = lines[node.lineno - 1].encode()
            head, tail = line[: node.col_offset], line[node.col_offset + len(node.id.encode()) :]
            lines[node.lineno - 1] = (head + changed[node.id].encode() + tail).decode()
        return "\n".join(lines)

    def _member(self, kind: Effect, name: str) -> tuple[str, bool]:
        """A method or a value of the class, and whether it is a method."""
        found = _function(inspect.getattr_static(type(kind), name, None))
        if found is None:
            return f"    {name} = {_written(getattr(kind, name), name)}", False
        return textwrap.indent(self._definition(found, found.__name__), "    "), True


def _key(thing: object, name: str) -> object:
    """What makes a thing the same as another: constants are by name and value."""
    if callable(thing) or isinstance(thing, ModuleType):
        return thing
    return name, _written(thing, name)


def _plain(thing: Any) -> object:
    """Without its compiler; rigid bodies as their stand-in."""
    if isinstance(thing, numba.core.dispatcher.Dispatcher):
        thing = thing.py_func
    if isinstance(getattr(thing, "__wrapped__", None), FunctionType):
        thing = thing.__wrapped__  # its source has the decorator
    if isinstance(thing, FunctionType) and thing.__module__.startswith(STOOD_IN_FOR):
        stand_in = getattr(bodies, thing.__name__, None)
        if stand_in is None:
            raise NotWritable(f"it uses {thing.__name__}, for which exports have nothing")
        return stand_in
    return thing


def _reached(kind: Effect, start: str) -> list[str]:
    """Members of an effect that this method uses, itself among them."""
    found, waiting = [], [start]
    while waiting:
        name = waiting.pop(0)
        if name in found:
            continue
        found.append(name)
        function = _function(inspect.getattr_static(type(kind), name, None))
        if function is not None:
            waiting += sorted(_of_self(_parsed(function)[0]))
    return found


def _of_self(tree: ast.AST) -> set[str]:
    if any(isinstance(n, ast.Name) and n.id == "super" for n in ast.walk(tree)):
        raise NotWritable("its columns call the class above it")
    return {
        n.attr
        for n in ast.walk(tree)
        if isinstance(n, ast.Attribute) and isinstance(n.value, ast.Name) and n.value.id == "self"
    }


def _function(member: Any) -> FunctionType | None:
    for inner in ("fget", "func", "__func__"):
        member = getattr(member, inner, member)
    return member if isinstance(member, FunctionType) else None


def _parsed(thing: FunctionType | type) -> tuple[ast.AST, str]:
    """Syntax tree and text, without the decorators of a compiler."""
    try:
        text = textwrap.dedent(inspect.getsource(thing)).rstrip("\n")
    except (OSError, TypeError) as error:
        raise NotWritable(f"the source of {thing.__name__} cannot be read") from error
    (node,) = ast.parse(text).body
    lines = text.split("\n")
    for decorator in getattr(node, "decorator_list", []):
        if ast.unparse(decorator).startswith(("numba.", "njit", "jit")):
            for k in range(decorator.lineno - 1, (decorator.end_lineno or 0)):
                lines[k] = ""
    text = _without_annotations("\n".join(lines).lstrip("\n"))
    return ast.parse(text).body[0], text


def _without_annotations(text: str) -> str:
    """They name types that a module of NumPy alone does not have, and ``dataclass`` would look for
    those in a module that whoever loads it may have registered nowhere."""
    tree, written = ast.parse(text), text.encode()
    starts = [0, *accumulate(len(line) + 1 for line in written.split(b"\n"))]
    cuts: list[tuple[int, int, bytes]] = []

    def end(node: ast.expr) -> int:
        return starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)

    for node in ast.walk(tree):
        if isinstance(node, ast.arg) and node.annotation is not None:
            begin = starts[node.lineno - 1] + node.col_offset + len(node.arg.encode())
            cuts.append((begin, end(node.annotation), b""))
        elif isinstance(node, ast.FunctionDef) and node.returns is not None:
            begin = starts[node.returns.lineno - 1] + node.returns.col_offset
            cuts.append((written.rfind(b"->", 0, begin) - 1, end(node.returns), b""))
        elif isinstance(node, ast.ClassDef):
            fields = [inner for inner in node.body if isinstance(inner, ast.AnnAssign)]
            for inner in fields:
                of_class = ast.unparse(inner.annotation).startswith("ClassVar")
                kept = b"" if of_class else b": object"
                cuts.append((end(inner.target), end(inner.annotation), kept))
    for begin, until, instead in sorted(cuts, reverse=True):
        written = written[:begin] + instead + written[until:]
    return written.decode()


def _names_in(thing: FunctionType | type, tree: ast.AST) -> set[str]:
    """Names that the definition looks up in its module."""
    if isinstance(thing, FunctionType):
        if thing.__closure__:
            raise NotWritable(f"{thing.__name__} is made inside another function")
        found = set(_looked_up(thing.__code__))
    else:
        methods = [f for m in vars(thing).values() if (f := _function(m)) is not None]
        written = [f for f in methods if f.__module__ == thing.__module__]
        found = {name for f in written for name in _looked_up(f.__code__)}
        assert isinstance(tree, ast.ClassDef)
        values = [n.value for n in tree.body if isinstance(n, ast.Assign | ast.AnnAssign)]
        found |= {
            n.id
            for v in (*values, *tree.bases)
            if v
            for n in ast.walk(v)
            if isinstance(n, ast.Name)
        }
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            early = list(node.decorator_list)
            if isinstance(node, ast.FunctionDef):
                early += [d for d in (*node.args.defaults, *node.args.kw_defaults) if d]
            found |= {n.id for e in early for n in ast.walk(e) if isinstance(n, ast.Name)}
    return found - vars(builtins).keys()


def _looked_up(code: CodeType) -> Iterator[str]:
    for step in dis.get_instructions(code):
        if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
            yield step.argval
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _looked_up(inner)


def _is_library(thing: Callable[..., Any]) -> bool:
    root = _home(thing).partition(".")[0]
    return root == "numpy" or root in sys.stdlib_module_names


def _home(thing: Any) -> str:
    if isinstance(thing, np.ufunc):
        return "numpy"
    return getattr(thing, "__module__", None) or "?"


def _refuse(module: str) -> None:
    root = module.partition(".")[0]
    if root != "numpy" and root not in sys.stdlib_module_names:
        raise NotWritable(f"its formula uses {root}, and an export stands on NumPy alone")


def _written(value: Any, name: str) -> str:
    """A value as it would be typed."""
    if isinstance(value, np.ndarray):
        return f"np.array({value.tolist()!r})"
    if isinstance(value, float | np.floating):
        return repr(float(value)) if np.isfinite(value) else f'float("{float(value)}")'
    if value is None or isinstance(value, bool | int | str | complex):
        return repr(value)
    if isinstance(value, tuple | list):
        inner = ", ".join(_written(v, name) for v in value)
        return f"[{inner}]" if isinstance(value, list) else f"({inner}{',' * (len(value) == 1)})"
    if isinstance(value, dict):
        pairs = (f"{_written(k, name)}: {_written(v, name)}" for k, v in value.items())
        return "{" + ", ".join(pairs) + "}"
    raise NotWritable(f"its formula uses {name}, a {type(value).__name__} that is no plain number")
