"""A profile's tuning: what is in force, what a change would do, writing, undoing."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.words import from_one, joint_words, listed
from pa10d.common.yamlfile import YamlFile, read_yaml
from pa10d.profile.load import profile_folders
from pa10d.services.joints import keep_for
from pa10d.services.profile_file import as_if_written, beside, not_to_be_written, rewritten
from pa10d.services.robots import load_robot
from pa10d.services.tuning.arm import Tuned
from pa10d.services.tuning.by_hand import why_not_tuned
from pa10d.services.tuning.doubts import loosened
from pa10d.services.tuning.keys import (
    KEYS,
    OTHERS,
    Key,
    TuningGroup,
    TuningKey,
    UndoneKey,
    known_key,
    value_at,
    with_value,
)
from pa10d.services.tuning.told import (
    ProfileDifference,
    ProfileTuning,
    ProfileVersion,
    TuningBound,
    TuningDifference,
    TuningValue,
)
from pa10d.services.tuning.versions import (
    coming,
    digest,
    folder_of,
    own_profile,
    standing,
    take_back,
    versions_in,
    where_written,
    write_version,
)
from pa10d.store.folders import locked

Data = str | os.PathLike[str] | None
SAME = 1e-9  # of a value
CONTROL = (
    "gains, limits and bounds hold once control has started anew, which a daemon does at once: the "
    "arm must be unpowered"
)
AT_REST = {  # what holds without control being started anew, by groups of keys
    "environment": "the surroundings hold from the next pre-check on",
    "imports": "the mapping holds from the next import on",
}


def show(data: Data, profile: str) -> ProfileTuning:
    """Every value in force, with what the file says of it, its source and its bounds."""
    path = own_profile(data, profile)
    found, robot = load_robot(path)
    tuned = Tuned.of(data, found, robot)
    written = {} if path.suffix == ".urdf" else read_yaml(path).data
    return ProfileTuning(
        file=str(path),
        name=found.name,
        joints=list(robot.joint_names),
        refusal=_refusal(path),
        version=standing(folder_of(data, path), where_written(data, path)),
        values=[_value(key, tuned, value_at(written, key)) for key in KEYS.values()],
    )


def propose(data: Data, profile: str, changes: Mapping[str, Any]) -> ProfileDifference:
    """What a change would do.

    changes: by the names of keys; a value, null for none, or for some joints ``{joint: value}``.
    UserError with a line for each bad value. Nothing is written.
    """
    edit = _Edit(data, own_profile(data, profile))
    edit.change(changes)
    return edit.told(coming(folder_of(data, edit.path)))


def write(
    data: Data, profile: str, changes: Mapping[str, Any], confirmed: bool = False
) -> ProfileDifference:
    """Make the change; the version before is kept. A shipped profile is copied into the data
    folder first. UserError where something is to be confirmed and was not."""
    path = own_profile(data, profile)
    folder = folder_of(data, path)
    with locked(folder):
        edit = _Edit(data, path)
        edit.change(changes)
        found = edit.told(coming(folder))
        _refuse_unconfirmed(found.confirm, confirmed)
        edit.carry_on()
        write_version(folder, edit.sentences(), edit.path, edit.before_text, edit.text, edit.data)
        return replace(found, written=True)


def undo(
    data: Data, profile: str, confirmed: bool = False, check: bool = False
) -> ProfileDifference:
    """Take back the last change that was not; check: only say what that would do.

    UserError where there is none, where the file was edited by hand since, or where something is to
    be confirmed and was not.
    """
    path = own_profile(data, profile)
    folder, file = folder_of(data, path), where_written(data, path)
    with locked(folder):
        known = versions_in(folder, file)
        last = next((one for one in reversed(known) if not one.undone), None)
        lost = [one for one in known if one.damaged and (last is None or one.number > last.number)]
        if last is None and not lost:
            raise UserError(f"{path}: nothing to undo: no version of it was written here")
        edit = _Edit(data, path)
        if last is None or (lost and digest(edit.before_text) != last.after):
            raise UserError(
                f"{path}: version {lost[-1].made} {lost[-1].changes[0]}; expected an edit by hand"
            )
        if digest(edit.before_text) != last.after:
            raise UserError(
                f"{path}: edited by hand since it was written here ({last.when}); undo would lose "
                "that, expected an edit by hand"
            )
        edit.become(last.before)
        found = edit.told(standing(folder, file, without=last.number))
        if check:
            return found
        _refuse_unconfirmed(found.confirm, confirmed)
        edit.carry_on()
        take_back(folder, last, path)
        return replace(found, written=True)


def versions(data: Data, profile: str) -> list[ProfileVersion]:
    """Every edit, newest first: the version that it made, when, what, and whether it was
    undone."""
    path = own_profile(data, profile)
    return [
        ProfileVersion(one.made, one.when, one.changes, one.undone)
        for one in reversed(versions_in(folder_of(data, path), where_written(data, path)))
    ]


class _Edit:
    """The file as it is and as it would be; ``path``: where it will be written."""

    def __init__(self, data: Data, path: Path) -> None:
        file = editable(data, path)
        self._store, self.path = data, file.path
        self.file, self.before_text = file, file.text
        self.data, self.text = file.data, file.text
        profile, robot = as_if_written(self.path, self.text)
        self.before = self.after = Tuned.of(data, profile, robot)
        self.changed: set[UndoneKey] = set()
        self.fixed: list[tuple[Key, list[int]]] = []  # joints (0-based) that others' change states
        self.rescaled = False

    def change(self, changes: Mapping[str, Any]) -> None:
        """Those values instead of the file's."""
        data = self.data
        for name, value in changes.items():
            key = known_key(name)
            _refuse_no_number(name, value)
            data = with_value(data, key.place, self._whole(key, value))
            self.changed.add(key.name)
        self._load(rewritten(self.file, data), data)

    def become(self, text: str) -> None:
        """Another text instead of the file's."""
        self._load(text, None)

    def _load(self, text: str, data: JsonObject | None) -> None:
        profile, robot = as_if_written(self.path, text, data)
        self.text, self.data = text, data or self.data
        self.rescaled = profile.drives != self.before.profile.drives
        self.after = (  # figures that were measured in another scale of torques do not hold
            Tuned.of(self._store, profile, robot)
            if self.rescaled
            else self.before.with_profile(profile, robot)
        )

    def _whole(self, key: Key, value: Any) -> Any:
        """A list for every joint of what was said of some."""
        if not isinstance(value, Mapping):
            self._refuse_wrong_length(key, value)
            return value
        n, shown = self.before.robot.n, _plain(self.before.in_force(key.name))
        if not key.per_joint:
            raise UserError(f"{key.name}: found {dict(value)!r}, expected one value")
        for joint, one in value.items():
            number = int(joint) if str(joint).isdecimal() else 0
            if not 1 <= number <= n:
                raise UserError(f"{key.name}: found joint {joint!r}, expected {from_one(n)}")
            shown[number - 1] = one
        given = {int(joint) for joint in value}
        if value_at(self.data, key) is None:
            self.fixed.append((key, [j for j in range(n) if j + 1 not in given]))
        left = [(j, one) for j, one in enumerate(shown, 1) if j not in given]
        if missing := [str(j) for j, one in left if one is None or one == [None, None]]:
            raise UserError(
                f"{key.name}: found no joint {listed(missing)}, where no value is in force; "
                "expected one, too"
            )
        return shown

    def _refuse_wrong_length(self, key: Key, value: Any) -> None:
        n = self.before.robot.n
        if key.per_joint and isinstance(value, list) and len(value) != n:
            raise UserError(f"{key.name}: found {len(value)} entries, expected {n}, one per joint")

    def sentences(self) -> list[str]:
        """What was asked for, one line each, without what follows from it."""
        told = [one for one in self._differences() if one.asked]
        stated = self.changed - {one.key for one in told}
        same = [f"{KEYS[name].title}: stated as it was in force" for name in sorted(stated)]
        return [*(one.sentence for one in told), *same]

    def told(self, version: int) -> ProfileDifference:
        """What it does, as ``propose`` says it."""
        diff = self._differences()
        if not diff and self.text == self.before_text:
            raise UserError(f"{self.path}: nothing to change: these values are in force already")
        if (why := why_not_tuned(self.before, self.after)) is not None:
            raise UserError(f"{self.path}: {why}")
        groups = {(KEYS | OTHERS)[one.key].group for one in diff}
        restart = self.rescaled or bool(groups - AT_REST.keys())
        at_rest = [says for group, says in AT_REST.items() if group in groups]
        return ProfileDifference(
            file=str(self.path),
            version=version,
            diff=diff,
            confirm=loosened(self.before, self.after),
            effect=[*self._fixed_words(), *([CONTROL] if restart else []), *at_rest],
            restart=restart,
            written=False,
        )

    def _fixed_words(self) -> list[str]:
        """Of some joints alone nothing can be said: a list has a value for each of them."""
        follows = {"measured": "what is measured, nor the bandwidth", "rule": "the bandwidth"}
        return [
            f"{key.title} of {joint_words(joints)} is stated, too, as it is in force: from "
            f"now on it does not follow {follows[source]}"
            for key, joints in self.fixed
            if joints and (source := self.before.source(key.name, None)) in follows
        ]

    def carry_on(self) -> None:
        """What was measured of the joints holds for the same arm tuned otherwise. Written before
        the profile is: a disk that is full then refuses the change, not half of it."""
        if self.after.measured is not None and not self.rescaled:
            keep_for(self._store, self.after.profile, self.after.measured)

    def _differences(self) -> list[TuningDifference]:
        found = []
        for key in (KEYS | OTHERS).values():
            asked = key.name in self.changed or (not self.changed and self._edited(key))
            old, new = (_plain(one.in_force(key.name)) for one in (self.before, self.after))
            units = key.units(self.after.robot)
            pairs = zip(old, new, strict=True) if key.per_joint else [(old, new)]
            found += [
                _difference(key, units[j], asked, j + 1 if key.per_joint else None, was, now)
                for j, (was, now) in enumerate(pairs)
                if not _same(was, now)
            ]
        return found

    def _edited(self, key: Key) -> bool:
        """Whether an undo gives the file another value."""
        if key.name in OTHERS:
            return True
        old, new = (one.profile.model_dump(mode="json") for one in (self.before, self.after))
        return bool(value_at(old, key) != value_at(new, key))


