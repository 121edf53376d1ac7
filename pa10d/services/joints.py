"""What has been measured of an arm's joints: where it is kept, and what follows from it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from backends.bus_budget import profile_budget
from backends.scaling import scaling_of
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.words import listed, of_a_slide
from pa10d.control.faults import Fault
from pa10d.control.gains import (
    PUSH,
    PidGains,
    after_fall,
    after_swing,
    burdens,
    fitted_gains,
    lightly_pressed,
    pid_gains,
    pulls,
    with_rotor,
)
from pa10d.control.joint_figures import MEASURED, ROUGH, JointFigures, first_figures, inertias
from pa10d.control.known_joints import Calmer, KnownJoints, MeasuredJoints
from pa10d.control.limits import arm_limits
from pa10d.control.servo_design import SENSITIVITY, SLOW
from pa10d.dynamics import Robot
from pa10d.experiments.exchanged import alike, exchanged_drives
from pa10d.experiments.measured_joints import (
    bandwidths,
    felt_again,
    felt_on_the_way,
    measured_figures,
    rubbed_on_the_way,
    sentences,
    weighed_more,
)
from pa10d.experiments.mounting import leaning_mount, wrong_mount
from pa10d.experiments.seen import Seen
from pa10d.profile import Profile
from pa10d.services.library import Library, open_library
from pa10d.services.robots import load_robot
from pa10d.store.entries import read_entry
from pa10d.store.folders import write_json
from pa10d.store.location import data_folder
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.kinds.first_motion import PARTS, FirstMotion
from pa10d.trajectory.plan import Plan
from pa10d.trajectory.poses import Surroundings

Array = NDArray[np.float64]
Data = str | os.PathLike[str] | None

LARGEST = 4 << 20  # bytes of what is kept of an arm's joints
FASTER = (125.0, 200.0, 250.0, 333.0, 400.0, 500.0, 1000.0)  # Hz that are offered
SOFTEST = 0.01  # of the inertia that is known, that a swing may be explained by
EXPLAINS = 0.3  # of what pressed on a joint that fell behind: weight that was lacking on its way
VISCOUS = 4.0  # times its dry friction: viscous friction as large in strokes, what a servo gave
# the other way as it turns round, and as much again to move at all
FIRMER = 1.1  # times as firm: less is the same
NEARER = (2.0, 1.5, MEASURED)  # times lighter than is thought, that are met where more cannot be
SLOWER, SLOWEST = 0.5, 0.25  # share of the strokes' speed, at once and at last, where no gains help
UNSURE = (
    "at {:g} Hz not all that a URDF may be wrong by is held ({}): a lighter joint swings, and is "
    "named"
)


def kept_joints(data: Data, profile: Profile) -> MeasuredJoints | None:
    """What was measured of this profile's joints, or None; a file that is wrong counts as none.

    It holds for this arm only: see ``fingerprint``.
    """
    try:
        found = json.loads(read_entry(_place(data, profile), LARGEST))
        kept = MeasuredJoints.from_document(found)
        return kept if kept.fingerprint == fingerprint(profile) else None
    except (UserError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def fingerprint(profile: Profile) -> str:
    """Of all that the measured figures and their gains depend on."""
    parts = profile.model_dump(
        mode="json",
        include={"joints", "base", "gravity", "tool", "limits", "drives", "control", "safety"},
    )
    parts["urdf"] = hashlib.sha256(profile.urdf.read_bytes()).hexdigest()
    if profile.simulation is not None:
        parts["simulation"] = profile.simulation.model_dump(include={"plant", "options"})
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def parts_to_run(
    data: str, profile: str, parameters: JsonObject, at: Sequence[float] | None = None
) -> JsonObject:
    """The parts of a first motion that this arm has, what to begin with, and the gains before; or
    why nothing may begin. at: (n,) rad, where the arm stands."""
    found, robot = load_robot(profile)
    asked = read_request({"kind": "first_motion", "parameters": parameters})
    assert isinstance(asked, FirstMotion)
    around = Surroundings.of(robot)
    parts = [part for part in PARTS if asked.model_copy(update={"part": part}).has_any(around)]
    kept = kept_joints(data, found)
    before = kept.known.gains if kept else pid_gains(robot, found.control)
    home = asked.home(around)
    places = [home if at is None else at, home]
    begin, note = begun(found, robot, first_figures(robot, places))
    if (reason := not_held(found, robot, begin)) is not None:
        raise UserError(reason)
    told = {"begin": begin.document(), "before": before.document()}
    return {"parts": parts, **told, "notes": [note] if note else []}


def learn(data: str, profile: str, runs: Mapping[str, str], known: JsonObject) -> JsonObject:
    """Figures and gains from the parts recorded so far; known: what was learnt before them."""
    found, robot = load_robot(profile)
    library = open_library(data)
    seen = {part: _seen(library, found, run) for part, run in runs.items()}
    before = KnownJoints.from_document(known).figures
    figures = measured_figures(robot, seen, torque_steps(found, robot), before)
    told = [(one.q, one.torque, one.rate) for one in seen.values()]
    if (reason := wrong_mount(robot, figures, told)) is not None:
        raise UserError(reason)
    if (reason := exchanged_drives(robot, figures, told, alike(found))) is not None:
        raise UserError(reason)
    learned, _ = begun(found, robot, figures.after(before))
    if (reason := not_held(found, robot, learned)) is not None:
        raise UserError(reason)
    return learned.leaning(leaning_mount(robot, figures, told) or "").document()


def _seen(library: Library, profile: Profile, run: str) -> Seen:
    """A part of a first motion, as it was recorded."""
    stored = library.runs.read(library.runs.find(run))
    sent = stored.samples.commands
    if sent is None:
        raise UserError(f"run {run}: no commands in it; expected a run of a first motion")
    plan = json.loads(stored.metadata["pa10d.plan"]["plan"])
    part = plan["parameters"].get("part") if plan["kind"] == "first_motion" else None
    return Seen(Plan.from_dict(plan), profile.control.rate, stored.samples.q, sent.tau, part)


def begun(profile: Profile, robot: Robot, figures: JointFigures) -> tuple[KnownJoints, str]:
    """What is learnt from figures that are in doubt, and which doubt was not met, in words.

    No gains may hold a joint that is as light as it may be against the gravity that is thought; few
    are as light. Gains then meet as much of that doubt as they can, and no less than a measured
    joint's. One that is lighter swings, which is seen (``calmed``).
    """
    learned = learnt(profile, robot, figures)
    least, shaky = figures.least.copy(), np.isinf(learned.sensitivity)
    near = [share for share in NEARER if share < least.max()]
    for share in near if shaky.any() else []:
        left = np.isinf(learned.sensitivity)
        least[left] = np.minimum(least[left], share)
        learned = learnt(profile, robot, figures.but(lighter=least))
    relaxed = np.flatnonzero(least < figures.least)
    if not len(relaxed) or np.isinf(learned.sensitivity).any():
        return learned, ""
    each = listed([f"joint {j + 1} from {1.0 / least[j]:.2g} of its inertia on" for j in relaxed])
    return learned, UNSURE.format(profile.control.rate, each)


def not_held(profile: Profile, robot: Robot, learned: KnownJoints) -> str | None:
    """Which joints no stable gains hold, why, and what to do; None: all are held."""
    shaky = [j for j in range(robot.n) if not np.isfinite(learned.sensitivity[j])]
    if not shaky:
        return None
    figures, rate = learned.figures, profile.control.rate
    pull, load = pulls(robot, figures), burdens(robot, figures)
    unknown = bool((figures.doubt >= ROUGH).all())
    each = listed([_not_held(j, learned, float(pull[j]), float(load[j])) for j in shaky])
    source = "by the URDF" if unknown else "by what was measured"
    where = "about its place" if len(figures.about) else "in every pose"
    ways = _ways(profile, robot, figures, shaky)
    if unknown:
        ways += [
            "correct masses and inertias in the URDF",
            "give first_motion a pose in which that joint hangs",
        ]
    elif np.isfinite(figures.stiffness[shaky]).any():
        ways.append("look for what gives way between motor and link")
    return (
        f"{each}: no stable gains hold that {where} at {rate:g} Hz ({source}); {', or '.join(ways)}"
    )


def _ways(profile: Profile, robot: Robot, figures: JointFigures, shaky: list[int]) -> list[str]:
    """What of ``control`` to change: never a rate that the bus does not carry."""
    wider = profile.control.model_copy(update={"bandwidth_hz": None})
    free, out = profile.model_copy(update={"control": wider}), []
    if profile.control.bandwidth_hz is not None:
        out = ["leave out control.bandwidth_hz"]
        if _margins(_peaks_at(profile.control.rate, free, robot, figures), shaky):
            return out
    if (faster := _faster(free, robot, figures, shaky)) is None:
        most = f"{np.floor(most_rate(profile)):g} Hz, all that this bus carries"
        return [f"no control.rate would do (up to {most}): lighten what that joint carries"]
    return [", ".join([f"raise control.rate to {faster}", *out])]


def most_rate(profile: Profile) -> float:
    """Hz that the profile's bus carries."""
    return profile_budget(profile).max_rate if profile.drives else np.inf


