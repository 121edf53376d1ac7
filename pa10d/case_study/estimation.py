"""Steps 4 and 5 of the paper's 3.1: average, filter, estimate; judge on another trajectory."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.measurement.recording import Recording
from pa10d.paper.periods import (
    average_periods,
    fourier_motion,
    mean_period,
    suggested_cutoff,
)
from pa10d.paper.results import SETS, Preparation, Reconstruction
from pa10d.paper.stack import least_squares, stacked
from pa10d.paper.variants import Variants, estimation_variants
from pa10d.regression.equation import RunEquation, edge_time, prepare
from pa10d.trajectory.fourier import fourier_basis
from pa10d.trajectory.kinds.excitation import Excitation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimated:
    """mean: the averaged period as a recording, its ends going on periodically."""

    mean: Recording
    preparation: Preparation
    variants: Variants
    reconstruction: Reconstruction


def estimate(
    exciting: Recording, other: Recording, design: Excitation, robot: Robot, boundary: Array
) -> Estimated:
    """exciting: whole periods of the design; other: what both sets are judged on."""
    fundamental, harmonics = design.fundamental, design.harmonics
    cutoff = suggested_cutoff(fundamental, harmonics)
    edge = edge_time(exciting.rate, cutoff)
    start = float(exciting.t[0])
    q = average_periods(exciting.t, exciting.q, fundamental, start)
    tau = average_periods(exciting.t, exciting.tau, fundamental, start)
    mean = mean_period(q, tau, edge, "mean period")
    train, judge = prepare(mean, robot, cutoff), prepare(other, robot, cutoff)
    variants = estimation_variants([train], [judge], robot, boundary)
    fitted = fourier_motion(mean.t, mean.q, fundamental, harmonics, cutoff)
    designed = np.vstack([np.array(part, ndmin=2) for part in (design.centre, design.a, design.b)])
    b0, b1, _ = fourier_basis(fundamental, harmonics, q.t)
    preparation = Preparation(
        t=q.t,
        q=b0 @ designed,
        dq=b1 @ designed,
        tau=tau.mean,
        periods=tau.periods,
        noise=tau.noise,
        outside=fitted.outside,
        trusted=fitted.trusted,
        cutoff=cutoff,
        warnings=tuple(tau.warnings("torque", "N·m")),
        fourier_rms=_judged(_with_motion(train, fitted.q, fitted.dq, fitted.ddq), judge, robot),
        measured_rms=_judged(train, judge, robot),
    )
    return Estimated(mean, preparation, variants, _reconstructed(judge, robot, variants))


def _with_motion(equation: RunEquation, q: Array, dq: Array, ddq: Array) -> RunEquation:
    return replace(equation, context=replace(equation.context, q=q, dq=dq, ddq=ddq))


def _judged(train: RunEquation, other: RunEquation, robot: Robot) -> Array:
    """(n,) N·m on the other trajectory, weighted least squares over all samples."""
    return stacked([other], robot).rms(least_squares(stacked([train], robot), weighted=True)[0])


def rms_of_sets(run: Recording, found: Estimated, robot: Robot) -> dict[str, list[float]]:
    """N·m per joint that the models of both sets miss of another run."""
    stack = stacked([prepare(run, robot, found.preparation.cutoff)], robot)
    return {name: stack.rms(found.variants.ours(name).parameters).tolist() for name in SETS}


def _reconstructed(judge: RunEquation, robot: Robot, variants: Variants) -> Reconstruction:
    stack = stacked([judge], robot)
    both = [
        np.column_stack([rows @ variants.ours(name).parameters for rows in stack.rows])
        for name in SETS
    ]
    return Reconstruction(judge.t[judge.inside], np.column_stack(stack.tau), *both)