def editable(data: Data, path: Path) -> YamlFile:
    """What an edit starts from: the profile, or of a shipped one a copy in the data folder, which
    is not written yet. UserError where it is not ours to write."""
    if (refusal := _refusal(path)) is not None:
        raise UserError(refusal)
    target = where_written(data, path)
    if target == path:
        return read_yaml(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    return _copied(read_yaml(path), target)


def _copied(file: YamlFile, path: Path) -> YamlFile:
    """A shipped profile as a copy elsewhere: what it names beside itself by its whole path."""
    home = file.path.parent
    data: JsonObject = {**file.data, "urdf": str((home / file.data["urdf"]).resolve())}
    if data.get("drives"):
        data["drives"] = [
            {**one, "eds": str((home / one["eds"]).resolve())} if one.get("eds") else one
            for one in data["drives"]
        ]
    text = f"# A copy of {file.path.name}, which is shipped, tuned here.\n{rewritten(file, data)}"
    with beside(path, text) as draft:
        return replace(read_yaml(draft), path=path)


def _refusal(path: Path) -> str | None:
    """Why a profile cannot be tuned."""
    if path.suffix == ".urdf":
        made = f"'pa10d profile new {path.name}' makes a profile that can"
        return f"{path.name}: a URDF cannot be tuned; {made}"
    if not_to_be_written(path) and path.parent not in profile_folders():
        return f"{path}: not yours to write; expected a copy of your own, named by --profile"
    return None


def _refuse_unconfirmed(sentences: list[str], confirmed: bool) -> None:
    if sentences and not confirmed:
        raise UserError("to be confirmed: " + "; ".join(sentences))


def _value(key: Key, tuned: Tuned, written: Any) -> TuningValue:
    force = _plain(tuned.in_force(key.name))
    return TuningValue(
        key=cast(TuningKey, key.name),  # of KEYS
        group=cast(TuningGroup, key.group),
        title=key.title,
        per_joint=key.per_joint,
        units=key.units(tuned.robot),
        none=key.none,
        written=written,
        in_force=force,
        source=tuned.source(key.name, written),
        bounds=[
            TuningBound(words.rstrip(","), _plain(most)) for words, most in tuned.bounds(key.name)
        ],
    )


def _refuse_no_number(name: str, value: Any) -> None:
    """NaN says nothing, wherever in a value it stands; YAML's infinity is no value of a profile."""
    if isinstance(value, float) and not np.isfinite(value):
        raise UserError(f"{name}: found {value}, expected a finite number")
    named = value if isinstance(value, Mapping) else {}
    counted = enumerate(value, 1) if isinstance(value, list | tuple) else ()
    for which, part in [*named.items(), *counted]:
        _refuse_no_number(f"{name}.{which}", part)


def _plain(value: Any) -> Any:
    """Numbers as people write them; null for what is infinite."""
    if isinstance(value, np.ndarray):
        return [_plain(one) for one in value.tolist()]
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, float):
        if not np.isfinite(value):
            return None
        short = float(f"{value:.10g}")
        return int(short) if short.is_integer() and abs(short) < 1e15 else short
    return value


