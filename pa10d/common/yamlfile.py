"""YAML files that people write: every problem becomes one line naming file, line and key.

Reads YAML with the line of every key, refuses a key given twice, and turns the errors of a
pydantic model into sentences of the form ``file:line: key: found …, expected …``.
"""

from __future__ import annotations

import contextlib
import difflib
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, get_args

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import PydanticCustomError

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject

LARGEST = 16 << 20  # bytes of a file
DEEPEST = 100  # sections within sections
MOST = 1_000_000  # values, those that stand for others (aliases) written out
BROKEN = (  # what PyYAML lets out for files that are none
    yaml.YAMLError, ValueError, RecursionError, AttributeError, KeyError, IndexError, TypeError,
    OverflowError,
)  # fmt: skip
Model = TypeVar("Model", bound=BaseModel)
Location = tuple[int | str, ...]

EXPECTED = {
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "dataclass_type": "a section of keys and values",
    "dict_type": "a section of keys and values",
    "finite_number": "a finite number",
    "float_parsing": "a number",
    "float_type": "a number",
    "greater_than": "a number above {gt:g}",
    "greater_than_equal": "a number of at least {ge:g}",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "less_than": "a number below {lt:g}",
    "less_than_equal": "a number of at most {le:g}",
    "list_type": "a list",
    "literal_error": "{expected}",
    "missing": "a value; it has no default",
    "model_type": "a section of keys and values",
    "string_type": "text",
    "too_short": "a list of at least {min_length}",
    "too_long": "at most {max_length} entries",
    "tuple_type": "a list",
}


def expected(what: str) -> PydanticCustomError:
    """The error a validator raises: it says what would have been right."""
    return PydanticCustomError("expected", "{what}", {"what": what})


def several(problems: list[tuple[Location, Any, str]]) -> PydanticCustomError:
    """Several errors of one validator: (location, what was found, what is expected)."""
    return PydanticCustomError("several", "several problems", {"problems": problems})


class _Loader(yaml.SafeLoader):
    """Safe YAML that also reads 1e-3 as a number (YAML 1.1 wants 1.0e-3)."""


EXPONENT = (
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?[0-9][0-9_]*[eE][-+]?[0-9]+$"),
    list("-+0123456789"),
)
_Loader.add_implicit_resolver(*EXPONENT)


class _CompiledLoader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """The same nodes in a tenth of the time, for what is known to be YAML."""


_CompiledLoader.add_implicit_resolver(*EXPONENT)


class Trap(yaml.YAMLError):
    """Few bytes that would become very much, or very deep."""


def refuse_traps(text: str | bytes) -> None:
    """Look at the structure without building it: Trap where that would not end well.

    A few aliases of aliases stand for more values than any memory holds, and a compiled reader
    does not survive ten thousand brackets.
    """
    sizes: dict[str, int] = {}  # of what an anchor names, once it is complete
    open_: list[tuple[str | None, int]] = [(None, 0)]

    def add(size: int) -> None:
        name, before = open_[-1]
        open_[-1] = name, before + size
        if before + size > MOST:
            raise Trap(f"more than {MOST} values once all aliases are written out")

    for event in yaml.parse(text, Loader=_EVENTS):
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in sizes:
                raise Trap(f"alias '*{event.anchor}' stands for nothing before it")
            add(sizes[event.anchor])
        elif isinstance(event, yaml.CollectionStartEvent):
            open_.append((event.anchor, 1))
            if len(open_) > DEEPEST:
                raise Trap(f"more than {DEEPEST} sections within each other")
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, size = open_.pop()
            add(size)
            if anchor is not None:
                sizes[anchor] = size
        elif isinstance(event, yaml.ScalarEvent):
            add(1)
            if event.anchor is not None:
                sizes[event.anchor] = 1


_EVENTS = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class YamlFile:
    """A YAML mapping and where its keys stand."""

    path: Path
    text: str
    data: JsonObject
    root: yaml.MappingNode

    def problem(self, location: Location, found: str, wanted: str) -> str:
        """One line about one key; entries of lists are counted from 1."""
        key = ".".join(str(part + 1 if isinstance(part, int) else part) for part in location)
        middle = f" {key}:" if key else ""
        return f"{self.path}:{self._line(location)}:{middle} found {found}, expected {wanted}"

    def _line(self, location: Location) -> int:
        node: Any = self.root
        line = node.start_mark.line
        for part in location:
            child = _child(node, part)
            if child is None:
                break
            line, node = child
        return int(line) + 1