def _not_held(j: int, learned: KnownJoints, pull: float, load: float) -> str:
    """What no servo holds, of joint j (0-based); load: N·m of gravity at most."""
    spring = float(learned.figures.stiffness[j])
    said = f"joint {j + 1} is pulled away by gravity with {pull:.2g} N·m/rad"
    if np.isfinite(spring):
        said += (
            f" behind a spring of {spring:.3g} N·m/rad, which {load:.3g} N·m of gravity wind by "
            f"{load / spring:.2g} rad"
        )
    return f"{said}, kp that does not shake it is {learned.gains.kp[j]:.2g}"


def _faster(profile: Profile, robot: Robot, figures: JointFigures, shaky: list[int]) -> str | None:
    """To which rate: the first at which the shaky joints have their margins. One at which they are
    only just stable holds them by this description, and no longer by what is measured next. None
    where no rate that the bus carries holds them."""
    rates = [r for r in FASTER if profile.control.rate < r <= most_rate(profile)]
    peaks = {r: _peaks_at(r, profile, robot, figures) for r in rates}
    held = [r for r in rates if np.isfinite(peaks[r]).all()]
    for r in held:
        if _margins(peaks[r], shaky):
            return f"{r:g} Hz"
    return f"{held[0]:g} Hz at least, which leaves no margins" if held else None


