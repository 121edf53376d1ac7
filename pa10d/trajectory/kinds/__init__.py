"""The experiment kinds: parameters with a JSON schema, and what motion they make."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pa10d.common.errors import UserError
from pa10d.trajectory.kinds.base import Kind, validated
from pa10d.trajectory.kinds.boundary_velocity import BoundaryVelocity
from pa10d.trajectory.kinds.chirp import ChirpSweep
from pa10d.trajectory.kinds.excitation import Excitation
from pa10d.trajectory.kinds.first_motion import FirstMotion
from pa10d.trajectory.kinds.known_weight import KnownWeight
from pa10d.trajectory.kinds.load_sweep import LoadSweep
from pa10d.trajectory.kinds.point_to_point import PointToPoint
from pa10d.trajectory.kinds.reversals import Reversals
from pa10d.trajectory.kinds.single_joint import SingleJoint
from pa10d.trajectory.kinds.step import SmallStep
from pa10d.trajectory.kinds.tracking import Tracking
from pa10d.trajectory.kinds.velocity_sweep import VelocitySweep
from pa10d.trajectory.kinds.warm_up import WarmUp

KINDS: dict[str, type[Kind]] = {
    kind.kind: kind
    for kind in (
        BoundaryVelocity, Excitation, Tracking, PointToPoint, VelocitySweep, LoadSweep, Reversals,
        WarmUp, ChirpSweep, SingleJoint, KnownWeight, SmallStep, FirstMotion,
    )
}  # fmt: skip

__all__ = ["KINDS", "Kind", "experiment_kind", "read_request", "validated"]


def experiment_kind(name: str) -> type[Kind]:
    """The class behind a name; ``.model_json_schema()`` is what clients are served."""
    if name not in KINDS:
        raise UserError(f"kind: found {name!r}, expected one of {', '.join(KINDS)}")
    return KINDS[name]


def read_request(data: Mapping[str, Any]) -> Kind:
    """``{kind: …, parameters: {…}}``, as files, clients and diagnoses hold it, checked.

    ``about`` may stand beside the two: figures for people, not read.
    """
    if not isinstance(data, Mapping) or "kind" not in data:
        raise UserError("request: no 'kind'; expected {kind: …, parameters: {…}}")
    unknown = sorted(set(data) - {"kind", "parameters", "about"})
    if unknown:
        raise UserError(f"request: unknown {', '.join(unknown)}; expected kind and parameters")
    parameters = data.get("parameters") or {}
    if not isinstance(parameters, Mapping):
        raise UserError(f"parameters: found {parameters!r}, expected names and values")
    return validated(experiment_kind(str(data["kind"])), dict(parameters))
