"""Simulated arms that hide an effect, and what the library should say about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from backends.virtual.datasets import KINDS, figures_of, make_runs, random_effect
from pa10d.common.parallel import one_thread
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.timing import align
from pa10d.dynamics import Robot, robot_from_profile
from pa10d.effects import effect
from pa10d.identify.procedure import identify
from pa10d.judgement import in_band
from pa10d.measurement.recording import Recording
from pa10d.model import Term, TorqueModel
from pa10d.profile import load_profile

Entry = Mapping[str, Any]
"""One hidden effect as the simulator takes it: effect, joint(s) from 1, its parameters."""

PROFILE = "pa10-sim"


SAME: dict[str, dict[str, str]] = {
    "torque_offset": {"offset": "offset"},
    "coulomb_asymmetry": {"dFc": "dFc", "dFv": "dFv"},
    "stribeck": {"Fs": "Fs", "vs": "vs", "delta": "delta"},
    "nonlinear_viscous": {"Fp": "Fp", "p": "p"},
    "load_friction": {"mu": "mu", "dmu": "dmu"},
    "thermal_friction": {"T": "T"},
    "position_friction": {"A": "height", "qc": "centre", "w": "width"},
    "torque_ripple": {"N": "N", "a": "sin", "b": "cos"},
    "joint_elasticity": {"K": "K"},
    "backlash": {"b": "b"},
    "spring": {"k": "k", "q0": "q0"},
    "payload": {"mass": "mass", "cx": "cx", "cy": "cy", "cz": "cz"},
    "base_tilt": {"rx": "x", "ry": "y"},
    "encoder_offset": {"offset": "offset"},
    "torque_saturation": {"c3": "cubic"},
    "torque_delay": {"Td": "Td"},
    "coupling_friction": {"F": "F", "ratio": "sign"},
    "coupling_inertia": {"Ia_ij": "Ia"},
    "contact": {"k": "k", "qs": "qs", "side": "side"},
}
"""Parameters of the library -> of the simulator, where both mean the same."""


@cache
def _robot() -> Robot:
    return robot_from_profile(load_profile(PROFILE))


def drawn(effect_id: str, seed: int) -> dict[str, Any]:
    """An effect of random size on a random joint."""
    return random_effect(
        np.random.default_rng([seed, sum(effect_id.encode())]), effect_id, _sizes()
    )


def random_effect_of(effect_id: str, joint: int) -> dict[str, Any]:
    """The same on a given joint (numbered from 1)."""
    for seed in range(1000):
        hidden = drawn(effect_id, seed)
        if hidden.get("joint") == joint:
            return hidden
    raise AssertionError(f"{effect_id} is never drawn on joint {joint}")


@cache
def _sizes():
    return figures_of(PROFILE)


def joints_of(hidden: Entry) -> tuple[int, ...]:
    """0-based, as terms have them."""
    named = hidden.get("joints", [hidden["joint"]] if "joint" in hidden else [])
    return tuple(j - 1 for j in named)


def asks_what_changed(effect_id: str) -> bool:
    """Is it an effect that a refit absorbs?"""
    return effect(effect_id).question == "changed"


def true_parameters(hidden: Entry, truth: Mapping[str, Any]) -> dict[str, float]:
    """What the library should report, for parameters that it shares with the simulator."""
    kind = hidden["effect"]
    if kind == "torque_gain":
        return {"gain": hidden["gain"] - 1.0}
    if kind == "thermal_friction":
        if hidden["law"] != "time":  # what is lost is told per watt, there per its own power
            return {"T": hidden["T"]}
        j, loss = hidden["joint"] - 1, hidden["loss"]
        lost = {
            "dFv": loss * truth["viscous"][j],
            "dFc": loss * hidden["coulomb_share"] * truth["coulomb"][j],
        }
        return {"T": hidden["T"], **lost}
    if "wave" in hidden or kind == "presliding_hysteresis":
        return {}
    same = {ours: float(hidden[theirs]) for ours, theirs in SAME[kind].items() if theirs in hidden}
    if kind in ("joint_elasticity", "backlash", "load_friction") and hidden["joint"] <= 2:
        # only these joints' rotors cannot be told from their links by a rigid model
        same["rotor"] = truth["rotor_inertia"][hidden["joint"] - 1]
    return same


@dataclass(frozen=True)
class Arm:
    """Runs of one arm, what it hides, and the textbook model of it (of ``ref`` runs if frozen)."""

    runs: dict[str, Recording]
    hidden: tuple[Entry, ...]
    truth: Mapping[str, Any]
    model: TorqueModel
    frozen: bool

    @property
    def fit(self) -> list[Recording]:
        return [self.runs["train_a"], self.runs["train_b"]]

    @property
    def validate(self) -> list[Recording]:
        return [self.runs["valid_a"], self.runs["valid_b"]]

    def error_as_given(self) -> np.ndarray:
        """(n,) N·m held out, of the model without the hidden effects (refitted unless frozen)."""
        state = SearchState.start(*self._start(), frozen=self.frozen)
        align(state)
        return rms(state.held_residual())

    def _start(self):
        model = in_band(self.model)
        return model, *two_sides(model, self.fit, self.validate)[:2]

    def diagnose(self, **options: Any) -> Diagnosis:
        return diagnose(self.model, self.fit, self.validate, frozen=self.frozen, **options)


def arm(
    seed: int,
    hidden: Sequence[Entry] = (),
    noise: str = "white",
    *,
    frozen: bool = False,
    seconds: float = 40.0,
    cutoff: float | None = None,
) -> Arm:
    """Simulate, and identify the textbook model as a user would."""
    kinds = (*KINDS, "ref_a", "ref_b") if frozen else KINDS
    runs, truth = make_runs(seed, hidden, noise, kinds, PROFILE, seconds=seconds)
    first = ["ref_a", "ref_b"] if frozen else ["train_a", "train_b"]
    model = identify([runs[k] for k in first], _robot(), name="m0", cutoff=cutoff)
    return Arm(runs, tuple(hidden), truth, model, frozen)


@one_thread()  # beside gaps errors depend on rounding, and rounding on the number of threads
def error_when_told(found: Arm) -> np.ndarray:
    """(n,) N·m held out: the hidden effects are given, only the rest is fitted.

    Once with their true shapes, once with these free as well: the lower of both, joint by joint.
    """
    errors = []
    for refine in (False, True):
        state = SearchState.start(*found._start(), frozen=found.frozen)
        given = len(state.terms)
        search = Search(state, [], given)
        align(state)
        for hidden in found.hidden:
            state.push(told(search, hidden, found.truth))
        if refine:
            search.settle()
        else:
            for _ in range(3):
                state.refit()
                state.relook()
            state.refit()
        errors.append(rms(state.held_residual()))
    return np.min(errors, axis=0)


def told(search: Search, hidden: Entry, truth: Mapping[str, Any]) -> Term:
    """The hidden effect as a term with its true shape; where the library has another form of it,
    with the shape that fits best."""
    kind, known = effect(hidden["effect"]), true_parameters(hidden, truth)
    own = SHAPES.get(kind.id)
    if own is not None:
        shape = own(hidden)
    elif all(s.name in known for s in kind.shapes):
        shape = {s.name: known[s.name] for s in kind.shapes}
    else:
        best = search.best(kind, joints_of(hidden))
        assert best is not None, f"{kind.id}: this data cannot show it"
        return best.term
    return Term(kind.id, joints_of(hidden), np.zeros(len(kind.coefficients)), shape)


SHAPES: dict[str, Callable[[Entry], dict[str, float]]] = {
    "thermal_friction": lambda h: {"T": h["T"], "heated": float(h["law"] == "power")},
    "torque_delay": lambda h: {"at": h["Td"]},
    "torque_saturation": lambda h: {"at": h["cubic"]},
    "encoder_offset": lambda h: {"at": h["offset"]},
    "base_tilt": lambda h: {"rx": h["x"], "ry": h["y"]},
}
"""Laws that are taken as a secant: where, in truth."""