def _margins(peaks: Array, shaky: list[int]) -> bool:
    """Whether all joints are held, and those that were not have the usual margins."""
    return bool(np.isfinite(peaks).all() and (peaks[shaky] <= SENSITIVITY).all())


def _peaks_at(rate: float, profile: Profile, robot: Robot, figures: JointFigures) -> Array:
    """(n,) peaks of the sensitivity with the gains that this rate allows."""
    control = profile.control.model_copy(update={"rate": rate})
    bound = arm_limits(profile, robot).following_error
    return fitted_gains(robot, control, bound, figures).sensitivity


def keep_joints(data: str, profile: str, runs: list[str], known: JsonObject) -> JsonObject:
    """Write down what was learnt; it holds until the profile or the URDF changes."""
    found = load_robot(profile)[0]
    return keep_learnt(data, found, runs, KnownJoints.from_document(known)).document()


def keep_learnt(
    data: Data, profile: Profile, runs: Sequence[str], known: KnownJoints
) -> MeasuredJoints:
    """The same of this profile, now."""
    now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return keep_for(data, profile, MeasuredJoints(known, now, tuple(runs), "", ""))


def keep_for(data: Data, profile: Profile, measured: MeasuredJoints) -> MeasuredJoints:
    """Write down what is known of this profile's joints."""
    own = replace(measured, profile=profile.name, fingerprint=fingerprint(profile))
    place = _place(data, profile)
    place.parent.mkdir(parents=True, exist_ok=True)
    write_json(place, own.document())
    return own


