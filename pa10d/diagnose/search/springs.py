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
    MATERIAL_REST,
    SPRING_HOLDS,
    SPRING_NEARLY,
    SPRING_ONE,
    SPRING_STEPS,
    SPRINGS_FOLLOWED,
)
from pa10d.diagnose.regression.flexible import (
    Flexible,
    JointSpring,
    SpringFit,
    Springs,
    zeta_of,
)
from pa10d.diagnose.regression.passed import Guess, guesses
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.harm import rms
from pa10d.effects import Effect
from pa10d.effects.rotor import typical_link
from pa10d.model import Term

Array = NDArray[np.float64]
Place = tuple[Effect, tuple[int, ...]]
Starts = Sequence[tuple[Array, JointSpring]]


def promising(state: SearchState, suspects: Sequence[Place], least: float) -> list[Guess]:
    """The joints where one spring more promises to take more than ``least`` (weighted squared error
    of the fit side)."""
    places = _open(state, suspects)
    if not places or state.frozen:
        return []
    return [g for g in guesses(state, sorted(places)) if g.gain > least and g.drop > MATERIAL_GAIN]


def with_springs(
    state: SearchState, suspects: Sequence[Place], guessed: Sequence[Guess], floor: Array | None
) -> tuple[list[SearchState], set[int]]:
    """States with one of these springs more, of which the one that leaves least comes first; and
    the joints that were followed: those that promise most, and all that promise nearly as much
    as long as what was found leaves more than the noise (floor, (n,) N·m, where it is known)."""
    places, followed = _open(state, suspects), set[int]()
    found: list[tuple[float, SearchState]] = []
    for guess in guessed:
        if len(followed) >= SPRINGS_FOLLOWED and (
            guess.gain < SPRING_NEARLY * guessed[0].gain
            or any(_at_noise(new, floor) for _, new in found)
        ):
            break
        followed.add(guess.joint)
        new = _with_spring(state, places[guess.joint], *_starts(state, guess))
        found += [] if new is None else [new]
    return [s for _, s in sorted(found, key=lambda pair: pair[0])], followed


def _at_noise(state: SearchState, floor: Array | None) -> bool:
    """Does no joint keep materially more than its noise? Of noise that is not known none does."""
    left = rms(state.held_residual())
    return floor is None or not np.any(left > MATERIAL_REST * floor)


def _open(state: SearchState, suspects: Sequence[Place]) -> dict[int, Effect]:
    """By joint, the spring that it may have and has not."""
    there = {t.joints for t in state.terms if t.effect.series_spring}
    return {j[0]: kind for kind, j in suspects if kind.series_spring and j not in there}


def with_firm_spring(
    state: SearchState, suspects: Sequence[Place], joint: int
) -> list[SearchState]:
    """The state with a spring more in this joint, if there can be one: of a mode beyond those that
    the motion drives, to which no measured torque can be wound, so that nothing is guessed."""
    kinds = [kind for kind, at in suspects if kind.series_spring and at == (joint,)]
    there = any(t.effect.series_spring and t.joints == (joint,) for t in state.terms)
    if not kinds or there or state.frozen:
        return []
    new = _with_spring(state, kinds[0], _firm_starts(state, joint))
    return [] if new is None else [new[1]]


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


def follow(state: SearchState, bodies: Sequence[Array]) -> SearchState | None:
    """The state with all of its springs and all else fitted at once, from any of these base
    parameters; None where none of them leads anywhere."""
    springs = _there(state)
    starts = []
    for h in bodies:
        beta = state.fit.beta.copy()
        beta[: len(h)] = h
        starts.append((beta, tuple(springs.values())))
    fitted = _followed(state, starts)
    return None if fitted is None else _through(state, fitted)


def _there(state: SearchState) -> dict[int, JointSpring]:
    """By the index of its term, each spring that the model has."""
    out = {}
    for index, term in enumerate(state.terms):
        if term.effect.series_spring:
            j, shape, rotor = term.joints[0], term.shape, term.shape.get("rotor", 0.0)
            inertia = typical_link(state.train.contexts[0], j, rotor)
            damping = 2.0 * shape["zeta"] * float(np.sqrt(shape["K"] * inertia))
            out[index] = JointSpring(j, shape["K"], damping, rotor)
    return out


