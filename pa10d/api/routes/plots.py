"""Figures for whoever looks: Plotly JSON, as much detail as a screen has, all of it on zoom."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query

from pa10d.api.deps import Span, TheDaemon
from pa10d.api.problems import responses
from pa10d.api.routes.models import find_model
from pa10d.api.routes.runs import find_run
from pa10d.api.schemas.plots import Plot, StaircasePlot, TorquePlot, VersusPlot

router = APIRouter(prefix="/plots", tags=["plots"])
WRONG = responses("not-found", "refused")
Text = Annotated[str, Query(min_length=1, max_length=100)]
Runs = Annotated[list[str], Query(alias="run", min_length=1, max_length=100)]
Edge = Annotated[float, Query(description="of 'variable', its unit")]


@router.get("/run", response_model=Plot, responses=WRONG)
async def run_plot(daemon: TheDaemon, run: Text, span: Span) -> Any:
    """Positions and torques of a recording."""
    return await daemon.look("run_plot", run=(await find_run(daemon, run)).id, span=span)


@router.get("/torque", response_model=TorquePlot, responses=WRONG)
async def torque_plot(
    daemon: TheDaemon,
    model: Text,
    run: Text,
    joint: Annotated[int, Query(ge=1, le=64)],
    span: Span,
    raw: Annotated[bool, Query(description="Every sample, unfiltered")] = False,
    variable: Annotated[str | None, Query(max_length=40, examples=["|dq4|"])] = None,
    low: Edge = 0.0,
    high: Edge = 0.0,
) -> Any:
    """Measured torque over modelled torque, the residual under it.

    ``variable``, ``low``, ``high``: a place from a comparison's ``where``, shown in red; ``jump``
    is then a stretch of time that shows it well.
    """
    return await daemon.look(
        "torque_over", model=(await find_model(daemon, model)).id,
        run=(await find_run(daemon, run)).id, joint=joint, raw=raw, span=span,
        place=None if variable is None else (variable, low, high),
    )  # fmt: skip


@router.get("/staircase", response_model=StaircasePlot, responses=WRONG)
async def staircase_plot(daemon: TheDaemon, model: Text, runs: Runs) -> Any:
    """The error of a model and of every version it was made from, on the same runs."""
    found = [(await find_run(daemon, run)).id for run in runs]
    return await daemon.look("staircase_of", model=(await find_model(daemon, model)).id, runs=found)


@router.get("/versus", response_model=VersusPlot, responses=WRONG)
async def versus_plot(daemon: TheDaemon, one: Text, other: Text, runs: Runs) -> Any:
    """Two models side by side on the same runs."""
    return await daemon.look(
        "versus", one=(await find_model(daemon, one)).id,
        other=(await find_model(daemon, other)).id,
        runs=[(await find_run(daemon, run)).id for run in runs],
    )  # fmt: skip