def calmer(
    data: str,
    profile: str,
    known: JsonObject,
    fault: JsonObject,
    went: Sequence[Sequence[Sequence[float]]] | None = None,
    part: str = "friction",
) -> JsonObject | None:
    """What is learnt from a joint that swung, or fell behind: gains with which it does not, and a
    ``note`` of what was changed. None where gains would become too soft to hold anything, or firm
    enough to shake it.

    known: what was learnt before, with the gains that let it swing; went: rad and N·m (N, n) until
    then, and the way to its start; part: of the first motion, that it ended.
    """
    before, what = KnownJoints.from_document(known), Fault.from_document(fault)
    if what.kind == "following_error":
        own, robot = load_robot(profile)
        found = None
        if went is not None:
            q, torque = (np.array(values, dtype=float).reshape(-1, robot.n) for values in went)
            seen = Seen(Plan("first_motion", (), ()), own.control.rate, q, torque)
            found = told_on_the_way(own, robot, before, what, seen, part)
        found = found or firmed(own, robot, before, what)
    else:
        found = _calmed_after(profile, before, what)
    return None if found is None else {**found.known.document(), "note": found.note}


def firmed(profile: Profile, robot: Robot, known: KnownJoints, fault: Fault) -> Calmer | None:
    """See ``calmer``, of a joint that fell behind."""
    bound, gains = arm_limits(profile, robot).following_error, known.gains
    figures, share, axis = known.figures, 0.0, fault.axis
    if axis is None or not met_nothing(profile, robot, known, fault):
        return None
    while share < FIRMER:  # half as light may lie within the doubt that there was
        heavier = after_fall(robot, figures, gains, float(bound[axis]), axis)
        if heavier is None:
            return None
        figures, again = heavier, learnt(profile, robot, heavier)
        if np.isfinite(again.sensitivity[axis]):
            share = firmness(again.gains, axis) / firmness(gains, axis)
    force = pressed(profile, robot, known, axis)
    note = (
        f"joint {axis + 1} fell behind, pressed on with {force:.2g} N·m alone: gains {share:.2g} "
        "times as firm were set, and it is tried again"
    )
    return Calmer(again.leaning(known.lean), note)


def told_on_the_way(
    profile: Profile, robot: Robot, known: KnownJoints, fault: Fault, seen: Seen, part: str
) -> Calmer | None:
    """See ``calmer``, of a joint that fell behind: by what this part of a first motion tells."""
    by = weighed if part == "friction" else rubbed
    return by(profile, robot, known, fault, seen)


def rubbed(
    profile: Profile, robot: Robot, known: KnownJoints, fault: Fault, seen: Seen
) -> Calmer | None:
    """See ``calmer``, of a joint that fell behind in its strokes because of viscous friction that
    slower motions had not shown. None where that does not explain it."""
    axis = fault.axis
    if axis is None or not len(seen.q) or not met_nothing(profile, robot, known, fault):
        return None
    felt = rubbed_on_the_way(robot, seen, axis, known.figures)
    more = float(felt.viscous[axis] - known.figures.viscous[axis])
    fastest = float(np.abs(np.gradient(seen.q[:, axis], 1.0 / seen.rate)).max())
    again, _ = begun(profile, robot, felt)
    if more * fastest < EXPLAINS * pressed(profile, robot, known, axis) or not np.isfinite(
        again.sensitivity[axis]
    ):
        return None
    unit = "N·s/m" if robot.prismatic[axis] else "N·m·s/rad"
    note = (
        f"joint {axis + 1} fell behind: {felt.viscous[axis]:.2g} {unit} of viscous friction, which "
        "slower motions had not shown, held it back; that is given to it, and it is tried again"
    )
    return Calmer(again.leaning(known.lean), note)


