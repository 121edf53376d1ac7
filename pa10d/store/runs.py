"""The run store: DATA/runs/<id>/ holds one run as a ROS 2 bag with a description beside it."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from pa10d.errors import UserError
from pa10d.profile import Profile
from pa10d.recording import Recording
from pa10d.store.channels import Channels
from pa10d.store.folders import NEW, discard, is_held, locked, sweep
from pa10d.store.location import data_folder
from pa10d.store.names import checked_name, free_name, resolve
from pa10d.store.run_info import BAG, FILE, RunInfo, load_info, new_info
from pa10d.store.run_reader import StoredRun, read_run
from pa10d.store.run_repair import repair_run
from pa10d.store.run_writer import RunWriter


class RunStore:
    """All runs under one data folder. Opening it repairs what a killed recorder left behind."""

    def __init__(self, data: str | os.PathLike[str] | None = None) -> None:
        self.folder = data_folder(data) / "runs"
        self.folder.mkdir(exist_ok=True)
        sweep(self.folder, BAG)
        self._finish_replacements()
        self.repaired = self.repair()

    def all(self) -> list[RunInfo]:
        """All runs, oldest first; a folder that is none is passed over."""
        found = []
        for path in sorted(self.folder.glob(f"[!.]*/{FILE}")):
            with contextlib.suppress(UserError):
                found.append(load_info(path.parent))
        return found

    def find(self, wanted: str) -> RunInfo:
        """By exact name, id, or unique start of an id."""
        return resolve(wanted, self.all(), "run")

    def path(self, info: RunInfo) -> Path:
        """The run's bag folder."""
        return self.folder / info.id

    def read(self, run: str | RunInfo) -> StoredRun:
        """Everything that was measured, as it was measured."""
        info = self.find(run) if isinstance(run, str) else run
        return read_run(self.path(info) / BAG)

    def recording(self, run: str | RunInfo) -> Recording:
        """With equal steps, ready for the science."""
        info = self.find(run) if isinstance(run, str) else run
        return self.read(info).recording(info.name)[0]

    def start(
        self,
        name: str,
        channels: Channels,
        profile: Profile | None = None,
        *,
        plan: str = "",
        kind: str = "",
        tags: tuple[str, ...] = (),
        replace: bool = False,
    ) -> RunWriter:
        """A run that is seen from its first sample on, whatever becomes of its writer."""
        info = new_info(
            checked_name(name),
            profile.name if profile else "",
            channels,
            kind=kind,
            tags=tags,
        )
        new = self._new_folder(info)
        writer = RunWriter(new, info, channels, profile, plan)
        try:
            self._publish(writer, replace)
        except BaseException:
            writer.abandon()
            discard(new)
            raise
        return writer

    @contextlib.contextmanager
    def building(
        self,
        name: str | None,
        stem: str,
        channels: Channels,
        profile: Profile | None = None,
        *,
        source: str = "",
        warnings: tuple[str, ...] = (),
        tags: tuple[str, ...] = (),
        replace: bool = False,
        time_zero_ns: int = 0,
    ) -> Iterator[RunWriter]:
        """A run that appears when the block ends, whole, or not at all if it fails.

        Without a ``name`` it is called ``stem``, numbered where that is taken.
        """
        if name is not None and not replace:
            self._refuse_taken(checked_name(name))
        info = new_info(
            checked_name(name or stem), profile.name if profile else "", channels,
            source=source, warnings=warnings, tags=tags,
        )  # fmt: skip
        new = self._new_folder(info)
        try:
            writer = RunWriter(new, info, channels, profile, time_zero_ns=time_zero_ns)
            try:
                yield writer
                writer.close()
            finally:
                writer.abandon()
            self._publish(writer, replace, numbered=name is None)
        except OSError as error:
            raise UserError(f"{self.folder}: {error.strerror}; the run was not stored") from error
        finally:
            if new.exists():
                discard(new)

    def delete(self, run: str) -> RunInfo:
        """Remove a run that nobody is recording."""
        with locked(self.folder):
            info = self.find(run)
            self._refuse_held(info)
            discard(self.path(info))
        return info

    def change(
        self, run: str, *, name: str | None = None, tags: tuple[str, ...] | None = None
    ) -> RunInfo:
        """Give it another name or other tags."""
        with locked(self.folder):
            info = self.find(run)
            if name is not None and name != info.name:
                self._refuse_taken(checked_name(name))
                info = info.but(name=name)
            info = info if tags is None else info.but(tags=tags)
            info.save(self.path(info))
        return info

    def repair(self) -> list[RunInfo]:
        """Finish the runs whose writer is gone; they are marked as repaired and failed."""
        repaired = []
        for info in self.all():
            bag = self.path(info) / BAG
            if info.status != "started" or is_held(bag):
                continue
            with locked(self.folder), contextlib.suppress(FileNotFoundError):
                info = load_info(bag.parent)
                if info.status == "started":
                    repaired.append(repair_run(bag.parent, info))
        return repaired

    def _new_folder(self, info: RunInfo) -> Path:
        new = self.folder / f"{NEW}{info.id}"
        new.mkdir()
        return new

    def _publish(self, writer: RunWriter, replace: bool, numbered: bool = False) -> None:
        with locked(self.folder):
            info = writer.info
            there = {other.name: other for other in self.all()}
            if numbered and not replace:
                info = info.but(name=free_name(info.name, there))
            old = there.get(info.name)
            if old is not None and not replace:
                self._refuse_taken(info.name)
            if old is not None:
                self._refuse_held(old)
                info = info.but(replaces=old.id)
            info.save(writer.folder)
            writer.folder.rename(self.path(info))
            writer.folder, writer.info = self.path(info), info
            if old is not None:
                discard(self.path(old))

    def _refuse_taken(self, name: str) -> None:
        if any(info.name == name for info in self.all()):
            raise UserError(
                f"run {name!r}: there is one already; expected another name or --replace"
            )

    def _refuse_held(self, info: RunInfo) -> None:
        if is_held(self.path(info) / BAG):
            raise UserError(f"run {info.name!r}: it is being recorded; expected a finished run")

    def _finish_replacements(self) -> None:
        """A run that was to give way goes, had the process been killed in between."""
        for info in self.all():
            old = self.folder / info.replaces
            if info.replaces and old.is_dir():
                discard(old)
