"""A model file read back: everything that may be wrong with it is one line."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.yamlfile import YamlFile, read_yaml, validate
from pa10d.dynamics import BaseParameters, Robot, robot_from_urdf
from pa10d.dynamics.base import parameter_name
from pa10d.effects import Effect, ShapeParameter, all_effects, effect
from pa10d.effects.smooth_map import SmoothMap
from pa10d.effects.variables import at_joint
from pa10d.measurement.torque_filter import TorqueFilter
from pa10d.model import Term, TorqueModel, label
from pa10d.model.notes import FeasibleNote, TorqueEndNote
from pa10d.store.model_info import ModelInfo
from pa10d.store.model_schema import MOST, WIDEST, EffectEntry, ModelFile

Array = NDArray[np.float64]


def read_model(path: Path) -> tuple[TorqueModel, ModelInfo]:
    """The model in a file and what is known of it; UserError names file, line and key."""
    try:
        file = read_yaml(path)
        entry = validate(ModelFile, file, file.data)
        return _Parser(file, entry).model(), info_of(entry)
    except UserError as error:
        lines = str(error).splitlines()
        first, *others = sorted(lines, key=lambda line: "an unknown key" not in line)
        raise UserError(first + (f" (and {len(others)} more)" if others else "")) from error


def info_of(entry: ModelFile) -> ModelInfo:
    """Without looking at the parameters."""
    return ModelInfo(
        id=entry.id,
        name=entry.name,
        created=entry.created,
        robot=entry.robot.name,
        joints=tuple(entry.robot.joints),
        change=entry.change,
        effects=tuple(label(e.effect, e.joints, e.over) for e in entry.effects),
        runs=tuple(entry.fit.runs),
        cutoff_hz=entry.fit.cutoff_hz,
        feasible=entry.fit.feasible,
        rms=tuple(entry.fit.rms),
        held_out={run: tuple(values) for run, values in entry.held_out.items()},
        noise_floor=None if entry.noise_floor is None else tuple(entry.noise_floor),
        parent=entry.parent,
        parent_name=entry.parent_name,
        software=entry.software,
    )


class _Parser:
    """Turns the entries of a valid file into arrays, and says where they do not fit together."""

    def __init__(self, file: YamlFile, entry: ModelFile) -> None:
        self._file = file
        self._entry = entry
        self._n = len(entry.robot.joints)

    def model(self) -> TorqueModel:
        entry, fit = self._entry, self._entry.fit
        passed = fit.torque_filter
        self._feasible(entry.notes.feasible)
        self._torque_ends(entry.notes.torque_ends)
        robot = self._robot()
        base = self._base()
        terms = tuple(self._term(k, e) for k, e in enumerate(entry.effects))
        size = len(base) + sum(len(term.coefficients) for term in terms)
        floor = None if entry.noise_floor is None else tuple(entry.noise_floor)
        return TorqueModel(
            name=entry.name,
            robot=robot,
            base=base,
            h=np.array([parameter.value for parameter in entry.base_parameters]),
            loads=self._loads(),
            terms=terms,
            covariance=self._covariance(size),
            noise=self._per_joint(("fit", "rms"), fit.rms),
            cutoff=fit.cutoff_hz,
            shift=fit.shift_s,
            channel=None if passed is None else TorqueFilter(passed.kind, passed.seconds),
            standard=self._standard(),
            feasible=fit.feasible,
            parent=entry.parent,
            change=entry.change,
            runs=tuple(fit.runs),
            held_out={
                run: self._per_joint(("held_out", run), values)
                for run, values in entry.held_out.items()
            },
            notes=replace(entry.notes, noise_floor=floor),
        )

    def _loads(self) -> Array | None:
        found = [parameter.in_loads for parameter in self._entry.base_parameters]
        if all(value is None for value in found):
            return None
        for i, value in enumerate(found):
            if value is None:
                self._fail(("base_parameters", i, "in_loads"), "nothing", "a value, as others have")
        return np.array(found, dtype=float)

    def _robot(self) -> Robot:
        entry = self._entry.robot
        try:
            robot = robot_from_urdf(
                self._entry.urdf, entry.joints, np.array(entry.gravity), entry.name
            )
        except UserError as error:
            raise UserError(f"{self._file.path}: urdf: {error}") from error
        limits = {
            key: self._per_joint(("robot", "limits", key), values) for key, values in entry.limits
        }
        robot = replace(
            robot,
            lower=limits["lower"],
            upper=limits["upper"],
            velocity=limits["velocity"],
            effort=limits["effort"],
            acceleration=limits["acceleration"],
        )
        if entry.torque_gain_error is not None:
            shares = self._per_joint(("robot", "torque_gain_error"), entry.torque_gain_error)
            robot = replace(robot, gain_error=shares)
        if entry.tool is not None:
            parameters = robot.parameters.copy()
            parameters[-1] += self._sized(("robot", "tool"), entry.tool, 10, "standard parameters")
            robot = replace(robot, parameters=parameters)
        if self._entry.noise_floor is not None:
            self._per_joint(("noise_floor",), self._entry.noise_floor)
        return robot

    def _base(self) -> BaseParameters:
        index = {parameter_name(k): k for k in range(10 * self._n)}
        entries = self._entry.base_parameters
        kept = [
            self._known(("base_parameters", i, "name"), entry.name, index, "standard parameter")
            for i, entry in enumerate(entries)
        ]
        for i, k in enumerate(kept):
            if k in kept[:i]:
                self._fail(("base_parameters", i, "name"), entries[i].name, "each name once")
        dropped = np.setdiff1d(np.arange(10 * self._n), kept)
        relations = np.zeros((len(kept), len(dropped)))
        for i, entry in enumerate(entries):
            for name, factor in entry.plus.items():
                where = ("base_parameters", i, "plus", name)
                k = self._known(where, name, index, "standard parameter")
                if k in kept:
                    self._fail(where, name, "a parameter that is none of the base itself")
                relations[i, np.searchsorted(dropped, k)] = factor
        low, high = self._entry.structure
        return BaseParameters(np.array(kept, dtype=np.int64), dropped, relations, (low, high))

    def _term(self, k: int, entry: EffectEntry) -> Term:
        where: tuple[int | str, ...] = ("effects", k)
        kind = self._effect(where, entry)
        wanted = {"joint": 1, "pair": 2, "robot": 0}[kind.scope]
        if len(entry.joints) != wanted or any(j > self._n for j in entry.joints):
            self._fail((*where, "joints"), entry.joints, f"{wanted} of joints 1 to {self._n}")
        for key, found, names in (
            ("coefficients", entry.coefficients, [c.name for c in kind.coefficients]),
            ("shape", entry.shape, [s.name for s in kind.shapes_in(entry.shape)]),
        ):
            if sorted(found) != sorted(names):
                text = ", ".join(found) or "nothing"
                self._fail((*where, key), text, ", ".join(names) or "nothing")
        for s in kind.shapes_in(entry.shape):
            self._in_reach((*where, "shape", s.name, "value"), s, entry.shape[s.name].value)
        errors = {name: e.std_error for name, e in entry.shape.items()}
        return Term(
            entry.effect,
            tuple(j - 1 for j in entry.joints),
            np.array([entry.coefficients[c.name].value for c in kind.coefficients]),
            {s.name: entry.shape[s.name].value for s in kind.shapes_in(entry.shape)}
            | entry.linear_about,
            {name: error for name, error in errors.items() if error is not None},
            tuple(entry.over),
        )

    def _in_reach(self, where: tuple[int | str, ...], shape: ShapeParameter, value: float) -> None:
        low, high = shape.reach
        if not low <= value <= high:
            unit = "" if shape.unit == "1" else f" {shape.unit}"
            self._fail(where, f"{value:g}", f"{low:g} to {high:g}{unit}")

    def _effect(self, where: tuple[int | str, ...], entry: EffectEntry) -> Effect:
        known = all_effects()
        if entry.effect == SmoothMap.id:
            full = [str(name) for name in entry.over]
            try:
                sound = [at_joint(name, -1, self._n) for name in full] == full
            except UserError:
                sound = False
            if not sound or not 1 <= len(full) <= 2:
                text = ", ".join(full) or "nothing"
                self._fail((*where, "over"), text, "one or two quantities such as q4, dq4")
        elif entry.effect not in known:
            self._fail((*where, "effect"), entry.effect, f"one of {', '.join(sorted(known))}")
        elif entry.over:
            self._fail((*where, "over"), ", ".join(entry.over), f"nothing for {entry.effect}")
        return effect(entry.effect, tuple(entry.over))

    def _feasible(self, found: FeasibleNote | None) -> None:
        """What a controller takes of the notes."""
        if found is None:
            return
        where = ("notes", "feasible")
        for key in ("rms", "rotors"):
            self._numbers((*where, key), dict(enumerate(getattr(found, key))))
        self._numbers((*where, "coefficients"), found.coefficients)

    def _torque_ends(self, found: tuple[TorqueEndNote, ...]) -> None:
        """What judging a run takes of the notes."""
        for k, end in enumerate(found):
            where = ("notes", "torque_ends", k)
            if not 1 <= end.joint <= self._n:
                self._fail((*where, "joint"), end.joint, f"a joint from 1 to {self._n}")
            self._numbers(where, {"level": end.level})

    def _numbers(self, where: tuple[int | str, ...], found: Mapping[Any, float]) -> None:
        for key, value in found.items():
            if not abs(value) <= MOST:
                self._fail((*where, key), f"{value:g}", f"a number of no more than {MOST:g}")

    def _covariance(self, size: int) -> Array:
        where = ("covariance", "data")
        try:
            raw = base64.b64decode("".join(self._entry.covariance.data.split()), validate=True)
        except (binascii.Error, ValueError):
            self._fail(where, "what is no base64", "base64 text")
        count = size * (size + 1) // 2
        if len(raw) != 8 * count:
            found = f"{len(raw) / 8:g} numbers"
            self._fail(where, found, f"{count}, the lower triangle of {size} x {size} parameters")
        out = np.zeros((size, size))
        out[np.tril_indices(size)] = np.frombuffer(raw, dtype="<f8")
        if not np.all(np.abs(out) <= WIDEST**2):
            self._fail(where, "a number that no error is", f"finite ones of {WIDEST**2:g} at most")
        return np.asarray(out + np.tril(out, -1).T)

    def _standard(self) -> Array | None:
        found = self._entry.standard_parameters
        if found is None:
            return None
        joints = self._entry.robot.joints
        if list(found) != joints:
            self._fail(("standard_parameters",), ", ".join(found), ", ".join(joints))
        return np.array(
            [
                self._sized(("standard_parameters", joint), found[joint], 10, "numbers")
                for joint in joints
            ]
        )

    def _known(self, where: tuple[int | str, ...], name: str, index: dict, kind: str) -> int:
        if name not in index:
            self._fail(where, name, f"a {kind} of links 1 to {self._n}, such as Izz1")
        return int(index[name])

    def _per_joint(self, where: tuple[int | str, ...], values: list[float]) -> Array:
        return self._sized(where, values, self._n, "numbers, one a joint")

    def _sized(
        self, where: tuple[int | str, ...], values: list[float], count: int, what: str
    ) -> Array:
        if len(values) != count:
            self._fail(where, f"{len(values)} values", f"{count} {what}")
        return np.array(values, dtype=float)

    def _fail(self, where: tuple[int | str, ...], found: object, wanted: str) -> None:
        raise UserError(self._file.problem(where, str(found), wanted))
