"""Torque gains by known weights, from runs of the store: figures, words, and what to hang next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.common.words import listed
from pa10d.dynamics import Robot
from pa10d.identify.scale import Body, Gains, JointGain, Load, Prospect, prospects, torque_gains
from pa10d.identify.scale.prediction import ASIDE, WANTED, best, heavier, limited_by_noise
from pa10d.measurement.recording import Recording
from pa10d.store import RunStore

Document = dict[str, Any]


def gains_document(
    robot: Robot,
    store: RunStore,
    empty: Sequence[str],
    loads: Sequence[tuple[Body, Sequence[str]]],
    at_hand: Sequence[Body] = (),
) -> Document:
    """What ``pa10d scale --json`` says: ``joints``, ``prospects`` of the weights at hand,
    ``next_mass`` and ``advice``."""
    given = [Load(_read(store, runs, robot), body) for body, runs in loads]
    found = torque_gains(robot, _read(store, empty, robot), given)
    seen = prospects(robot, found, at_hand)
    chosen = best(found, seen)
    masses = [body.mass for body, _ in loads]
    heavy = heavier(robot, found, masses) if chosen is None else None
    return {
        "joints": [_line(robot, j, joint) for j, joint in enumerate(found.joints)],
        "prospects": [_prospect(one, one is chosen) for one in seen],
        "next_mass": heavy,
        "advice": _advice(robot, found, chosen, seen, heavy, masses),
    }


def rows_in_words(document: Mapping[str, Any]) -> list[list[str]]:
    """Joint, name, gain, bounds, what mends a recording: a row each."""
    return [
        [str(line["joint"]), line["name"], gain_in_words(line), bounds_in_words(line), line["map"]]
        for line in document["joints"]
    ]


def gain_in_words(line: Mapping[str, Any]) -> str:
    """``1.1203 ± 0.0041``, or why it is not determined."""
    if line["gain"] is None:
        return f"not determined: {line['why']}"
    said = " (recordings disagree)" if line["disagree"] else ""
    return f"{line['gain']:.4f} ± {line['std_error']:.4f}{said}"


def bounds_in_words(line: Mapping[str, Any]) -> str:
    """What friction with the load leaves open, or nothing."""
    between = line["between"]
    return "" if between is None else f"{between[0]:.3g} … {between[1]:.3g}"


def _read(store: RunStore, names: Sequence[str], robot: Robot) -> list[Recording]:
    runs = [store.recording(store.find(name)) for name in names]
    for name, run in zip(names, runs, strict=True):
        if run.joints != robot.n:
            raise UserError(f"run {name!r}: {run.joints} joints, expected {robot.n}")
    return runs


def _line(robot: Robot, j: int, joint: JointGain) -> Document:
    told = joint.told
    return {
        "joint": j + 1,
        "name": robot.joint_names[j],
        "gain": joint.gain if told else None,
        "std_error": joint.std_error if told else None,
        "of_noise": joint.of_noise if told else None,
        "of_weight": joint.of_body if told else None,
        "between": None if joint.between is None else list(joint.between),
        "friction_with_load": joint.rubs if joint.between else None,
        "disagree": joint.disagree,
        "asked": joint.asked,
        "why": joint.why or None,
        "map": f"--map 'tau{j + 1}[{1 / joint.gain:.4g}]=tau{j + 1}'" if told else "",
    }


def _prospect(one: Prospect, chosen: bool) -> Document:
    return {
        "weight": one.body.text,
        "mass": one.body.mass,
        "std_error": [float(v) if np.isfinite(v) else None for v in one.std_error],
        "worst": one.worst if np.isfinite(one.worst) else None,
        "too_much": None if one.too_much is None else one.too_much + 1,
        "aside": [j + 1 for j in one.aside],
        "axis": one.axis or None,
        "next": chosen,
    }


def _advice(
    robot: Robot,
    found: Gains,
    chosen: Prospect | None,
    seen: Sequence[Prospect],
    heavy: float | None,
    masses: Sequence[float],
) -> str:
    return " ".join([_next(found, chosen, seen, heavy, masses), *_caveats(robot, found, seen)])


def _next(
    found: Gains,
    chosen: Prospect | None,
    seen: Sequence[Prospect],
    heavy: float | None,
    masses: Sequence[float],
) -> str:
    error = found.std_error
    told = np.isfinite(error)
    if chosen is not None:
        return (
            f"Hang {chosen.body.words} next: {_joints(np.isfinite(chosen.std_error))} would be "
            f"known to {chosen.worst:.1%} or better."
        )
    body = np.array([joint.of_body for joint in found.joints])
    noise = np.array([joint.of_noise for joint in found.joints])
    if heavy is not None:
        limited = limited_by_noise(found)
        after = np.max(noise[limited]) * max(masses) / heavy
        return (
            f"Hang {heavy:g} kg next: noise would leave {_joints(limited)} at {after:.1%} or less."
        )
    if told.any() and error[told].max() <= WANTED:
        return f"Every gain that can be told is known to {WANTED:.0%}."
    poor = told & (body > noise) & (error > WANTED)
    if poor.any():
        return (
            f"What limits {_joints(poor)} is how well the weight is known: weigh it, and "
            "measure where its centre is, more closely."
        )
    split = np.array([joint.spread > WANTED for joint in found.joints])
    if split.any() and not limited_by_noise(found).any():
        return f"No weight tells more of {_joints(split)} while recordings disagree."
    if seen and not told.any():
        over = [one for one in seen if one.too_much is not None]
        return (
            f"No weight at hand fits: {over[0].body.mass:g} kg is more than joint "
            f"{(over[0].too_much or 0) + 1} may carry in this motion."
            if over else "No weight at hand would tell any joint's gain."
        )  # fmt: skip
    return "No heavier weight fits within the torque limits: record longer, or move more slowly."


def _caveats(robot: Robot, found: Gains, seen: Sequence[Prospect]) -> list[str]:
    said = []
    rubbing = np.array([joint.between is not None for joint in found.joints])
    if rubbing.any():
        said.append(
            f"Friction of {_joints(rubbing)} goes with the load: where it acts more while the "
            "motor drives than while the load drives, the gain lies lower, down to the bound; no "
            "mass can tell these apart (the motor's back-EMF constant can: its volts per rad/s are "
            "its N·m per ampere)."
        )
    split = np.array([joint.disagree for joint in found.joints])
    if split.any():
        said.append(
            f"Recordings disagree about {_joints(split)} by more than their errors, which were "
            "widened: what is called torque is not in proportion to it, or the weight was not what "
            "was stated."
        )
    for one in seen:
        if one.aside:
            named = listed([str(j + 1) for j in one.aside])
            said.append(
                f"Hung {ASIDE:g} m to the side (along {one.axis}), {one.body.mass:g} kg would tell "
                f"joint {named}, too."
            )
            break
    return said


def _joints(which: Any) -> str:
    numbers = [str(int(j) + 1) for j in np.flatnonzero(which)]
    return f"joint{'s' if len(numbers) > 1 else ''} {listed(numbers)}"
