"""From the runs of a first motion to what each joint is like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.words import of_a_slide
from pa10d.control.gains import PidGains, burdens, gravity_slope
from pa10d.control.joint_figures import ROUGH, JointFigures, inertias, likely_figures
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.dynamics.mass import mass_matrices
from pa10d.experiments.felt_bodies import felt_bodies, told_by_weight
from pa10d.experiments.joint_response import (
    Response,
    by_weight_alone,
    fitted_response,
    friction_of,
    response_of,
    with_friction,
    with_response,
)
from pa10d.experiments.seen import Seen, Stroke
from pa10d.experiments.shaking import lines_of
from pa10d.experiments.sliding import Friction, Sway, own_sways, slid_friction
from pa10d.trajectory.kinds.first_motion import ALL_JOINTS, NUDGE

Array = NDArray[np.float64]

AROUND = 0.2  # s before and after a stroke that belong to it
FEW = 0.7  # of a viscous friction that was seen in a few moments of sliding
HALF_KNOWN = 2.0  # doubt of inertias where friction is known to damp
SOFTEST = 0.25  # of the torque limit, per rad: a gear that gave way by more would be none
FINEST = 1e-9  # rad: less is how numbers are stored
MOST_WOUND = 0.5  # rad by which a load winds a gear: harmonic drives give by 0.01, springs by 0.2
BLOCKED = 0.25  # of the way that a joint should have gone to either side


def measured_figures(
    robot: Robot, parts: Mapping[str, Seen], step: Array, before: JointFigures | None = None
) -> JointFigures:
    """What is known after these parts, ``friction`` first. step: (n,) N·m, the torque's own;
    before: what was presumed, of an arm that stays about one place until ``response`` is known."""
    presumed = likely_figures(robot)
    nudged = _together(parts["friction"])
    parts = {**parts, "friction": nudged}
    usual = inertias(robot, presumed).usual
    friction = {
        j: friction_of(nudged.q[:, j], nudged.torque[:, j], nudged.rate, float(usual[j]))
        for j in range(robot.n)
    }
    _refuse_blocked(friction)
    seen = [(one.q, one.torque, one.rate) for one in parts.values()]
    if "sliding" in parts and "response" not in parts:
        friction |= {
            j: replace(friction[j], viscous=found.viscous)
            for j in range(robot.n)
            if (found := _slid_shortly(parts["sliding"], robot, j, friction[j].coulomb))
        }
    if "response" not in parts:
        surer = {j: replace(f, viscous=FEW * f.viscous) for j, f in friction.items()}
        half = with_friction(presumed.but(doubt=HALF_KNOWN * np.ones(robot.n)), surer)
        about = presumed.about if before is None else before.about
        return half.but(bodies=felt_bodies(robot, half, seen), about=about)
    slid = {j: _slid(parts, robot, j, friction[j].coulomb) for j in range(robot.n)}
    friction |= {j: found for j, (found, _) in slid.items()}
    sways = own_sways({j: sway for j, (_, sway) in slid.items() if sway is not None})
    rubbing = with_friction(presumed, friction)
    softest = burdens(robot, presumed) / MOST_WOUND
    weights = told_by_weight(robot, rubbing, seen, _shaken_at(parts, robot.n))
    responses = {j: found for j in range(robot.n) if (found := _responses(robot, parts, step, j))}
    fits = {
        j: fitted_response(
            [one for _, one in found],
            float(presumed.rotor[j]),
            friction[j].viscous,
            nudged.rate,
            sways.get(j),
            None if j in sways else weights[j].of([k for k, _ in found]),
            float(softest[j]),
        )
        for j, found in responses.items()
    }
    for j in set(weights) - set(fits) - set(sways):
        pose = _shaken_at(parts, robot.n)[j][0]
        own = float(own_inertia(robot, pose[None])[j])
        if (alone := by_weight_alone(weights[j], own, friction[j].viscous)) is not None:
            fits[j] = alone
    whole = with_response(rubbing, fits)
    shaken = [(j, one.q[-1]) for j in responses for one in _strokes(parts, j, "shaken")]
    return whole.but(bodies=felt_bodies(robot, whole, seen, shaken))


def _together(one: Seen) -> Seen:
    """Without the first steps, which only show that each torque moves its own joint."""
    begin = [span.begin for span in one.plan.spans if span.label == ALL_JOINTS]
    cut = slice(int(begin[0] * one.rate) if begin else 0, None)
    return replace(one, q=one.q[cut], torque=one.torque[cut])


def felt_again(
    robot: Robot, figures: JointFigures, parts: Mapping[str, Seen], more: Sequence[Seen]
) -> JointFigures:
    """The same joints, their bodies as ``more`` motions felt them, too."""
    seen = [(one.q, one.torque, one.rate) for one in (*parts.values(), *more)]
    shaken = [(j, one.q[-1]) for j in range(robot.n) for one in _strokes(parts, j, "shaken")]
    return figures.but(bodies=felt_bodies(robot, figures, seen, shaken))


def felt_on_the_way(robot: Robot, one: Seen, before: JointFigures) -> JointFigures:
    """What is known of bodies after a ``friction`` part that a joint ended by falling behind. What
    a joint rubbed by counts as doubt alone: it may be all of the torque that it stuck under."""
    usual = inertias(robot, likely_figures(robot)).usual
    rubbed = {
        j: friction_of(one.q[:, j], one.torque[:, j], one.rate, float(usual[j]))
        for j in range(robot.n)
    }
    felt = felt_bodies(robot, with_friction(before, rubbed), [(one.q, one.torque, one.rate)])
    here = one.q[-1:]
    heavier = own_inertia(replace(robot, parameters=felt[0]), here) / own_inertia(robot, here)
    return before.but(bodies=felt, link=np.clip(heavier, 1.0 / ROUGH, ROUGH))


def rubbed_on_the_way(robot: Robot, one: Seen, axis: int, before: JointFigures) -> JointFigures:
    """What is known of the friction of one joint (0-based) that fell behind in its strokes: as much
    more of the viscous as they showed until then. Dry friction is known by slower motions."""
    q, torque = one.q[:, axis], one.torque[:, axis]
    dry, known = float(before.coulomb[axis]), float(before.viscous[axis])
    softest = SOFTEST * robot.effort[axis] if np.isfinite(robot.effort[axis]) else 0.0
    slid = slid_friction(q, torque, one.rate, softest, dry)
    usual = float(inertias(robot, before).usual[axis])
    found = friction_of(q, torque, one.rate, usual) if slid is None else slid[0]
    viscous = before.viscous.copy()
    viscous[axis] = max(known, FEW * found.viscous)
    return before.but(viscous=viscous)


def weighed_more(robot: Robot, q: Array, felt: JointFigures, before: JointFigures) -> Array:
    """(n,) N·m at most, by which bodies as they are felt now weigh other than before, in poses q
    (N, n) and beyond what was lacking in the first of them."""
    still = np.zeros_like(q)
    now, then = (inverse_dynamics(robot, one.bodies[0], q, still, still) for one in (felt, before))
    return np.abs((now - then) - (now - then)[0]).max(axis=0)


def own_inertia(robot: Robot, q: Array) -> Array:
    """(n,) kg·m² of links about their joints in one pose (1, n), with a trifle where there are
    none."""
    own = np.diagonal(mass_matrices(robot, q)[0])
    return np.asarray(np.maximum(own, 1e-9))


LOWERED = 0.9  # of the bandwidth asked for: less is worth a sentence


def sentences(robot: Robot, figures: JointFigures, gains: PidGains) -> list[str]:
    """One line a joint, for a person."""
    span = inertias(robot, figures)
    resonance = figures.resonance(span.usual)
    lines = []
    for j in range(robot.n):
        spring = ""
        if np.isfinite(figures.stiffness[j]):
            spring = f", a spring of {figures.stiffness[j]:.3g} N·m/rad ({resonance[j]:.2g} Hz)"
        # of a joint that stuck in each of its strokes nothing else is known
        unit = "kg·m² (by the URDF)" if figures.doubt[j] >= ROUGH else "kg·m²"
        said = (
            f"joint {j + 1}: inertia {span.light[j]:.2g} … {span.heavy[j]:.2g} {unit}, friction "
            f"{figures.coulomb[j]:.2g} N·m + {figures.viscous[j]:.2g} N·m·s/rad{spring}; "
            f"kp {gains.kp[j]:.3g}, ki {gains.ki[j]:.3g}, kd {gains.kd[j]:.3g}"
        )
        lines.append(of_a_slide(said) if robot.prismatic[j] else said)
    return lines


def bandwidths(robot: Robot, figures: JointFigures, gains: PidGains) -> Array:
    """(n,) Hz that these gains give each joint, where the rule's three poles are in one place."""
    return np.asarray(np.sqrt(gains.kp / (3.0 * inertias(robot, figures).usual)) / (2.0 * np.pi))


