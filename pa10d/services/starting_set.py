"""What to record first of an arm: its joints' first motion, two runs to fit a model to, two others
to judge it by."""

from __future__ import annotations

from typing import Any

FIT, JUDGE = "fit", "judge"
"""Tags of runs: models are fitted to the one kind and judged by the other."""

STARTING_SET: tuple[dict[str, Any], ...] = (
    {
        "kind": "first_motion",
        "parameters": {},
        "tags": [],
        "why": "Each joint by small motions, for gains that fit; skipped where that was done.",
    },
    {
        "kind": "excitation",
        "parameters": {},
        "tags": [FIT],
        "why": "All joints at once, fast: masses, inertias, gravity.",
    },
    {
        "kind": "excitation",
        "parameters": {"fundamental": 0.025, "harmonics": 3, "cycles": 1, "seed": 2},
        "tags": [FIT],
        "why": "All joints at once, slowly: friction, and what depends on the angle.",
    },
    {
        "kind": "point_to_point",
        "parameters": {"seed": 7},
        "tags": [JUDGE],
        "why": "Other poses, with rests: does the model hold where it was not fitted?",
    },
    {
        "kind": "excitation",
        "parameters": {"fundamental": 0.125, "seed": 9},
        "tags": [JUDGE],
        "why": "Another fast motion, with the loads of daily work.",
    },
)
