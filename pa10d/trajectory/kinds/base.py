"""What every kind of experiment has: parameters that check themselves, and a builder."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.words import did_you_mean, from_one
from pa10d.common.yamlfile import expectation
from pa10d.trajectory.plan import Plan
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]

Joint = Annotated[int, Field(ge=1)]
Share = Annotated[float, Field(ge=1e-6, le=1)]
Positive = Annotated[float, Field(ge=1e-9, le=1e9, allow_inf_nan=False)]
Angle = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1, le=1000)]


class Kind(BaseModel, ABC):
    """Parameters of one kind; joints are numbered from 1, angles are rad.

    Sub-classes say their ``kind`` and ``title`` and build the plan.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    kind: ClassVar[str]
    title: ClassVar[str]

    joints: list[Joint] | None = Field(
        default=None, description="joints it is about; all where absent"
    )
    pose: list[Angle] | None = Field(
        default=None, description="rad, one per joint of the arm: where all other joints stand"
    )
    seed: Annotated[int, Field(ge=0)] = Field(default=1, description="same seed, same motion")

    @abstractmethod
    def build(self, around: Surroundings) -> Plan:
        """The motions, within what ``around`` allows."""

    def chosen(self, around: Surroundings) -> list[int]:
        """0-based joints."""
        n = around.robot.n
        if self.joints is None:
            return list(range(n))
        for j in self.joints:
            if j > n:
                raise UserError(f"joints: found {j}, expected {from_one(n)}")
        if len(set(self.joints)) != len(self.joints) or not self.joints:
            raise UserError(f"joints: found {self.joints}, expected at least one, each once")
        return [j - 1 for j in self.joints]

    def home(self, around: Surroundings) -> Array:
        """(n,) the given pose, or the arm's rest pose."""
        if self.pose is None:
            return around.limits.rest_pose()
        if len(self.pose) != around.robot.n:
            raise UserError(
                f"pose: found {len(self.pose)} angles, expected {around.robot.n}, one per joint"
            )
        return around.within(np.array(self.pose, dtype=float), "pose")

    def request(self) -> JsonObject:
        """``{kind, parameters}``: what files and clients hold; defaults are left out."""
        given = self.model_dump(mode="json", exclude_defaults=True)
        return {"kind": self.kind, "parameters": given}


def validated(kind: type[Kind], parameters: JsonObject) -> Kind:
    """Parameters of a kind, or one line per problem."""
    try:
        return kind.model_validate(parameters)
    except ValidationError as error:
        lines = []
        for problem in error.errors():
            place = ".".join(str(part) for part in problem["loc"]) or "parameters"
            lines.append(f"{kind.kind}: {place}: {_told(kind, problem)}")
        raise UserError("\n".join(lines)) from error


def _told(kind: type[Kind], problem: Any) -> str:
    if problem["type"] == "extra_forbidden":
        name, known = str(problem["loc"][-1]), list(kind.model_fields)
        meant = did_you_mean(name, known)
        return f"no such parameter, expected one of {', '.join(known)}{meant}"
    found = "nothing" if problem["type"] == "missing" else repr(problem["input"])
    return f"found {found}, expected {expectation(problem)}"
