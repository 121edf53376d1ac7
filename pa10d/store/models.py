"""The model store: DATA/models/<id>.yaml, one file a model. Nothing is ever overwritten."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path

import yaml
from pydantic import ValidationError

from pa10d.common.errors import Taken, UserError
from pa10d.common.yamlfile import BROKEN, LARGEST, refuse_traps
from pa10d.model import TorqueModel
from pa10d.store.entries import SetAside, explained, read_entry
from pa10d.store.folders import locked, write_text
from pa10d.store.location import folder_for
from pa10d.store.model_info import ModelInfo
from pa10d.store.model_parse import info_of, read_model
from pa10d.store.model_schema import ModelFile
from pa10d.store.model_text import model_text
from pa10d.store.names import checked_name, new_id, resolve

_FastLoader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class ModelStore:
    """All models under one data folder. A file put there by hand is a model too."""

    def __init__(self, data: str | os.PathLike[str] | None = None) -> None:
        self.folder = folder_for("models", data)
        self._known: dict[Path, tuple[tuple[int, int, int], ModelInfo | SetAside]] = {}

    def all(self) -> list[ModelInfo]:
        """All models, oldest first; those whose name a later one took are marked."""
        infos = sorted(self._scan(ModelInfo), key=lambda info: info.id)
        latest = {info.name: info.id for info in infos}
        return [info.but(replaced=latest[info.name] != info.id) for info in infos]

    def set_aside(self) -> list[SetAside]:
        """Files that cannot be read, each with the one line that says why."""
        return list(self._scan(SetAside))

    def find(self, wanted: str) -> ModelInfo:
        """By id, exact name, or unique start of an id; a broken file says so under its name."""
        broken = self.set_aside()
        for bad in broken:
            if wanted in (bad.name, bad.id) and not self._readable(wanted):
                raise UserError(bad.reason)
        try:
            return resolve(wanted, self.all(), "model")
        except UserError as error:
            nameless = [bad.reason for bad in broken if not bad.name]
            if not nameless:
                raise
            raise UserError(
                f"{error}; it may be in a file that is damaged: {nameless[0]}"
            ) from None

    def path(self, info: ModelInfo) -> Path:
        """The model's file."""
        for path in self._files():
            known = self._look(path)
            if isinstance(known, ModelInfo) and known.id == info.id:
                return path
        raise UserError(f"model {info.name!r} ({info.id}): its file is gone")

    def load(self, model: str | ModelInfo) -> TorqueModel:
        """The model itself; its ``parent`` is the parent's id."""
        info = self.find(model) if isinstance(model, str) else model
        return read_model(self.path(info))[0]

    def refuse_taken(self, name: str) -> None:
        """Before a long computation: is the name allowed and free?"""
        checked_name(name)
        if self._readable(name):
            raise Taken(f"model {name!r}: there is one already; expected another name or --replace")

    def save(self, model: TorqueModel, *, replace: bool = False) -> ModelInfo:
        """Store it under a new id. Where ``replace``, a model of the same name stays under its id
        and the name now means this one. ``model.parent``: name or id of a stored model."""
        checked_name(model.name)
        with locked(self.folder):
            if not replace:
                self.refuse_taken(model.name)
            parent = None if model.parent is None else self.find(model.parent)
            info = new_info(model, parent, os.listdir(self.folder))
            text = model_text(model, info)
            _refuse_unreadable(text, model.name)
            write_text(self.folder / f"{info.id}.yaml", text)
        return info

    def delete(self, model: str) -> ModelInfo:
        """Remove the last version of a line: what others were made from stays."""
        with locked(self.folder):
            info = self.find(model)
            later = [other.name for other in self.all() if other.parent == info.id]
            if later:
                raise UserError(
                    f"model {info.name!r}: {', '.join(later)} was made from it; expected the last "
                    "version of a line"
                )
            self.path(info).unlink()
        return info

    def history(self, model: str | ModelInfo) -> list[ModelInfo]:
        """The model and all it was made from, the first ancestor first."""
        info = self.find(model) if isinstance(model, str) else model
        return _line(info, {other.id: other for other in self.all()})

    def family(self, model: str | ModelInfo) -> list[ModelInfo]:
        """The model and all that come from the same first ancestor, oldest first."""
        infos = self.all()
        by_id = {other.id: other for other in infos}
        first = self.history(model)[0]
        return [other for other in infos if _line(other, by_id)[0].id == first.id]

    def _readable(self, wanted: str) -> bool:
        return any(wanted in (info.name, info.id) for info in self.all())

    def _files(self) -> list[Path]:
        return sorted(self.folder.glob("[!.]*.yaml"))

    def _scan(self, kind: type) -> Iterator:
        return (known for path in self._files() if isinstance(known := self._look(path), kind))

    def _look(self, path: Path) -> ModelInfo | SetAside:
        """Read each version of each file once."""
        try:
            stat = path.lstat()
        except OSError as error:
            return SetAside(path.stem, "", path, f"{path}: {error.strerror}")
        version = (stat.st_ino, stat.st_mtime_ns, stat.st_size)
        known = self._known.get(path)
        if known is None or known[0] != version:
            known = self._known[path] = version, _quick_info(path) or _careful_info(path)
        return known[1]