def lowered(asked: float, given: Sequence[float], usual: bool = False) -> str | None:
    """Whose servo is slower than was ``asked`` for, Hz, in a sentence; None: no joint's. usual:
    nobody asked, it is what a loop at this rate may have."""
    slower = {j: hz for j, hz in enumerate(given, 1) if hz < LOWERED * asked}
    if not slower:
        return None
    each = ", ".join(f"joint {j}: {hz:.2g} Hz" for j, hz in slower.items())
    than = f"usual {asked:.3g} Hz" if usual else f"{asked:.3g} Hz asked for"
    fine = "nothing is wrong with that, but " if usual else ""
    return (
        f"The servo is slower than the {than}, so that no joint swings ({each}): {fine}fast "
        "motions are followed less closely, and may be slowed."
    )


def _refuse_blocked(found: Mapping[int, Friction]) -> None:
    stuck = [j for j, one in found.items() if one.moved < BLOCKED * NUDGE]
    if stuck:
        named = ", ".join(f"joint {j + 1} (±{found[j].effort:.3g} N·m)" for j in stuck)
        raise UserError(
            f"{named}: did not move; look at its brake, at what it touches, and at its rated_torque"
        )


def _strokes(parts: Mapping[str, Seen], j: int, *kinds: str) -> list[Stroke]:
    """Of joint j (0-based), those in which it slid all the way."""
    every = [one for seen in parts.values() for one in seen.strokes(j)]
    return [one for one in every if one.what in kinds and one.slid]


