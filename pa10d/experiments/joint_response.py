"""What joints are like, from the torques that were sent and the angles that came back.

Friction by least squares on sliding samples; inertia, delay and spring from the frequency response
at the lines of the small torques, in closed loop with a known excitation (Pintelon & Schoukens,
System Identification: A Frequency Domain Approach, 2012): output over input at each line, both as
measured, so that the servo does not matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.control.gains import BUS_DELAY
from pa10d.control.joint_figures import JointFigures
from pa10d.control.servo_design import Case
from pa10d.experiments.felt_bodies import ByWeight
from pa10d.experiments.sliding import Friction, Sway

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SMOOTH = 10.0  # Hz below which friction is looked for
SLIDES = 0.01  # rad/s: slower is stuck
FEWEST = 30  # samples that slide
SURELY = 2.0  # standard errors
DRIFT = 2  # degree of what a window has beside the lines
ALIKE = 0.05  # of a response: what no model of ours explains
PRIOR = 0.6  # how far, as a logarithm, a link may be from what the URDF says
ROTORS = (
    2.0  # … and a rotor from the usual size: those of the PUMA 560 are 4 to 17 times the PA10's
)
# beside their torque, those of the LWR 4 4 to 12 times
ELSEWHERE = 0.1  # of an inertia, by which a link that one factor describes is other in each pose
STEEPEST = 5.0  # times the URDF's slope, of either sign
SLOPE = 1.0  # by which gravity's slope may differ from the URDF's, of it: masses are rough, too
LONGEST = 0.03  # s of delay beyond the loop's own; half a period less may be, too
USUAL_DELAY = 0.003  # s: current loops and torque filters take as long; lines that are hidden by a
# sway say nothing of it, and what they leave open was taken for more than a period
SEEN = 0.1  # how far, as a logarithm, a sway may be from where it was seen
FELT = 0.15  # … its stiffness, rotor and link
SPRINGY = 5.0  # by which a spring has to lower the misfit, times ln of the number of points
DOUBT = (1.25, 3.0)  # least and most
MISFIT = 0.25  # of doubt, for a misfit as large as its errors


def friction_of(q: Array, torque: Array, rate: float, inertia: float) -> Friction:
    """From angle and sent torque (N,) of one joint that went to and fro slowly.

    torque = J·ddq + B·dq + C·sgn(dq) + g0 + g1·q where it slides; J is not asked, it acts little.
    """
    low = scipy.signal.butter(2, min(SMOOTH, 0.2 * rate), fs=rate, output="sos")
    angle, effort = (scipy.signal.sosfiltfilt(low, x) for x in (q, torque))
    speed = np.gradient(angle, 1.0 / rate)
    rise = np.gradient(speed, 1.0 / rate)
    slides = np.abs(speed) > SLIDES
    moved, reach = float(np.ptp(q)), 0.5 * float(np.ptp(effort))
    both = min((slides & (speed > 0)).sum(), (slides & (speed < 0)).sum())
    few = FEWEST * rate / 500.0
    wanted = (effort - inertia * rise)[slides]
    if both < few <= slides.sum():
        alike = max(rate / (2.0 * SMOOTH), 1.0)
        return _one_way(speed[slides], q[slides], wanted, alike, (moved, reach))
    if both < few:
        return Friction(reach, 0.0, moved, reach)
    columns = np.stack([np.sign(speed), speed, np.ones_like(q), q - q.mean()], axis=1)[slides]
    scale = np.linalg.norm(columns, axis=0)
    lower = np.array([0.0, 0.0, -np.inf, -np.inf])
    found = scipy.optimize.lsq_linear(columns / scale, wanted, bounds=(lower, np.inf)).x / scale
    return Friction(float(found[0]), float(found[1]), moved, reach)


def _one_way(
    speed: Array, q: Array, wanted: Array, alike: float, seen: tuple[float, float]
) -> Friction:
    """Of a joint that stuck the other way: what torque rises by with speed is viscous friction all
    the same, the least of it that may be; what it bore meanwhile nobody knows, and all else that it
    took is dry friction. alike: rows that err alike; seen: rad that it moved, N·m that it took."""
    way = np.sign(speed.sum())
    side = speed * way > 0.0
    fast, at, taken = speed[side] * way, q[side], wanted[side] * way
    columns = np.stack([fast, np.ones_like(at), at - at.mean()], axis=1)
    found = np.asarray(np.linalg.lstsq(columns, taken, rcond=None)[0], dtype=float)
    left = taken - columns @ found
    doubt = alike * float(left @ left) / len(taken) * np.linalg.pinv(columns.T @ columns)[0, 0]
    viscous = max(float(found[0] - SURELY * np.sqrt(doubt)), 0.0)
    moved, reach = seen
    dry = max(reach - 0.5 * viscous * float(fast.max()), 0.0)
    return Friction(dry, viscous, moved, reach)


@dataclass(frozen=True)
class Response:
    """rad per N·m at lines (K,) Hz and its relative error (K,); kg·m² that the URDF has there, and
    N·m/rad by which its gravity pulls the joint away, negative where it hangs."""

    lines: Array
    value: Complex
    error: Array
    inertia: float = 0.0
    gravity: float = 0.0


def response_of(
    q: Array,
    torque: Array,
    rate: float,
    lines: Array,
    noise: tuple[float, float],
    j: int,
    mass: Array,
) -> Response:
    """Of joint j, from whole periods of angles (W, N, n) and its sent torque (W, N); noise: N·m of
    the torque and rad of the angle, by their steps; mass: (n, n) kg·m² of the links.

    Windows are averaged as cross spectra; what differs between them is error, and so is what
    depends on how much is taken for drift: a link that rings slowly looks like the lowest lines.
    What the servo makes of steps of the angle is no response: a line that moves the joint by little
    more than these tells the servo, not the joint.
    What the other joints' giving way takes of the torque is taken off it: M_jk times their
    acceleration.
    """
    windows, count = torque.shape
    angle, effort = _at_lines(q, torque, rate, lines, j, mass, DRIFT)
    power = (np.abs(effort) ** 2).sum(axis=0)
    value = (angle * effort.conj()).sum(axis=0) / power
    differ = np.sqrt((np.abs(angle - value * effort) ** 2).sum(axis=0) / max(windows - 1, 1))
    small = np.maximum(np.abs(value) * np.sqrt(power / windows), 1e-300)
    each = np.sqrt(3.0 / count)  # of white noise that a line has, Hann's window
    steps = noise[0] * each / np.sqrt(power / windows)
    shaky = noise[1] * each
    grains = shaky / np.maximum(small - SURELY * shaky, 1e-3 * shaky + 1e-300)
    also, by = _at_lines(q, torque, rate, lines, j, mass, DRIFT + 1)
    otherwise = (also * by.conj()).sum(axis=0) / np.maximum((np.abs(by) ** 2).sum(axis=0), 1e-300)
    leaks = np.abs(otherwise - value) / np.maximum(np.abs(value), 1e-300)
    differs = differ / small / np.sqrt(windows)
    error = np.sqrt(differs**2 + steps**2 + grains**2 + ALIKE**2 + leaks**2)
    return Response(lines, value, error)


def _at_lines(
    q: Array, torque: Array, rate: float, lines: Array, j: int, mass: Array, drift: int
) -> tuple[Complex, Complex]:
    """Angle and torque of joint j (W, K), without a polynomial of this degree."""
    count = torque.shape[1]
    slow = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, count), drift)
    apart = np.eye(count) - slow @ np.linalg.pinv(slow)
    at = np.outer(lines, np.arange(count) / rate)
    waves = np.exp(-2j * np.pi * at) * scipy.signal.windows.hann(count, sym=False) * 4.0 / count
    angles = np.einsum("wtj,ts,ks->wkj", q, apart, waves, optimize=True)
    effort = torque @ apart @ waves.T
    others = np.delete(np.arange(q.shape[2]), j)
    given = (2 * np.pi * lines) ** 2 * (angles[:, :, others] @ mass[j, others])
    return angles[:, :, j], effort + given


@dataclass(frozen=True)
class Fitted:
    """kg·m², factor, N·m·s/rad, s, N·m/rad (inf: rigid); misfit: RMS in units of the errors."""

    rotor: float
    link: float
    viscous: float
    delay: float
    stiffness: float
    misfit: float


def fitted_response(
    seen: Sequence[Response],
    rotor: float,
    viscous: float,
    rate: float,
    sway: Sway | None = None,
    weight: ByWeight | None = None,
    softest: float = 0.0,
) -> Fitted:
    """One joint in one or more poses: rotor + link × the URDF's inertia, rigid or with a spring.

    rotor, viscous: what is thought. A spring is believed where it lowers the misfit much.
    Gravity's slope is fitted along: a link that hangs swings at a line as behind a soft spring.
    weight: in the same poses; without it the two inertias cannot be told apart from one pose, and
    stay in the ratio that is thought. softest: N·m/rad, less is no gear's, but lines that
    contradict what slow torques told.
    sway: of the first of these poses, where a link was seen to sway behind a spring: slower than
    the lines, it is in none of them, and without it they show a light rigid joint.
    """
    start = np.log([max(rotor, 1e-9), 1.0])
    friction = np.log(max(viscous, 1e-2 * rotor))
    apart = np.array([PRIOR if weight is None else ROTORS, PRIOR])

    def misfit(x: Array) -> Array:
        known = (x[:2] - start) / apart
        known *= np.sqrt(1.0 + known**2 / 4.0)  # squared by the loss: no line outweighs them
        parts = [known, (x[2:3] - friction) / PRIOR, x[3:4] / USUAL_DELAY]
        parts.append((x[4:5] - 1.0) / SLOPE)
        for one in seen:
            off = np.log(one.value / _model(x, one, rate)) / one.error
            parts += [off.real, off.imag]
        if sway is not None:
            parts.append(_off_sway(x, seen[0], sway))
        if weight is not None:
            parts.append(_off_weight(x, seen, weight))
        return np.concatenate(parts)

    reach = np.maximum(3.0 * apart, 4.0)
    low = [*(start - reach), friction - 3.0, -0.5 / rate, -STEEPEST]
    high = [*(start + reach), friction + 3.0, LONGEST, STEEPEST]
    begins = [start] if weight is None else [start, _begun(start, reach, seen, weight)]
    firsts = [np.array([*begin, friction, 1e-4, 1.0]) for begin in begins]
    points = 2 * sum(len(one.lines) for one in seen)
    swings = 2.0 * np.log(2 * np.pi * np.geomspace(seen[0].lines[0], 0.7 * seen[0].lines[-1], 4))
    # where the rotor swings on the spring, or the link does and keeps the rotor still
    springs = [*(swings + start[0]), *(swings + np.log(max(seen[0].inertia, rotor)))]
    if sway is None:
        best = min(
            (
                scipy.optimize.least_squares(misfit, first, bounds=(low, high), loss="soft_l1")
                for first in firsts
            ),
            key=lambda one: one.cost,
        )
        chosen, cost = best.x, best.cost - 0.5 * SPRINGY * np.log(points)
        first = np.array([*(best.x[:2] if len(firsts) > 1 else start), *firsts[0][2:]])
    else:
        first, cost, springs = firsts[0], np.inf, [float(np.log(sway.stiffness))]
        chosen = first
    for stiffness in springs:
        ends = [*low, stiffness - 3.0], [*high, stiffness + 3.0]
        tried = scipy.optimize.least_squares(
            misfit, [*first, stiffness], bounds=ends, loss="soft_l1"
        )
        if tried.cost < cost and (sway is not None or np.exp(tried.x[5]) >= softest):
            chosen, cost = tried.x, tried.cost
    inertia, link, damping = (float(np.exp(v)) for v in chosen[:3])
    stiffness = float(np.exp(chosen[5])) if len(chosen) > 5 else np.inf
    left = float(np.sqrt(2 * max(cost, 0.0) / points))
    return Fitted(inertia, link, damping, float(chosen[3]), stiffness, left)


def _off_sway(x: Array, one: Response, sway: Sway) -> Array:
    """What was seen of a sway against what this joint would do, in units of its errors."""
    rotor, stiffness = (float(np.exp(v)) for v in (x[0], x[5]))
    link, left = float(np.exp(x[1])) * one.inertia, stiffness - float(x[4]) * one.gravity
    swings = np.log(max(left, 1e-3 * stiffness) / link) - 2.0 * np.log(2.0 * np.pi * sway.hertz)
    felt = np.log(
        [stiffness / sway.stiffness, rotor / max(sway.rotor, 1e-3 * rotor), link / sway.link]
    )
    return np.array([0.5 * swings / SEEN, *(felt / FELT)])


def _begun(start: Array, reach: Array, seen: Sequence[Response], weight: ByWeight) -> Array:
    """Logarithms of rotor and link as slow torques tell them."""
    rotor, link = np.exp(start[0]), weight.likeliest[0] / max(seen[0].inertia, 1e-12)
    told = np.log([max(float(weight.likeliest[-1]), rotor), max(link, 1e-3)])
    return np.asarray(np.clip(told, start - 0.9 * reach, start + 0.9 * reach))


def _off_weight(x: Array, seen: Sequence[Response], weight: ByWeight) -> Array:
    """What slow torques told against what this joint would be, in units of their errors."""
    links = np.exp(x[1]) * np.array([one.inertia for one in seen])
    spread = weight.spread + np.diag((ELSEWHERE * np.append(links, 0.0)) ** 2)
    root = np.linalg.cholesky(spread)
    off = np.append(links, np.exp(x[0])) - weight.likeliest
    return np.asarray(np.linalg.solve(root, off), dtype=float)


def _model(x: Array, one: Response, rate: float) -> Complex:
    """x: logarithms of rotor, link, viscous; delay; factor on gravity's slope; logarithm of
    stiffness where there is one."""
    spring = (float(np.exp(x[0])), float(np.exp(x[5]))) if len(x) > 5 else (0.0, np.inf)
    inertia, pull = float(np.exp(x[0]) + np.exp(x[1]) * one.inertia), float(x[4]) * one.gravity
    case = Case(inertia, float(np.exp(x[2])), *spring, gravity=pull)
    s = np.asarray(2j * np.pi * one.lines, dtype=np.complex128)
    return np.asarray(case.response(s) * np.exp(-s * (BUS_DELAY / rate + x[3])))


def by_weight_alone(weight: ByWeight, inertia: float, viscous: float) -> Fitted | None:
    """Of a joint that slid in no stroke, in its first pose, where the URDF has ``inertia``; None
    where that tells no more than the URDF."""
    link, rotor = float(weight.likeliest[0]), max(float(weight.likeliest[-1]), 0.0)
    ends = np.eye(len(weight.likeliest))[[0, -1]].sum(axis=0)
    doubt = float(np.sqrt(ends @ weight.spread @ ends)) / max(link + rotor, 1e-12)
    if link * (1.0 - doubt) <= 0.0 or 1.0 + SURELY * doubt >= DOUBT[1]:
        return None
    return Fitted(rotor, link / inertia, viscous, 0.0, np.inf, SURELY * doubt / MISFIT)


def with_friction(figures: JointFigures, found: dict[int, Friction]) -> JointFigures:
    """The same joints, their friction as it was found; joints are 0-based."""
    coulomb, viscous = figures.coulomb.copy(), figures.viscous.copy()
    for j, friction in found.items():
        coulomb[j], viscous[j] = friction.coulomb, friction.viscous
    return figures.but(coulomb=coulomb, viscous=viscous)


def with_response(figures: JointFigures, found: dict[int, Fitted]) -> JointFigures:
    """The same joints with inertia, delay and spring as they were found."""
    names = ("rotor", "link", "delay", "stiffness", "motor", "doubt")
    values = {name: getattr(figures, name).copy() for name in names}
    for j, fit in found.items():
        values["rotor"][j], values["link"][j] = fit.rotor, fit.link
        values["delay"][j], values["stiffness"][j] = fit.delay, fit.stiffness
        values["motor"][j] = fit.rotor if np.isfinite(fit.stiffness) else 0.0
        values["doubt"][j] = np.clip(1.0 + MISFIT * fit.misfit, *DOUBT)
    return figures.but(**values)
