"""Hidden in a simulated arm, it is found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from backends.virtual.datasets import KINDS, figures_of, make_runs, random_effect
from backends.virtual.plant.laws import catalogue
from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import Robot
from pa10d.effects import Effect
from pa10d.identify import identify
from pa10d.measurement.recording import Recording
from pa10d.model import Term
from pa10d.regression.equation import prepare

REF = ("ref_a", "ref_b")
CUTOFF = 10.0  # Hz, of the motion that the effect's torque is worked out on


def found_again(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """By the whole search, first, on its joints. What the simulator knows it hides by its own
    physics; of any other effect the example's torque is added to what the arm measures."""
    seed = int(rng.integers(1000))
    changed = kind.question == "changed"
    kinds = (*KINDS, *(REF * changed))
    if kind.id in catalogue():
        hidden = random_effect(rng, kind.id, figures_of("pa10-sim"))
        runs, _ = make_runs(seed, [hidden], kinds=kinds)
        joints = tuple(hidden.get("joints", [hidden["joint"]] if "joint" in hidden else []))
    else:
        joints = () if kind.scope == "robot" else kind.example.joints  # type: ignore[union-attr]
        runs, _ = make_runs(seed, kinds=kinds)
        runs = {k: r if k in REF else _with(kind, joints, robot, r) for k, r in runs.items()}
    fit, held = ([runs[f"{name}_{part}"] for part in "ab"] for name in ("train", "valid"))
    model = identify([runs[k] for k in REF] if changed else fit, robot, name="check")
    found = diagnose(model, fit, held, frozen=changed)
    if not found.findings:
        return f"hidden in joints {list(joints)}, it is not found: {found.verdict}"
    first = found.findings[0]
    alike = {(c.effect, tuple(j + 1 for j in c.joints)) for c in first.confounded_with}
    named = (first.term.effect_id, tuple(j + 1 for j in first.term.joints))
    if (kind.id, tuple(joints)) not in {named, *alike}:
        return f"hidden in joints {list(joints)}, {first.term.label} is found in its place"
    return None


def _with(kind: Effect, joints: tuple[int, ...], robot: Robot, run: Recording) -> Recording:
    """The recording of an arm that has the example of the effect."""
    example = kind.example
    assert example is not None
    seen = prepare(run, robot, CUTOFF).context
    seen = replace(seen, rigid=robot.parameters, total=run.tau)
    at = tuple(j - 1 for j in joints)
    term = Term(kind.id, at, np.array(example.coefficients), dict(example.shape))
    return replace(run, tau=run.tau + term.torque(seen))
