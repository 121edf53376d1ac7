"""Profiles edited as text: values change where they stand, all else stays as it was written."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from pa10d.common.disk import writing
from pa10d.common.errors import UserError
from pa10d.common.yamlfile import YamlFile, read_yaml
from pa10d.dynamics import Robot
from pa10d.profile import Profile
from pa10d.profile.load import profile_folders
from pa10d.services.robots import load_robot
from pa10d.store.yaml_style import Dumper


class _Edit(NamedTuple):
    """What stands in the characters begin … end from now on."""

    begin: int
    end: int
    text: str


def not_to_be_written(path: Path) -> bool:
    """Whether a profile came with the package, or belongs to somebody else."""
    return path.parent in profile_folders() or not os.access(path, os.W_OK)


def rewritten(file: YamlFile, data: Mapping[str, Any]) -> str:
    """The text of a YAML file with other values: those of ``data``, which may have further keys
    but must have all that the file has. Comments, order and spelling of everything else stay."""
    edits = sorted(_section(file.text, file.root, file.data, data), reverse=True)
    text = file.text
    for edit in edits:
        text = text[: edit.begin] + edit.text + text[edit.end :]
    return text


def put_profile(path: Path, text: str, data: Mapping[str, Any] | None = None) -> None:
    """Write a profile in one step, once it was loaded as every command loads it.

    data: what must be read from it. UserError, and an untouched file, where something is wrong.
    """
    with _draft(path, text, data) as (draft, _):
        os.replace(draft, path)


def as_if_written(
    path: Path, text: str, data: Mapping[str, Any] | None = None
) -> tuple[Profile, Robot]:
    """What would be loaded from ``path`` once this text stood there; refused as if it did."""
    with _draft(path, text, data) as (_, (profile, robot)):
        return profile.model_copy(update={"path": path}), robot


@contextlib.contextmanager
def beside(path: Path, text: str) -> Iterator[Path]:
    """A file of the caller's own with this text, in the same folder: what ``path`` names relative
    to itself is found from there, too."""
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}.new.yaml")
    try:
        with writing(path), draft.open("xb") as file:
            file.write(text.encode())
            file.flush()
            os.fsync(file.fileno())
        yield draft
    finally:
        draft.unlink(missing_ok=True)


@contextlib.contextmanager
def _draft(
    path: Path, text: str, data: Mapping[str, Any] | None
) -> Iterator[tuple[Path, tuple[Profile, Robot]]]:
    with beside(path, text) as draft:
        try:
            if data is not None and read_yaml(draft).data != data:
                raise UserError(f"{path}: it cannot be edited safely; expected an edit by hand")
            yield draft, load_robot(draft)
        except UserError as error:
            raise UserError(str(error).replace(str(draft), str(path))) from error


def _section(
    text: str, node: yaml.MappingNode, old: Mapping[str, Any], new: Mapping[str, Any]
) -> Iterator[_Edit]:
    nodes = {key.value: value for key, value in node.value}
    for key, value in new.items():
        if key in old and old[key] != value:
            yield from _value(text, nodes[key], old[key], value)
    added = {key: value for key, value in new.items() if key not in old}
    if added:
        yield _added(text, node, added)


def _value(text: str, node: yaml.Node, old: Any, new: Any) -> Iterator[_Edit]:
    """Only what differs, so that the comment beside an entry of a list stays."""
    if isinstance(node, yaml.MappingNode) and isinstance(new, dict) and old.keys() <= new.keys():
        yield from _section(text, node, old, new)
    elif isinstance(node, yaml.SequenceNode) and isinstance(new, list) and len(old) == len(new):
        for child, before, after in zip(node.value, old, new, strict=True):
            if before != after:
                yield from _value(text, child, before, after)
    else:
        begin, end = node.start_mark.index, _end(node)
        block = isinstance(node, yaml.CollectionNode) and not node.flow_style
        gap = "  " if block else " " if begin == end else ""  # a block may begin below its key
        yield _Edit(begin, end, gap + _flow(new))


def _added(text: str, node: yaml.MappingNode, added: Mapping[str, Any]) -> _Edit:
    if node.flow_style:
        pairs = ", ".join(f"{key}: {_flow(value)}" for key, value in added.items())
        end = _end(node.value[-1][1]) if node.value else node.start_mark.index + 1
        return _Edit(end, end, f", {pairs}" if node.value else pairs)
    indent = " " * node.value[0][0].start_mark.column
    lines = [line for key, value in added.items() for line in _lines(key, value, indent)]
    if not indent:  # behind what stands at the end of the file, too
        gap = "" if text.endswith("\n") else "\n"
        return _Edit(len(text), len(text), gap + "".join(f"{line}\n" for line in lines))
    last = _end(node.value[-1][1])
    end = text.find("\n", last)
    end = len(text) if end < 0 else end
    return _Edit(end, end, "".join(f"\n{line}" for line in lines))


def _lines(key: str, value: Any, indent: str) -> list[str]:
    if isinstance(value, dict) and value:
        inner = [line for k, v in value.items() for line in _lines(k, v, indent + "  ")]
        return [f"{indent}{key}:", *inner]
    return [f"{indent}{key}: {_flow(value)}"]


def _end(node: yaml.Node) -> int:
    """Where its text ends: the mark of a block's end is where the next one begins."""
    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _end(last[1] if isinstance(last, tuple) else last)
    return int(node.end_mark.index)


def _flow(value: Any) -> str:
    text = yaml.dump(
        value, Dumper=Dumper, default_flow_style=True, width=1_000_000, allow_unicode=True,
        sort_keys=False,
    )  # fmt: skip
    return str(text).removesuffix("\n").removesuffix("\n...")
