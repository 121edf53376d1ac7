"""Springs within the band of the motion: sought together with the bodies that bend to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    FIRM_MODES,
    FIRM_ROTOR,
    FIRM_ZETA,
    MATERIAL_GAIN,
    SPRING_HOLDS,
    SPRING_STEPS,
    SPRINGS_FOLLOWED,
)
from pa10d.diagnose.regression.flexible import Flexible, JointSpring, SpringFit, zeta_of
from pa10d.diagnose.regression.passed import Guess, guesses
from pa10d.diagnose.regression.state import SearchState
from pa10d.effects import Effect
from pa10d.effects.rotor import typical_link
from pa10d.model import Term

Array = NDArray[np.float64]
Place = tuple[Effect, tuple[int, ...]]


def with_springs(state: SearchState, suspects: Sequence[Place], least: float) -> list[SearchState]:
    """States with one spring more, for the joints where it promises to take more than ``least``
    (weighted squared error of the fit side); the one that leaves least comes first."""
    there = {t.joints for t in state.terms if t.effect.series_spring}
    places = {j[0]: kind for kind, j in suspects if kind.series_spring and j not in there}
    if not places or state.frozen:
        return []
    tried = guesses(state, sorted(places))
    likely = [g for g in tried if g.gain > least and g.drop > MATERIAL_GAIN]
    found = []
    for guess in likely[:SPRINGS_FOLLOWED]:
        fitted = _followed(Flexible(state, guess.joint), _starts(state, guess))
        if fitted is not None:
            found.append((fitted.left, _with_spring(state, places[guess.joint], fitted)))
    return [s for _, s in sorted(found, key=lambda pair: pair[0])]


def with_firm_spring(
    state: SearchState, suspects: Sequence[Place], joint: int
) -> list[SearchState]:
    """The state with a spring more in this joint, if there can be one: of a mode beyond those that
    the motion drives, to which no measured torque can be wound, so that nothing is guessed."""
    kinds = [kind for kind, at in suspects if kind.series_spring and at == (joint,)]
    there = any(t.effect.series_spring and t.joints == (joint,) for t in state.terms)
    if not kinds or there or state.frozen:
        return []
    fitted = _followed(Flexible(state, joint), _firm_starts(state, joint))
    return [] if fitted is None else [_with_spring(state, kinds[0], fitted)]


def _firm_starts(state: SearchState, joint: int) -> list[tuple[Array, JointSpring]]:
    """The model's own bodies, which have nothing to bend to, behind springs of some modes."""
    context = state.train.contexts[0]
    inertia = float(context.typical_inertia[joint])
    rotor = FIRM_ROTOR * inertia if joint in context.rotor_in_load else 0.0
    cutoff = min(run.lowpass.cutoff for run in state.train.runs)
    starts = []
    for mode in FIRM_MODES:
        omega = 2.0 * np.pi * mode * cutoff
        stiffness = (inertia - rotor) * omega**2
        spring = JointSpring(joint, stiffness, 2.0 * FIRM_ZETA * stiffness / omega, rotor)
        starts.append((state.fit.beta, spring))
    return starts


def follow(state: SearchState, index: int, bodies: Sequence[Array]) -> SearchState | None:
    """The state with the spring terms[index] and all else fitted at once, from any of these base
    parameters; None where none of them leads anywhere."""
    term = state.terms[index]
    j, shape = term.joints[0], term.shape
    rotor = shape.get("rotor", 0.0)
    inertia = typical_link(state.train.contexts[0], j, rotor)
    damping = 2.0 * shape["zeta"] * float(np.sqrt(shape["K"] * inertia))
    spring = JointSpring(j, shape["K"], damping, rotor)
    starts = []
    for h in bodies:
        beta = state.fit.beta.copy()
        beta[: len(h)] = h
        starts.append((beta, spring))
    fitted = _followed(Flexible(state, j, but=index), starts)
    if fitted is None:
        return None
    out = state.copy()
    out.problem = out.problem.with_term(index, _term(state, term.effect, fitted))
    out.look_through(fitted.beta)
    out.refit()
    return out


def _starts(state: SearchState, guess: Guess) -> list[tuple[Array, JointSpring]]:
    """Bodies from the torque that passed, those of the robot's file, and the model's own."""
    spring = JointSpring(guess.joint, guess.stiffness, guess.damping, guess.rotor)
    filed = guess.beta.copy()
    filed[: len(state.model.h)] = state.model.base.of(state.model.robot.parameters)
    return [(beta, spring) for beta in (guess.beta, filed, state.fit.beta)]


def _followed(model: Flexible, starts: Sequence[tuple[Array, JointSpring]]) -> SpringFit | None:
    """The best end of some steps from each start, and of more from the best."""
    few, many = SPRING_STEPS
    ends = []
    for beta, spring in starts:  # where the link would run away, a stiffer gear may hold it
        stiffer = replace(spring, stiffness=SPRING_HOLDS * spring.stiffness)
        ends.append(model.fit(beta, spring, few) or model.fit(beta, stiffer, few))
    reached = [e for e in ends if e is not None]
    if not reached:
        return None
    best = min(reached, key=lambda e: e.left)
    return model.fit(best.beta, best.spring, many)


def _with_spring(state: SearchState, kind: Effect, fitted: SpringFit) -> SearchState:
    out = state.copy()
    out.push(_term(state, kind, fitted))
    out.refit()
    out.look_through(np.append(fitted.beta, 1.0))
    out.refit()
    return out


def _term(state: SearchState, kind: Effect, fitted: SpringFit) -> Term:
    spring = fitted.spring
    zeta = zeta_of(state, fitted.beta[: len(state.model.h)], spring)
    values = {"K": spring.stiffness, "zeta": zeta}
    if spring.joint in state.train.contexts[0].rotor_in_load:
        values["rotor"] = spring.rotor
    bounds = {s.name: s for s in kind.shapes}
    shape = {
        name: float(np.clip(value, bounds[name].lower, bounds[name].upper))
        for name, value in values.items()
    }
    return Term(kind.id, (spring.joint,), np.ones(1), shape)