def read_yaml(path: Path) -> YamlFile:
    """Read a file whose top level is a mapping; raise UserError with file and line."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
        if len(content) > LARGEST:
            raise UserError(f"{path}: more than {LARGEST} bytes; expected a YAML file")
        text = content.decode("utf-8-sig")
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}; expected a readable YAML file") from error
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: byte {error.start + 1} is not UTF-8; expected text") from error
    try:
        loader: _Loader | _CompiledLoader = _Loader(text)
        with contextlib.suppress(yaml.MarkedYAMLError):  # said below, with its line
            refuse_traps(text)
            loader = _CompiledLoader(text)
    except yaml.YAMLError as error:
        what = " ".join(str(error).split())
        raise UserError(f"{path}: {what}; expected plain text") from error
    try:
        root = loader.get_single_node()
        for key, line, first in _given_twice(root, set()):
            raise UserError(
                f"{path}:{line}: {key}: found a second time, expected once (first in line {first})"
            )
        data = None if root is None else loader.construct_document(root)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f":{mark.line + 1}" if mark else ""
        what = error.problem or "not YAML"
        raise UserError(f"{path}{where}: {what}; expected lines 'key: value'") from error
    except BROKEN as error:
        what = (str(error).splitlines() or [type(error).__name__])[0]
        raise UserError(f"{path}: {what}; expected lines 'key: value'") from error
    finally:
        loader.dispose()
    if not isinstance(data, dict) or not isinstance(root, yaml.MappingNode):
        found = "an empty file" if data is None else _brief(data)
        raise UserError(f"{path}:1: found {found}, expected lines 'key: value'")
    return YamlFile(path, text, data, root)


def read_value(text: str, where: str) -> Any:
    """One value as it stands in YAML: a number, a list, a word."""
    try:
        return yaml.load(text, Loader=_Loader)
    except BROKEN as error:
        raise UserError(f"{where}: found {text[:100]!r}, expected a value as in YAML") from error


def validate(model: type[Model], file: YamlFile, data: Mapping[str, Any]) -> Model:
    """Build the model; every problem is one line of the raised UserError."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        lines = [line for item in error.errors() for line in _lines(model, file, item)]
        raise UserError("\n".join(lines)) from error


def _lines(model: type[BaseModel], file: YamlFile, error: Any) -> Iterator[str]:
    location, kind = error["loc"], error["type"]
    if kind == "several":
        for where, found, wanted in error["ctx"]["problems"]:
            yield file.problem(where, _brief(found), wanted)
    elif kind == "extra_forbidden":
        yield file.problem(location, "an unknown key", _known_keys(model, location))
    elif kind == "missing":
        yield file.problem(location, "nothing", EXPECTED["missing"])
    else:
        yield file.problem(location, _brief(error["input"]), expectation(error))


def expectation(error: Any) -> str:
    """What one error of pydantic says would have been right."""
    template = EXPECTED.get(error["type"])
    return template.format(**error.get("ctx", {})) if template else str(error["msg"])


def _known_keys(model: type[BaseModel], location: Location) -> str:
    inner: type[BaseModel] | None = model
    for part in location[:-1]:
        if isinstance(part, str) and inner is not None and part in inner.model_fields:
            inner = _model_in(inner.model_fields[part].annotation)
    fields = {} if inner is None else inner.model_fields
    keys = [key for key, field in fields.items() if not field.json_schema_extra]
    near = difflib.get_close_matches(str(location[-1]), keys, 1)
    return f"'{near[0]}'" if near else f"one of {', '.join(keys)}"


def _model_in(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((m for m in map(_model_in, get_args(annotation)) if m is not None), None)


def _child(node: Any, part: int | str) -> tuple[int, Any] | None:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if key.value == str(part):
                return key.start_mark.line, value
    if isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
        return node.value[part].start_mark.line, node.value[part]
    return None


def _given_twice(node: Any, seen: set[int]) -> Iterator[tuple[str, int, int]]:
    if id(node) in seen or not isinstance(node, yaml.CollectionNode):
        return
    seen.add(id(node))
    lines: dict[str, int] = {}
    for entry in node.value:
        children = entry if isinstance(entry, tuple) else (entry,)
        if isinstance(entry, tuple) and isinstance(entry[0], yaml.ScalarNode):
            key, line = entry[0].value, entry[0].start_mark.line + 1
            if key in lines and key != "<<":
                yield key, line, lines[key]
            lines[key] = line
        for child in children:
            yield from _given_twice(child, seen)


def _brief(value: Any) -> str:
    text = "nothing" if value is None else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
