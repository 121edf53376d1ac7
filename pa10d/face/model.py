"""A torque model: rigid bodies and effects, with what is known of every number."""

from __future__ import annotations

import os
from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from pa10d.export.endings import Format
from pa10d.export.formats import export as exported
from pa10d.face.values import Array, ByContent, Said, bits, frozen, listed, settled
from pa10d.model import Parameters, TorqueModel
from pa10d.services.models import write_export, write_file
from pa10d.store.model_parse import read_model
from pa10d.store.model_text import model_text
from pa10d.store.models import new_info


@dataclass(frozen=True, repr=False)
class Parameter(Said):
    """A fitted number and its standard error, in ``unit``. determined: False where the data leave
    it open: then the value says nothing."""

    name: str
    value: float
    std_error: float
    unit: str
    determined: bool = True

    def __str__(self) -> str:
        if not self.determined:
            return f"{self.name}: not determined"
        return f"{self.name} = {self.value:.4g} ± {self.std_error:.2g} {self.unit}".rstrip()


@dataclass(frozen=True, repr=False)
class Effect(Said):
    """One effect of a model. joints: numbered from 1, empty for one of the whole robot."""

    effect: str
    joints: tuple[int, ...]
    parameters: tuple[Parameter, ...]

    def __str__(self) -> str:
        where = f" J{','.join(map(str, self.joints))}" if self.joints else ""
        return f"{self.effect}{where}: {'; '.join(map(str, self.parameters))}"


class Model(ByContent):
    """τ = Y_b(q, q̇, q̈)·h_b + Σ effects; a model is never changed, ``add`` makes a new one.

    name       as given
    joints     names of the robot's joints
    effects    textbook ones first, then in the order in which they were added
    rms        (n,) N·m (N where a joint slides) left on the runs it was fitted to
    cutoff_hz  of the low-pass on both sides of the fit
    feasible   whether bodies that can exist go with it (``parameters="feasible"``)
    warnings   what the fit found to be in doubt
    """

    def __init__(self, inner: TorqueModel) -> None:
        self.inner = inner

    @property
    def name(self) -> str:
        return self.inner.name

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(self.inner.robot.joint_names)

    @property
    def rms(self) -> Array:
        return frozen(self.inner.noise)

    @property
    def cutoff_hz(self) -> float:
        return float(self.inner.cutoff)

    @property
    def feasible(self) -> bool:
        return bool(self.inner.feasible)

    @property
    def warnings(self) -> tuple[str, ...]:
        return self.inner.notes.warnings

    @cached_property
    def base_parameters(self) -> tuple[Parameter, ...]:
        """The rigid bodies' parameters that motion can tell apart; SI units."""
        return tuple(
            Parameter(name, float(v.value), float(v.std_error), v.unit, v.determined)
            for name, v in zip(self.inner.parameter_names(), self.inner.base_values, strict=False)
        )

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        return tuple(
            Effect(
                term.effect_id,
                tuple(j + 1 for j in term.joints),
                tuple(
                    Parameter(name, float(v.value), float(v.std_error), v.unit, v.determined)
                    for name, v in self.inner.term_values(index).items()
                ),
            )
            for index, term in enumerate(self.inner.terms)
        )

    def torque(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        ddq: ArrayLike,
        time: ArrayLike | None = None,
        parameters: Parameters = "free",
    ) -> Array:
        """(N, n) N·m as the sensors would report it, from (N, n) rad, rad/s, rad/s².

        time: (N,) s at equal steps: the samples are one motion, memories included; without it
        each sample stands for itself. parameters: "free", the fit as ``compare`` judges it, or
        "feasible", bodies that can exist.
        """
        return self.inner.torque(q, dq, ddq, time, parameters)

    @property
    def content(self) -> Hashable:
        inner = self.inner
        terms = tuple(
            (t.effect_id, t.joints, t.over, bits(np.asarray(t.coefficients)), settled(t.shape))
            for t in inner.terms
        )
        arrays = (inner.h, inner.covariance, inner.noise, inner.loads, inner.standard)
        return inner.name, inner.robot.urdf, terms, tuple(map(bits, arrays)), inner.cutoff

    def _page(self) -> str:
        from pa10d.report.notebook import model_sheet

        return model_sheet(self.inner)

    def __repr__(self) -> str:
        added = [
            str(told).partition(":")[0]
            for told, term in zip(self.effects, self.inner.terms, strict=True)
            if term.effect.question != "textbook"
        ]
        beyond = f", with {', '.join(added)}" if added else ""
        return (
            f"<Model {self.name}: {len(self.joints)} joints, textbook model{beyond}; "
            f"left on its own runs: {listed(self.rms)} N·m>"
        )


def save_model(model: Model, path: str | os.PathLike[str]) -> Path:
    """Write the model as one YAML file that a person can read and ``load_model`` reads back."""
    return write_file(Path(path), model_text(model.inner, new_info(model.inner, None)))


def load_model(path: str | os.PathLike[str]) -> Model:
    """A model from its file; UserError names file, line and key of what is wrong."""
    return Model(read_model(Path(path))[0])


def export(
    model: Model,
    path: str | os.PathLike[str],
    format: Format = "urdf",
    parameters: Parameters = "feasible",
) -> tuple[str, ...]:
    """Write the model for other programs → what the format cannot hold, a sentence each. path: a
    file; a folder for the formats ros2_control and tables.

    format: one of those of ``pa10d model export``; parameters: "feasible", bodies that can exist,
    or "free", the unconstrained fit as ``compare`` judges it.
    """
    made = exported(model.inner, format, parameters)
    write_export(made, Path(path))
    return (*made.not_carried, *made.warnings)
