"""What is known of an arm's joints, with the gains that follow from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.gains import PidGains
from pa10d.control.joint_figures import Inertias, JointFigures

Array = NDArray[np.float64]


@dataclass(frozen=True)
class KnownJoints:
    """(n,) each where nothing else is said.

    asked        Hz, bandwidth that the servo was to have
    bandwidth    Hz that the gains give
    sensitivity  peak of the loop's, inf: it swings up in some pose
    inertia      kg·m² as ``Inertias`` has them
    resonance    Hz, inf: none was seen
    sentences    of all this, for a person
    lean         how the base leans against its profile, which is one of them; "": as it says
    """

    figures: JointFigures
    gains: PidGains
    asked: float
    bandwidth: Array
    sensitivity: Array
    inertia: Inertias
    resonance: Array
    sentences: tuple[str, ...]
    lean: str = ""

    def leaning(self, lean: str) -> KnownJoints:
        """The same of an arm whose base leans, as is said whatever is learnt of it later."""
        return replace(self, sentences=(*self.sentences, lean), lean=lean) if lean else self

    @property
    def felt(self) -> Array | None:
        """(n, 10) standard parameters of bodies, where these are not the URDF's alone: those that
        were felt have draws of what they may be as well."""
        return self.figures.bodies[0] if len(self.figures.bodies) > 1 else None

    def document(self) -> JsonObject:
        """For files, clients and other processes; null for what is infinite."""
        return {
            "figures": self.figures.document(),
            "gains": self.gains.document(),
            "bandwidth_hz": {"asked": self.asked, "joints": self.bandwidth.tolist()},
            "sensitivity": _finite(self.sensitivity),
            "inertia": {key: values.tolist() for key, values in self.inertia._asdict().items()},
            "resonance_hz": _finite(self.resonance),
            "sentences": list(self.sentences),
            "lean": self.lean,
        }

    @staticmethod
    def from_document(document: Mapping[str, Any]) -> KnownJoints:
        """The other way; ValueError, KeyError or TypeError where it is none."""
        bandwidth = document["bandwidth_hz"]
        return KnownJoints(
            figures=JointFigures.from_document(document["figures"]),
            gains=PidGains.from_document(document["gains"]),
            asked=float(bandwidth["asked"]),
            bandwidth=np.array(bandwidth["joints"], dtype=float),
            sensitivity=_numbers(document["sensitivity"]),
            inertia=Inertias(**{k: np.array(v, float) for k, v in document["inertia"].items()}),
            resonance=_numbers(document["resonance_hz"]),
            sentences=tuple(map(str, document["sentences"])),
            lean=str(document.get("lean", "")),
        )


@dataclass(frozen=True)
class MeasuredJoints:
    """The same with where it comes from. measured: when; runs: names or ids; profile: its name;
    fingerprint: of all that the figures depend on."""

    known: KnownJoints
    measured: str
    runs: tuple[str, ...]
    profile: str
    fingerprint: str

    def document(self) -> JsonObject:
        """As it is kept, and told to clients."""
        head = {"measured": self.measured, "runs": list(self.runs)}
        tail = {"schema": SCHEMA, "profile": self.profile, "fingerprint": self.fingerprint}
        return {**head, **self.known.document(), **tail}

    @staticmethod
    def from_document(document: Mapping[str, Any]) -> MeasuredJoints:
        """The other way; ValueError, KeyError or TypeError where it is none."""
        if document["schema"] != SCHEMA:
            raise ValueError(f"schema: found {document['schema']}, expected {SCHEMA}")
        return MeasuredJoints(
            known=KnownJoints.from_document(document),
            measured=str(document["measured"]),
            runs=tuple(map(str, document["runs"])),
            profile=str(document["profile"]),
            fingerprint=str(document["fingerprint"]),
        )


@dataclass(frozen=True)
class Calmer:
    """What is known after a joint swung, with gains that do not; note: what was changed."""

    known: KnownJoints
    note: str


SCHEMA = "pa10d/joints/2"


def _finite(values: Array) -> list[float | None]:
    return [float(v) if np.isfinite(v) else None for v in values]


def _numbers(values: Sequence[float | None]) -> Array:
    return np.array([np.inf if v is None else float(v) for v in values])
