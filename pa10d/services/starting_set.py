"""What to record first of an arm: its joints' first motion, two runs to fit a model to, two others
to judge it by."""

from __future__ import annotations

from dataclasses import dataclass, field

from pa10d.common.jsonable import JsonObject

FIT, JUDGE = "fit", "judge"
"""Tags of runs: models are fitted to the one kind and judged by the other."""


@dataclass(frozen=True)
class SuggestedMotion:
    """An experiment worth running. parameters: as its kind's own schema says; tags: of its run."""

    kind: str
    parameters: JsonObject = field(default_factory=dict)
    tags: tuple[str, ...] = ()
    why: str = ""


STARTING_SET = (
    SuggestedMotion(
        kind="first_motion",
        why="Each joint by small motions, for gains that fit; skipped where that was done.",
    ),
    SuggestedMotion(
        kind="excitation",
        tags=(FIT,),
        why="All joints at once, fast: masses, inertias, gravity.",
    ),
    SuggestedMotion(
        kind="excitation",
        parameters={"fundamental": 0.025, "harmonics": 3, "cycles": 1, "seed": 2},
        tags=(FIT,),
        why="All joints at once, slowly: friction, and what depends on the angle.",
    ),
    SuggestedMotion(
        kind="point_to_point",
        parameters={"seed": 7},
        tags=(JUDGE,),
        why="Other poses, with rests: does the model hold where it was not fitted?",
    ),
    SuggestedMotion(
        kind="excitation",
        parameters={"fundamental": 0.125, "seed": 9},
        tags=(JUDGE,),
        why="Another fast motion, with the loads of daily work.",
    ),
)
