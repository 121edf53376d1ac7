"""The run store: DATA/runs/<id>/ holds one run as a ROS 2 bag with a description beside it.

Whatever else lies there is set aside, with the reason; nothing that a file says becomes a path.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from pa10d.common.disk import of_the_disk, remedy
from pa10d.common.errors import NoRoom, Taken, UserError
from pa10d.measurement.recording import Recording
from pa10d.profile import Profile
from pa10d.store.channels import Channels
from pa10d.store.entries import SetAside
from pa10d.store.folders import NEW, discard, is_held, locked, sweep
from pa10d.store.location import folder_for
from pa10d.store.names import checked_name, free_name, resolve
from pa10d.store.room import refuse_without_room, size_of_run
from pa10d.store.run_info import BAG, FILE, KeptFinding, RunInfo, load_info, new_info
from pa10d.store.run_reader import StoredRun, read_run
from pa10d.store.run_repair import repair_run
from pa10d.store.run_writer import RunWriter


class RunStore:
    """All runs under one data folder. Opening it repairs what a killed recorder left behind."""

    def __init__(self, data: str | os.PathLike[str] | None = None) -> None:
        self.folder = folder_for("runs", data)
        self._known: dict[Path, tuple[Version, RunInfo | SetAside]] = {}
        sweep(self.folder, BAG)
        self.repaired = self.repair()
        self._part_names()

    def all(self) -> list[RunInfo]:
        """All runs, oldest first."""
        return [found for found in self._scan() if isinstance(found, RunInfo)]

    def set_aside(self) -> list[SetAside]:
        """What else lies there, each with the one line that says what is wrong with it."""
        return [found for found in self._scan() if isinstance(found, SetAside)]

    def find(self, wanted: str) -> RunInfo:
        """By id, exact name, or unique start of an id; what is set aside says so under its id."""
        try:
            return resolve(wanted, self.all(), "run")
        except UserError:
            for other in self.set_aside():
                if wanted == other.id:
                    raise UserError(other.reason) from None
            raise

    def path(self, info: RunInfo) -> Path:
        """The run's bag folder."""
        return self.folder / info.id

    def read(self, run: str | RunInfo) -> StoredRun:
        """Everything that was measured, as it was measured."""
        info = self.find(run) if isinstance(run, str) else run
        bag = self.path(info) / BAG
        if not bag.parent.exists():
            raise UserError(f"run {info.name!r} ({info.id}): it has been deleted")
        found = read_run(bag)
        if info.status != "started" and len(found.samples) != info.samples:
            raise UserError(
                f"{bag}: found {len(found.samples)} sound samples, expected {info.samples}; "
                "the file is damaged"
            )
        return found

    def recording(self, run: str | RunInfo) -> Recording:
        """With equal steps, ready for the science."""
        info = self.find(run) if isinstance(run, str) else run
        recording = self.read(info).recording(info.name)[0]
        return recording.without(info.excluded) if info.excluded else recording

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
        samples: int = 0,
    ) -> RunWriter:
        """A run that is seen from its first sample on, whatever becomes of its writer.

        With ``replace`` a run of this name stays until the new one, numbered so long, has ended
        well: then the new one takes the name, and the old one goes. samples: how many are to come;
        the disk must have room for them.
        """
        refuse_without_room(self.folder, size_of_run(channels, samples))
        info = new_info(
            checked_name(name),
            profile.name if profile else "",
            channels,
            others=os.listdir(self.folder),
            kind=kind,
            tags=tags,
        )
        new = self._new_folder(info)
        writer = RunWriter(new, info, channels, profile, plan)
        try:
            with locked(self.folder):
                there = {other.name: other for other in self.all()}
                old = there.get(name)
                if old is not None:
                    self._refuse_replacing(old, replace)
                    writer.info = info.but(name=free_name(name, there))
                    so_called = frozenset(one.id for one in self.all() if one.name == name)
                    writer.then = partial(self._take_place, old, so_called, writer.info.name)
                self._publish(writer)
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
        findings: tuple[KeptFinding, ...] | None = None,
        unit_given: tuple[int, ...] = (),
        excluded: tuple[tuple[float, float], ...] = (),
        tags: tuple[str, ...] = (),
        replace: bool = False,
        time_zero_ns: int = 0,
    ) -> Iterator[RunWriter]:
        """A run that appears when the block ends, whole, or not at all if it fails.

        Without a ``name`` it is called ``stem``, numbered where that is taken. excluded: stretches
        (begin, end) s that nothing was measured in.
        """
        if name is not None and not replace:
            self._refuse_taken(checked_name(name))
        info = new_info(
            checked_name(name or stem), profile.name if profile else "", channels,
            others=os.listdir(self.folder), source=source, warnings=warnings, findings=findings,
            unit_given=unit_given, tags=tags,
        )  # fmt: skip
        info = info.but(excluded=excluded) if excluded else info
        new = self._new_folder(info)
        try:
            writer = RunWriter(new, info, channels, profile, time_zero_ns=time_zero_ns)
            try:
                yield writer
                writer.close()
            finally:
                writer.abandon()
            with locked(self.folder):
                there = {other.name: other for other in self.all()}
                if name is None and not replace:
                    writer.info = writer.info.but(name=free_name(stem, there))
                old = there.get(writer.info.name)
                if old is not None:
                    self._refuse_replacing(old, replace)
                self._publish(writer)
                if old is not None:
                    discard(self.path(old))
        except OSError as error:
            kind = NoRoom if of_the_disk(error) else UserError
            said = [f"{self.folder}: {error.strerror}", "the run was not stored", remedy(error)]
            raise kind("; ".join(filter(None, said))) from error
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
        self,
        run: str,
        *,
        name: str | None = None,
        tags: tuple[str, ...] | None = None,
        excluded: Sequence[tuple[float, float]] | None = None,
    ) -> RunInfo:
        """Give it another name or other tags, or say which stretches no fit shall use."""
        with locked(self.folder):
            info = self.find(run)
            if name is not None and name != info.name:
                self._refuse_taken(checked_name(name))
                info = info.but(name=name)
            info = info if tags is None else info.but(tags=tags)
            info = info if excluded is None else info.but(excluded=in_order(info, excluded))
            info.save(self.path(info))
        return info

    def repair(self) -> list[RunInfo]:
        """Finish the runs whose writer is gone; they are marked as repaired and failed.

        One that cannot be helped now stays as it is: no entry keeps the store from opening.
        """
        repaired = []
        for info in self.all():
            bag = self.path(info) / BAG
            if info.status != "started" or is_held(bag):
                continue
            with contextlib.suppress(UserError, OSError), locked(self.folder):
                info = load_info(bag.parent)
                if info.status == "started" and not is_held(bag):
                    repaired.append(repair_run(bag.parent, info))
        return repaired

    def _part_names(self) -> None:
        """Where power went as a run took the place of another both have its name: the newer one
        keeps it."""
        names = [info.name for info in self.all()]
        if len(set(names)) == len(names):
            return
        with contextlib.suppress(UserError, OSError), locked(self.folder):
            there = self.all()
            taken, newest = {info.name for info in there}, {info.name: info.id for info in there}
            for info in there:
                if newest[info.name] == info.id or info.status == "started":
                    continue
                name = free_name(info.name, taken)
                taken.add(name)
                said = f"was called {info.name!r} until a newer run had that name"
                info.but(name=name, warnings=(*info.warnings, said)).save(self.path(info))

    def _scan(self) -> Iterator[RunInfo | SetAside]:
        with os.scandir(self.folder) as entries:
            names = sorted(entry.name for entry in entries if not entry.name.startswith("."))
        paths = [self.folder / name for name in names]
        for gone in self._known.keys() - set(paths):
            self._known.pop(gone, None)
        for path in paths:
            found = self._look(path)
            if found is not None:
                yield found

    def _look(self, folder: Path) -> RunInfo | SetAside | None:
        """Each version of each description is read once. None: it has just been deleted."""
        version = _version(folder / FILE)
        known = self._known.get(folder)
        if known is not None and version is not None and known[0] == version:
            return known[1]
        try:
            found: RunInfo | SetAside = load_info(folder)
        except UserError as error:
            if not os.path.lexists(folder):
                return None
            found = SetAside(folder.name, "", folder, str(error).splitlines()[0])
        if version is not None:
            self._known[folder] = version, found
        return found

    def _new_folder(self, info: RunInfo) -> Path:
        new = self.folder / f"{NEW}{info.id}"
        new.mkdir()
        return new

    def _publish(self, writer: RunWriter) -> None:
        """From now on it is seen; the lock is held."""
        info = writer.info
        info.save(writer.folder)
        writer.folder.rename(self.path(info))
        writer.folder = self.path(info)

    def _take_place(
        self, old: RunInfo, so_called: frozenset[str], numbered: str, info: RunInfo
    ) -> RunInfo:
        """What becomes of ``old`` and of the run that was to replace it, which has ended.

        so_called: ids of all that had the name as it began, more than one where power went while
        another was replaced; numbered: what the new one was called so long. Who has renamed one of
        both meanwhile wants to keep it: then both stay.
        """
        if info.status != "success":
            kept = f"run {old.name!r} was kept, and this one is called {info.name!r}"
            return info.but(reason=f"{info.reason}; {kept}" if info.reason else kept)
        try:
            with locked(self.folder):
                there = self.all()
                if any(other.name == old.name and other.id not in so_called for other in there):
                    raise UserError(f"another run took the name {old.name!r}")
                if any(other.id == info.id and other.name != numbered for other in there):
                    return info  # it has a name of its own by now
                info = info.but(name=old.name)
                info.save(self.path(info))
                if any(other.id == old.id and other.name == old.name for other in there):
                    with contextlib.suppress(FileNotFoundError):  # somebody else deleted it
                        discard(self.path(old))
        except UserError as error:
            return info.but(warnings=(*info.warnings, f"not renamed: {error}"))
        return info

    def _refuse_taken(self, name: str) -> None:
        if any(info.name == name for info in self.all()):
            raise Taken(f"run {name!r}: there is one already; expected another name or --replace")

    def _refuse_replacing(self, old: RunInfo, replace: bool) -> None:
        if not replace:
            self._refuse_taken(old.name)
        self._refuse_held(old)

    def _refuse_held(self, info: RunInfo) -> None:
        if is_held(self.path(info) / BAG):
            raise UserError(f"run {info.name!r}: it is being recorded; expected a finished run")


Version = tuple[int, int, int]


def _version(path: Path) -> Version | None:
    """Changes whenever the file does; None where there is none."""
    try:
        found = path.lstat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns, found.st_size


def in_order(
    info: RunInfo, excluded: Sequence[tuple[float, float]]
) -> tuple[tuple[float, float], ...]:
    """Stretches that overlap become one; UserError for what lies outside the run."""
    out: list[tuple[float, float]] = []
    for begin, end in sorted((float(a), float(b)) for a, b in excluded):
        if not 0 <= begin < end <= info.duration + 1e-3:
            raise UserError(
                f"run {info.name!r}: excluded {begin:g} to {end:g} s, expected a stretch within "
                f"0 to {info.duration:g} s"
            )
        if out and begin <= out[-1][1]:
            out[-1] = (out[-1][0], max(end, out[-1][1]))
        else:
            out.append((begin, end))
    return tuple(out)
