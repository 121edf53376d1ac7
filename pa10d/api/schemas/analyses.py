"""What is asked of runs and models."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field

from pa10d.api.schemas.common import Force, Name, Runs, Strict
from pa10d.api.schemas.models import EffectId, Joints


class LeftOut(Strict):
    """A stretch of a run, s since its first sample."""

    run: Name
    begin: float = Field(ge=0)
    end: float = Field(gt=0)


class IdentifyRequest(Strict):
    """Fit the textbook model."""

    runs: Runs
    name: Name
    cutoff: float | None = Field(None, gt=0, le=10_000, description="Hz; default: from the data")
    with_effects: Annotated[list[EffectId], Field(max_length=32)] = []
    robust: bool = Field(False, description="Let samples far off the model count less")
    faster_than: Annotated[list[float], Field(max_length=64)] | None = Field(
        None, description="rad/s per joint: fit only samples in which the joint is faster"
    )
    prior: float | None = Field(
        None, gt=0, le=1000,
        description="Bodies are the URDF's, give or take this many % of what is usual for a link "
        "(one standard deviation); default: nothing is known of them",
    )  # fmt: skip
    given: Annotated[list[Annotated[str, Field(max_length=200)]], Field(max_length=100)] = Field(
        [], examples=[["Fc3=12±2"]],
        description="Parameters that somebody knows, NAME=VALUE±ERROR in SI: a name from the table "
        "of parameters, Fc3 for short, or a link's own figure (link J7: m)",
    )  # fmt: skip
    left_out: Annotated[list[LeftOut], Field(max_length=200)] = Field(
        [], description="Stretches that this fit does not use, beside those of the runs themselves"
    )
    replace: bool = False
    force: Force = False


class CompareRequest(Strict):
    """Judge a model on runs."""

    model: Name
    runs: Runs
    cutoff: float | None = Field(
        None, gt=0, le=10_000, description="Hz; default: the band that all its versions share"
    )
    force: Force = False


class DiagnoseRequest(Strict):
    """Ask which effect is missing."""

    model: Name
    fit: Runs
    validate_: Annotated[list[Name], Field(max_length=100, alias="validate")] = []
    frozen: bool = Field(False, description="What changed? Nothing is refitted")
    effect: EffectId | None = Field(None, description="Test one suspicion")
    joints: Joints = []
    force: Force = False


class AddRequest(Strict):
    """A new version of a model with one more effect."""

    effect: EffectId
    joints: Joints = []
    over: Annotated[list[Name], Field(max_length=2)] = Field(
        [], description="Of smooth_map: quantities, as 'depends_on' of what is unexplained"
    )
    fit: Runs
    name: Name
    replace: bool = False
    force: Force = False


class ImproveRequest(Strict):
    """Diagnose and add until nothing significant is left."""

    experiments: bool = Field(
        False, description="Run the experiments that settle a doubt; this moves the arm"
    )
    fit: Runs
    validate_: Annotated[list[Name], Field(max_length=100, alias="validate")] = []
    name: Name
    replace: bool = False
    smooth: bool = Field(
        False, description="Take away what no effect explains by smooth maps, which explain nothing"
    )
    force: Force = False


class Story(BaseModel):
    """A virtual arm that hides something, on which day, and what it is once it was revealed."""

    hides: bool
    day: int
    hidden: str | None = Field(examples=["stribeck in joint 4 (Fs = 2.03, vs = 0.1)"])
    since_the_night: bool | None = Field(
        description="Whether it came with the night: then a comparison with before shows it"
    )


class ReportRequest(Strict):
    """The report of a model. runs: to judge it by; default: those that it was judged by."""

    runs: Annotated[list[Name], Field(max_length=100)] = []