def _same(old: Any, new: Any) -> bool:
    if isinstance(old, int | float) and isinstance(new, int | float):
        return abs(old - new) <= SAME * max(abs(old), abs(new))
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        return all(_same(a, b) for a, b in zip(old, new, strict=True))
    return bool(old == new)


def _difference(
    key: Key, unit: str, asked: bool, joint: int | None, old: Any, new: Any
) -> TuningDifference:
    where = "" if joint is None else f" of joint {joint}"
    sentence = f"{key.title}{where}: {_shown(old, unit)} → {_shown(new, unit)}"
    return TuningDifference(key.name, key.title, unit, joint, asked, old, new, sentence)


def _shown(value: Any, unit: str) -> str:
    if isinstance(value, int | float):
        return f"{value:.6g} {unit}".rstrip()
    if not isinstance(value, list):
        return "none" if value is None else str(value)
    if not value or value == [None, None]:
        return "none"
    if isinstance(value[0], str):
        return " ".join(value)
    if isinstance(value[0], dict):
        return "; ".join(_box(one) for one in value)
    low, high = ("none" if one is None else f"{one:.6g}" for one in value)
    return f"{low} to {high} {unit}"


def _box(box: Any) -> str:
    sizes = " × ".join(f"{one:g}" for one in box["size"])
    place = ", ".join(f"{one:g}" for one in box["xyz"])
    return f"{box.get('name', 'box')} {sizes} m at {place}"