def _here(parts: Mapping[str, Seen]) -> dict[str, Seen]:
    """Those about the first pose."""
    return {name: seen for name, seen in parts.items() if name != "poses"}


def _slid(
    parts: Mapping[str, Seen], robot: Robot, j: int, dry: float
) -> tuple[Friction, Sway | None]:
    """From all strokes about the first pose; where they stuck to one side, from whatever slid."""
    seen = parts["response"]
    spans = [span for span in seen.plan.spans if span.label.startswith(f"joint {j + 1} ")]
    cut = seen.between(spans[0].begin - AROUND, spans[-1].end + AROUND)
    q, torque = seen.q[cut, j], seen.torque[cut, j]
    softest = SOFTEST * robot.effort[j] if np.isfinite(robot.effort[j]) else 0.0
    if (found := slid_friction(q, torque, seen.rate, softest, dry)) is not None:
        return found
    own = likely_figures(robot).rotor[j] + mass_matrices(robot, seen.q[cut][:1])[0, j, j]
    return friction_of(q, torque, seen.rate, float(own)), None


def _slid_shortly(seen: Seen, robot: Robot, j: int, dry: float) -> Friction | None:
    """From the short strokes of joint j (0-based); None where it has none, or stuck in them."""
    spans = [span for span in seen.plan.spans if span.label == f"joint {j + 1} short"]
    if not spans:
        return None
    cut = seen.between(spans[0].begin - AROUND, spans[-1].end + AROUND)
    softest = SOFTEST * robot.effort[j] if np.isfinite(robot.effort[j]) else 0.0
    found = slid_friction(seen.q[cut, j], seen.torque[cut, j], seen.rate, softest, dry)
    return None if found is None else found[0]


def _counts(q: Array) -> float:
    """rad between two angles (N,) that are told apart."""
    apart = np.diff(np.unique(q))
    apart = apart[apart > FINEST]
    return float(apart.min()) if len(apart) else 0.0


def _places(parts: Mapping[str, Seen]) -> list[dict[str, Seen]]:
    """Those about the first pose, and the others."""
    here = _here(parts)
    return [here, {name: seen for name, seen in parts.items() if name not in here}]


def _shaken_at(parts: Mapping[str, Seen], n: int) -> dict[int, list[Array]]:
    """(n,) rad each, the poses in which joints were shaken, whether they slid or stuck."""
    found: dict[int, list[Array]] = {j: [] for j in range(n)}
    for about in _places(parts):
        for j, poses in found.items():
            strokes = [one for seen in about.values() for one in seen.strokes(j)]
            poses += [one.q[-1] for one in strokes if one.what == "shaken"][:1]
    return {j: poses for j, poses in found.items() if poses}


def _responses(
    robot: Robot, parts: Mapping[str, Seen], step: Array, j: int
) -> list[tuple[int, Response]]:
    """Of joint j, one per pose in which it slid, and which one; the strokes to and fro of a pose
    belong together."""
    found, rate, pose = [], parts["response"].rate, -1
    for about in _places(parts):
        strokes = [one for seen in about.values() for one in seen.strokes(j)]
        pose += any(one.what == "shaken" for one in strokes)
        if not (taken := _strokes(about, j, "shaken")):
            continue
        q, torque = np.array([one.q for one in taken]), np.array([one.torque for one in taken])
        noise = float(step[j]) / np.sqrt(12.0), _counts(parts["response"].q[:, j]) / np.sqrt(12.0)
        mass = mass_matrices(robot, q[:1, -1])[0]
        response = response_of(q, torque, rate, lines_of(rate), noise, j, mass)
        slope = gravity_slope(robot, robot.parameters, q[:1, -1])[0]
        one = replace(response, inertia=float(mass[j, j]), gravity=float(slope[j]))
        found.append((pose, one))
    return found