def weighed(
    profile: Profile, robot: Robot, known: KnownJoints, fault: Fault, seen: Seen
) -> Calmer | None:
    """See ``calmer``, of a joint that fell behind because it weighs other than was thought, by what
    was recorded until then. None where that does not explain it."""
    axis = fault.axis
    if axis is None or not len(seen.q) or not met_nothing(profile, robot, known, fault):
        return None
    felt = felt_on_the_way(robot, seen, known.figures)
    more = float(weighed_more(robot, seen.q, felt, known.figures)[axis])
    again, _ = begun(profile, robot, felt)
    if more < EXPLAINS * pressed(profile, robot, known, axis) or not np.isfinite(
        again.sensitivity[axis]
    ):
        return None
    note = (
        f"joint {axis + 1} fell behind: on its way up to {more:.2g} N·m more or less than its URDF "
        "says held it; what the arm weighs was taken from that, and it is tried again"
    )
    return Calmer(again.leaning(known.lean), note)


def slower(
    data: str, profile: str, known: JsonObject, fault: JsonObject, part: str, speed: float
) -> float | None:
    """See ``slowed``, of what clients are told."""
    before, what = KnownJoints.from_document(known), Fault.from_document(fault)
    return slowed(*load_robot(profile), before, what, part, speed)


def slowed(
    profile: Profile, robot: Robot, known: KnownJoints, fault: Fault, part: str, speed: float
) -> float | None:
    """Share of the strokes' speed for a joint that fell behind though its gains are as firm as
    they may be. What friction asks for beyond what is known of it grows with the speed, and the
    servo has more time to find it. None where it does not stroke, where strokes are slow already,
    and where it may have met something.

    speed: share at which it fell behind
    """
    less = SLOWER * speed
    if part == "friction" or fault.kind != "following_error" or less < SLOWEST:
        return None
    return less if met_nothing(profile, robot, known, fault) else None


def met_nothing(profile: Profile, robot: Robot, known: KnownJoints, fault: Fault) -> bool:
    """Whether a joint that fell behind cannot have met anything: it had been where it should go, or
    friction alone may hold it."""
    if fault.axis is None:
        return False
    bound = float(arm_limits(profile, robot).following_error[fault.axis])
    pressed = robot, known.figures, known.gains, bound, fault.axis
    return fault.was_there or lightly_pressed(*pressed)


def soft_joints(
    data: str, profile: str, known: JsonObject, of: Sequence[int] | None = None
) -> list[int]:
    """See ``soft``; of: the joints that are measured, from 1; None: all."""
    found = soft(*load_robot(profile), KnownJoints.from_document(known))
    return [j for j in found if of is None or j in of]


def soft(profile: Profile, robot: Robot, known: KnownJoints) -> list[int]:
    """Joints, from 1, of whose viscous friction more has to be known before they stroke than small
    slow motions tell: their servo, as far behind as it may be, pushes with less than that may ask
    for; or it damps them more than their servo does."""
    figures, gains = known.figures, known.gains
    asks, leans = VISCOUS * figures.coulomb, figures.viscous > gains.kd
    return [
        j + 1 for j in range(robot.n) if leans[j] or pressed(profile, robot, known, j) < asks[j]
    ]


def pressed(profile: Profile, robot: Robot, known: KnownJoints, axis: int) -> float:
    """N·m (N) with which a servo pushes a joint that is as far behind as it may be."""
    bound = float(arm_limits(profile, robot).following_error[axis])
    return float(min(known.gains.kp[axis] * bound, robot.effort[axis]))


def firmness(gains: PidGains, axis: int) -> float:
    """N·m/rad against what pushes slowly."""
    return max(float(np.hypot(gains.kp[axis], gains.ki[axis] / SLOW)), 1e-12)


def calmed(
    profile: Profile, robot: Robot, known: KnownJoints, axis: int, hertz: float
) -> Calmer | None:
    """See ``calmer``; axis: 0-based."""
    figures, gains = known.figures, known.gains
    lighter = after_swing(robot, profile.control, figures, gains, axis, hertz)
    again = learnt(profile, robot, lighter)
    usual = inertias(robot, figures).usual[axis]
    too_far = not SOFTEST < lighter.swung[axis] / usual < 1.0 / SOFTEST
    fit = "that"
    if too_far or not np.isfinite(again.sensitivity[axis]):
        rotor = float(lighter.swung[axis])
        sprung = with_rotor(robot, figures, axis, rotor, hertz)
        if sprung is None:
            return None
        again = learnt(profile, robot, sprung)
        if not np.isfinite(again.sensitivity[axis]):
            return None
        fit = (
            f"a rotor of {rotor:.2g} kg·m² behind a spring of {sprung.stiffness[axis]:.2g} N·m/rad"
        )
        fit = of_a_slide(fit) if robot.prismatic[axis] else fit
    share = float(again.gains.kd[axis] / max(gains.kd[axis], 1e-12))
    note = (
        f"joint {axis + 1} swung at {hertz:.2g} Hz: gains that fit {fit} were set (damping "
        f"{share:.2g} times as high), and it is tried again"
    )
    return Calmer(again.leaning(known.lean), note)