def _starts(state: SearchState, guess: Guess) -> tuple[Starts, Starts]:
    """Bodies from the torque that passed, those of the robot's file, and the model's own. How much
    of an inertia is the rotor's that torque hardly says, and along a stiffness that grows as the
    rotor gets lighter a fit moves slowly: otherwise it is begun from a lighter one."""
    spring = JointSpring(guess.joint, guess.stiffness, guess.damping, guess.rotor)
    filed = guess.beta.copy()
    filed[: len(state.model.h)] = state.model.base.of(state.model.robot.parameters)
    starts = [(beta, spring) for beta in (guess.beta, filed, state.fit.beta)]
    stiffer, lighter = SPRING_HOLDS * spring.stiffness, FIRM_ROTOR * spring.rotor
    other = replace(spring, stiffness=stiffer, rotor=lighter)
    return starts, [(beta, other) for beta in (guess.beta, filed) if spring.rotor]


def _followed(
    state: SearchState,
    starts: Sequence[tuple[Array, Springs]],
    otherwise: Sequence[tuple[Array, Springs]] = (),
) -> SpringFit | None:
    """The best end of some steps from each start, and of more from the best; where a few steps from
    these do not lead to one spring, also otherwise. Springs of a start: those that the model has,
    after one more."""
    few, many = SPRING_STEPS
    model = Flexible(state, [s.joint for s in starts[0][1]], list(_there(state)))

    def begun(kind: Sequence[tuple[Array, Springs]]) -> list[SpringFit]:
        ends = []
        for beta, springs in kind:  # where the link would run away, a stiffer gear may hold it
            first = replace(springs[0], stiffness=SPRING_HOLDS * springs[0].stiffness)
            held = (first, *springs[1:])
            ends.append(model.fit(beta, springs, few) or model.fit(beta, held, few))
        return [e for e in ends if e is not None]

    def ended(reached: Sequence[SpringFit]) -> list[SpringFit]:
        best = min(reached, key=lambda e: e.left, default=None)
        end = None if best is None else model.fit(best.beta, best.springs, many)
        return [] if end is None else [end]

    reached = begun(starts)
    found = ended(reached)
    if otherwise and not _one_spring(reached):
        found += ended(begun(otherwise))
    return min(found, key=lambda e: e.left, default=None)


def _one_spring(reached: Sequence[SpringFit]) -> bool:
    """Did all that was begun come to one stiffness, as near as a few steps go?"""
    stiff = [e.springs[0].stiffness for e in reached]
    return bool(stiff) and max(stiff) < (1.0 + SPRING_ONE) * min(stiff)


def _with_spring(
    state: SearchState, kind: Effect, starts: Starts, otherwise: Starts = ()
) -> tuple[float, SearchState] | None:
    """What is left of the fit side, and the state with one more spring beside those it has."""
    there = tuple(_there(state).values())
    fitted = _followed(
        state,
        [(beta, (spring, *there)) for beta, spring in starts],
        [(beta, (spring, *there)) for beta, spring in otherwise],
    )
    if fitted is None:
        return None
    out = state.copy()
    out.push(_term(state, kind, fitted.beta, fitted.springs[0]))
    out.refit()
    rest = replace(
        fitted,
        beta=np.append(fitted.beta, 1.0),
        springs=(*fitted.springs[1:], fitted.springs[0]),
    )
    return fitted.left, _through(out, rest)


def _through(state: SearchState, fitted: SpringFit) -> SearchState:
    """The state with its springs as they were fitted, seen through all that was fitted beside."""
    out, beta = state.copy(), fitted.beta.copy()
    for index, spring in zip(_there(state), fitted.springs, strict=True):
        term = _term(state, state.terms[index].effect, fitted.beta, spring)
        out.problem = out.problem.with_term(index, term)
        beta[out.place(index)] = 1.0
    out.look_through(beta)
    out.refit()
    return out


def _term(state: SearchState, kind: Effect, beta: Array, spring: JointSpring) -> Term:
    zeta = zeta_of(state, beta[: len(state.model.h)], spring)
    values = {"K": spring.stiffness, "zeta": zeta}
    if spring.joint in state.train.contexts[0].rotor_in_load:
        values["rotor"] = spring.rotor
    bounds = {s.name: s for s in kind.shapes}
    shape = {
        name: float(np.clip(value, bounds[name].lower, bounds[name].upper))
        for name, value in values.items()
    }
    return Term(kind.id, (spring.joint,), np.ones(1), shape)
