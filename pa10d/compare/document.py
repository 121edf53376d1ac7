"""A comparison as JSON."""

from __future__ import annotations

from pa10d.common.jsonable import JsonObject, plain
from pa10d.compare.comparison import Comparison, RunScores
from pa10d.compare.places import Place
from pa10d.compare.regions import Region


def document(comparison: Comparison) -> JsonObject:
    """Figures per run and pooled, where the model fails (pooled), and the shape of the rest."""
    cutoff = comparison.model.cutoff
    pooled = figures(comparison.pooled, cutoff)
    return {
        "model": comparison.model.name,
        "joint_names": list(comparison.model.robot.joint_names),
        "cutoff_hz": cutoff,
        "mask": comparison.pooled.mask,
        "runs": [{"name": run.name, **figures(run, cutoff)} for run in comparison.runs],
        "pooled": pooled,
        "where": pooled["where"],
        "order_lines": [
            [{"order": order, "amplitude": size} for order, size in found.lines] if found else []
            for found in comparison.orders
        ],
        "whiteness": [
            {
                "p_value": white.p_value,
                "samples": white.samples,
                "effective_samples": white.effective,
                "memory_s": white.memory,
            }
            for white in comparison.whiteness
        ],
        "warnings": list(comparison.warnings),
    }


def figures(run: RunScores, cutoff: float) -> JsonObject:
    """One run's entry."""
    found = run.scores
    return {
        "rms": plain(found.rms),
        "rms_with_reversals": plain(found.rms_with_reversals),
        "rms_raw": plain(found.rms_raw),
        "nrmse": plain(found.nrmse),
        "max": plain(found.max),
        "r2": plain(found.r2),
        **run.floor.document(),
        "cutoff_hz": cutoff,
        "mask": run.mask,
        "where": [place_document(place) for place in run.where],
        "spread": list(run.spread),
    }


def place_document(place: Place) -> JsonObject:
    """One region or curve."""
    what = place.what
    return {
        "joint": place.joint + 1,
        "variable": place.variable,
        "range": [what.low, what.high],
        "share": what.share,
        "sentence": place.sentence,
        "kind": "region" if isinstance(what, Region) else "curve",
        "samples": what.samples if isinstance(what, Region) else 1.0,
        "p_value": place.p_value,
    }