def keep_felt(data: str, profile: str, runs: Sequence[str]) -> JsonObject:
    """What is known of an arm that was measured and moved on since, kept: what it weighs by these
    runs, too."""
    own, robot = load_robot(profile)
    kept, library = kept_joints(data, own), open_library(data)
    if kept is None:
        raise UserError("the joints have not been measured; run first_motion before")
    every = (*kept.runs, *runs)
    seen = [_seen(library, own, run) for run in every]
    parts = {str(one.part): one for one in seen if one.part is not None}
    more = [one for one in seen if one.part is None]
    known = felt_more(own, robot, kept.known, parts, more)
    return keep_learnt(data, own, every, known).document()


def felt_more(
    profile: Profile,
    robot: Robot,
    known: KnownJoints,
    parts: Mapping[str, Seen],
    more: Sequence[Seen],
) -> KnownJoints:
    """What is learnt from the parts of a first motion and more motions, of what the arm weighs; as
    before where no gains would hold that. A base that was told to lean leans still, also where one
    more motion hides it among other errors, and one that leans by all of them is told to."""
    felt = felt_again(robot, known.figures, parts, more)
    learned, _ = begun(profile, robot, felt)
    told = [(one.q, one.torque, one.rate) for one in (*parts.values(), *more)]
    lean = leaning_mount(robot, felt, told) or known.lean
    if not_held(profile, robot, learned):
        return known if known.lean else known.leaning(lean)
    return learned.leaning(lean)


def keep_calmer(data: str, profile: str, fault: JsonObject) -> JsonObject | None:
    """The same for an arm that was measured, kept."""
    own = load_robot(profile)[0]
    kept = kept_joints(data, own)
    found = None if kept is None else _calmed_after(profile, kept.known, Fault.from_document(fault))
    if kept is None or found is None:
        return None
    return {**keep_learnt(data, own, kept.runs, found.known).document(), "note": found.note}


def _calmed_after(profile: str, known: KnownJoints, fault: Fault) -> Calmer | None:
    found, robot = load_robot(profile)
    assert fault.axis is not None  # no arm swings as a whole
    return calmed(found, robot, known, fault.axis, fault.hertz)


def torque_steps(profile: Profile, robot: Robot) -> Array:
    """(n,) N·m, the smallest difference between two torques that a drive can be told."""
    if profile.drives is None:
        return np.asarray(1e-3 * robot.effort)
    return np.array([scaling_of(drive).rated / 1000.0 for drive in profile.drives])


def learnt(profile: Profile, robot: Robot, figures: JointFigures) -> KnownJoints:
    """Figures and the gains that follow from them, with sentences for a person."""
    bound = arm_limits(profile, robot).following_error
    fitted = fitted_gains(robot, profile.control, bound, figures)
    push = PUSH * robot.effort if (figures.doubt >= ROUGH).all() else np.zeros(robot.n)
    gains = replace(fitted.gains, push=push, friction=figures.coulomb)
    span = inertias(robot, figures)
    return KnownJoints(
        figures=figures,
        gains=gains,
        asked=profile.control.servo_bandwidth,
        bandwidth=bandwidths(robot, figures, gains),
        sensitivity=fitted.sensitivity,
        inertia=span,
        resonance=figures.resonance(span.usual),
        sentences=tuple(sentences(robot, figures, gains)),
    )


def _place(data: Data, profile: Profile) -> Path:
    return data_folder(data) / "joints" / f"{fingerprint(profile)[:16]}.json"