def _line(info: ModelInfo, by_id: Mapping[str, ModelInfo]) -> list[ModelInfo]:
    """The model and all it was made from, as far as they are known, the first ancestor first."""
    line, parent = [info], info.parent
    while parent is not None and parent in by_id and by_id[parent] not in line:
        line.append(by_id[parent])
        parent = line[-1].parent
    return line[::-1]


def _quick_info(path: Path) -> ModelInfo | None:
    """None where anything is unusual: then the slow reader with the good messages looks."""
    try:
        content = read_entry(path, LARGEST)
        refuse_traps(content)
        data = yaml.load(content, Loader=_FastLoader)
        return info_of(ModelFile.model_validate(data))
    except (UserError, ValidationError, *BROKEN):
        return None


def _refuse_unreadable(text: str, name: str) -> None:
    """A file that could not be read back is not written."""
    try:
        ModelFile.model_validate(yaml.load(text, Loader=_FastLoader))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise UserError(
            f"model {name!r}: {where}: found {first['input']!r}, expected what can be stored "
            f"({first['msg']})"
        ) from error


def _careful_info(path: Path) -> ModelInfo | SetAside:
    """Whatever is wrong with a file, it is set aside and all others go on."""
    name = ""
    try:
        text = read_entry(path, LARGEST).decode("utf-8", "replace")
        found = re.search(r"^name:\s*['\"]?(.*?)['\"]?\s*$", text, re.MULTILINE)
        name = found.group(1) if found else ""
        return read_model(path)[1]
    except UserError as error:
        return SetAside(path.stem, name, path, str(error).splitlines()[0])
    except Exception as error:  # nothing that a file holds may end the listing of the others
        return SetAside(path.stem, name, path, f"{path}: {explained(error)}; expected a model")


def new_info(model: TorqueModel, parent: ModelInfo | None, others: Iterable[str] = ()) -> ModelInfo:
    """What a file says of a model that is written now, after the others (their ids)."""
    now = datetime.now(UTC)
    return ModelInfo(
        id=new_id(others),
        name=model.name,
        created=now.isoformat(timespec="milliseconds"),
        robot=model.robot.name,
        joints=model.robot.joint_names,
        change=model.change,
        effects=tuple(term.label for term in model.terms),
        runs=model.runs,
        cutoff_hz=model.cutoff,
        feasible=model.feasible,
        rms=tuple(float(v) for v in model.noise),
        held_out={run: tuple(map(float, values)) for run, values in model.held_out.items()},
        noise_floor=model.notes.noise_floor,
        parent=parent.id if parent else None,
        parent_name=parent.name if parent else None,
    )
