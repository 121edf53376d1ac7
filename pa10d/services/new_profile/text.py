"""The profile as a file for people: every figure says where it comes from."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from math import pi

import numpy as np

from pa10d.services.new_profile.answers import VIRTUAL, Answers
from pa10d.services.new_profile.facts import ArmFacts

COUNTS = 2**20  # of a virtual encoder, per revolution
STEP = 1e-6  # m, of a virtual encoder along a rail
RATIO = 100.0
SILENCE = 0.2  # s without news that a simulated arm goes on


def profile_text(facts: ArmFacts, answers: Answers, urdf: str) -> str:
    """YAML; urdf: as the file names it."""
    return "\n".join(_lines(facts, answers, urdf)) + "\n"


def _lines(facts: ArmFacts, a: Answers, urdf: str) -> Iterator[str]:
    robot, simulated = facts.robot, a.bus == VIRTUAL
    yield f"# {a.name}, from {urdf}. What nobody stated says 'assumed': look at it before motion."
    for doubt in facts.doubts:
        yield f"# Doubt: {doubt}."
    yield f"name: {json.dumps(a.name, ensure_ascii=False)}"
    yield f"urdf: {json.dumps(urdf, ensure_ascii=False)}"
    names = ", ".join(json.dumps(name, ensure_ascii=False) for name in robot.joint_names)
    yield f"joints: [{names}]  # in the order of every list here"
    yield f"base: {{rpy: {_row(a.rpy)}}}  # rad; 0, 0, 0 stands on the floor"
    yield ""
    yield "environment:  # plans keep 3 cm from it; in the frame of the base"
    if facts.hangs:
        yield "  floor: none  # assumed; m along the base's z axis, such as -0.8"
    else:
        yield "  floor: 0  # m along the base's z axis, where it is mounted; none: no floor"
    yield "  boxes: []  # such as {name: table, size: [0.8, 1.2, 0.7], xyz: [0.9, 0, 0.35]}"
    if a.tool_mass:
        yield f"tool: {{mass: {a.tool_mass:.12g}, com: {_row(a.tool_com)}}}  # kg, m"
    else:
        yield "# tool: {mass: 1.2, com: [0, 0, 0.08]}  # kg, m in the last joint's frame"
    if facts.home is not None:
        pose = _row([round(float(v), 4) for v in facts.home])
        yield f"home: {pose}  # rad (m); assumed: zero meets the floor or a body"
    yield ""
    yield "limits:"
    if any(a.assumed["position"]):
        pairs = ", ".join(_row(pair) for pair in a.position)
        yield f"  position: [{pairs}]  # rad (m){_who(a, 'position')}"
    else:
        yield "  # position comes from the URDF"
    yield f"  velocity: {_row(a.velocity)}  # rad/s (m/s){_who(a, 'velocity')}"
    yield f"  acceleration: {_row(a.acceleration)}  # rad/s² (m/s²){_who(a, 'acceleration')}"
    yield f"  torque: {_row(a.torque)}  # N·m (N) at the joint{_who(a, 'torque')}"
    yield ""
    yield "# A share of its value to which each torque constant is known, for the standard errors."
    yield "torque_gain_error: 0.05  # assumed"
    yield "# torque_constants: [...]  # N·m at the joint per A, for recordings of motor currents"
    yield "# map: ['t[ms]=time', 'joint_{n}_position[deg]=q']  # what recordings call their columns"
    yield ""
    yield from _drives(robot.prismatic, a, simulated)
    yield ""
    if simulated:
        yield f"can: {{interface: virtualbus, channel: {json.dumps(a.name)}, bitrate: 1000000}}"
    else:
        yield f"can: {{interface: socketcan, channel: {json.dumps(a.bus)}, bitrate: 1000000}}"
    yield ""
    yield "control:"
    yield f"  rate: {a.rate:g}  # Hz"
    yield "  controller: pid"
    if simulated:
        yield ""
        yield "safety:"
        cycles = max(round(SILENCE * a.rate), 1)
        yield f"  stale_cycles: {cycles}  # a simulated drive is a process among others"
        yield ""
        yield "simulation:  # behind virtual drives; without it the profile is of a real arm"
        yield "  plant: backends.virtual.plant:build"
        yield "  clock: real"
        yield "  seed: 0"


def _drives(prismatic: Sequence[bool] | np.ndarray, a: Answers, simulated: bool) -> Iterator[str]:
    if simulated:
        yield "# Virtual drives: their figures are free; rated torque × gear ratio is the limit."
    else:
        yield "# All of this is assumed: take it from drives' and encoders' data sheets; check"
        yield "# node, sign and zero offset of each joint by hand before the first motion."
    yield "drives:"
    for j, torque in enumerate(a.torque):
        counts = 2 * pi / STEP if prismatic[j] else COUNTS
        yield (
            f"  - {{node: {j + 1}, counts_per_rev: {counts:.0f}, gear_ratio: {RATIO:g}, "
            f"rated_torque: {torque / RATIO:.6g}, sign: 1, zero_offset: 0, brake: true}}"
        )


def _row(values: Sequence[float]) -> str:
    return "[" + ", ".join(f"{v:.10g}" for v in values) + "]"


def _who(a: Answers, key: str) -> str:
    flags = a.assumed[key]
    if all(flags):
        return "; assumed"
    if any(flags):
        joints = ", ".join(str(j + 1) for j, flag in enumerate(flags) if flag)
        return f"; assumed for joint {joints}"
    return ""
