"""Arms of another simulator, with a measured truth: MuJoCo moves bodies, gaps and springs, and rubs
by bristles (LuGre) that are told to it from here. Nothing of the project's own plant takes part."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from scipy.signal import lfilter

from pa10d.dynamics import Robot, robot_from_urdf
from pa10d.measurement.recording import Recording

STEP = 5e-4  # s
RUN_IN = 3.0  # s before a recording begins
AXES = {3: "zyy", 4: "zyyz", 5: "zyyzy", 6: "zyyzyz"}
XYZ = {"z": "0 0 1", "y": "0 1 0"}
RATES = (125, 200, 250, 500, 1000)
BRISTLE = 2e-5  # rad that a bristle bends: far below what any encoder shows
SERVO_HZ = 3.0


@dataclass
class Machine:
    """bodies: (mass, centre, inertia, length) each; the rest (n,) in N·m, kg·m², rad/s; hidden:
    kind -> its numbers, joints from 0; resolution: rad; reach: of the usual motion."""

    axes: str
    bodies: list[tuple[float, np.ndarray, np.ndarray, float]]
    peak: np.ndarray
    rotor: np.ndarray
    coulomb: np.ndarray
    viscous: np.ndarray
    stribeck: np.ndarray
    stribeck_speed: np.ndarray
    hidden: dict[str, Any] = field(default_factory=dict)
    rate: int = 500
    noise: np.ndarray = field(default_factory=lambda: np.zeros(0))
    resolution: float = 2 * np.pi / 2**20
    reach: float = 1.0

    @property
    def n(self) -> int:
        return len(self.axes)


def machine(seed: int, kinds: str) -> tuple[Machine, Robot]:
    """Drawn, with what kinds ("stribeck+spring") say; and the arm as its maker's URDF has it."""
    rng = np.random.default_rng([seed, 77])
    n = int(rng.integers(3, 7))
    bodies = _bodies(rng, n)
    peak = np.array([sum(b[0] for b in bodies[i:]) * 9.81 * 0.3 + 3 for i in range(n)])
    made = Machine(
        AXES[n], bodies, peak,
        rotor=0.02 * peak * rng.uniform(0.5, 1.5, n),
        coulomb=peak * rng.uniform(0.04, 0.1, n),
        viscous=peak * rng.uniform(0.05, 0.15, n),
        stribeck=np.zeros(n), stribeck_speed=np.full(n, 0.05),
    )  # fmt: skip
    first, *more = kinds.split("+")
    made.hidden.update(DRAWS[first](rng, made, int(rng.integers(0, n))))
    made.rate = int(rng.choice(RATES))
    made.noise = peak * rng.uniform(0.0015, 0.006)
    for kind in more:
        made.hidden.update(DRAWS[kind](rng, made, int(rng.integers(0, n))))
    return made, robot_from_urdf(_urdf(made, rng))


def recordings(made: Machine, seed: int, dirt: str = "") -> list[Recording]:
    """Four runs, soiled on their way."""
    seconds = 40.0 if made.rate < max(RATES) else 25.0
    rng = np.random.default_rng(seed)
    runs = [_run(made, 100 * seed + k, seconds) for k in range(4)]
    return [SOILS[dirt](run, made, rng) for run in runs]


def _bodies(rng, n):
    lengths = rng.uniform(0.15, 0.45, n)
    lengths[0] = 0.3
    heaviest, out = rng.uniform(5, 12), []
    for i, length in enumerate(lengths):
        mass = heaviest * 0.65**i
        aside = [rng.uniform(-0.02, 0.02), rng.uniform(-0.02, 0.02)]
        centre = np.array([*aside, length * rng.uniform(0.3, 0.6)])
        across = mass * (length**2 / 12 + 0.003)
        inertia = [across, across * rng.uniform(0.8, 1.1), mass * 0.004 * rng.uniform(0.7, 1.3)]
        out.append((mass, centre, np.array(inertia), length))
    return out


def _stribeck(rng, made, j):
    made.stribeck[j] = made.peak[j] * rng.uniform(0.05, 0.12)
    made.stribeck_speed[j] = rng.uniform(0.06, 0.15)
    return {"stribeck": (j, made.stribeck[j], made.stribeck_speed[j])}


def _gap(rng, made, j):
    return {"gap": (int(rng.integers(1, min(3, made.n))), rng.uniform(0.004, 0.012))}


def _worn(rng, made, j):
    height = made.peak[j] * rng.uniform(0.05, 0.12)
    return {"worn": (j, height, rng.uniform(-0.5, 0.5), rng.uniform(0.1, 0.3))}


def _ripple(rng, made, j):
    size = made.peak[j] * rng.uniform(0.03, 0.06)
    return {"ripple": (j, size, int(rng.choice([6, 12, 20, 36])), rng.uniform(0, 6))}


def _pair(rng, made, j):
    a = int(rng.integers(0, made.n - 1))
    return {"pair": (a, 0.5 * np.sqrt(made.peak[a] * made.peak[a + 1]) * rng.uniform(0.06, 0.12))}


DRAWS: dict[str, Callable[..., dict[str, Any]]] = {
    "none": lambda rng, made, j: {},
    "stribeck": _stribeck,
    "spring": lambda rng, made, j: {
        "spring": (j, made.peak[j] * rng.uniform(0.1, 0.3), rng.uniform(-0.5, 0.5))
    },
    "gap": _gap,
    "worn": _worn,
    "warm": lambda rng, made, j: {"warm": (j, rng.uniform(0.3, 0.5), rng.uniform(20, 60))},
    "ripple": _ripple,
    "stop": lambda rng, made, j: {
        "stop": (j, made.peak[j] * rng.uniform(1, 3), rng.uniform(0.2, 0.6))
    },
    "pair": _pair,
    "delay": lambda rng, made, j: {"delay": (j, int(rng.integers(2, 5)))},
}


def _urdf(made: Machine, rng) -> str:
    text, below = '<robot name="elsewhere"><link name="base"/>', 0.2
    for i, (axis, (mass, _, inertia, length)) in enumerate(
        zip(made.axes, made.bodies, strict=True), 1
    ):
        off = rng.uniform(0.5, 1.8)
        parent = "base" if i == 1 else f"l{i - 1}"
        x, y, z = inertia * off
        text += (
            f'<joint name="j{i}" type="revolute"><parent link="{parent}"/><child link="l{i}"/>'
            f'<origin xyz="0 0 {below}"/><axis xyz="{XYZ[axis]}"/>'
            '<limit lower="-3" upper="3" effort="300" velocity="4"/></joint>'
            f'<link name="l{i}"><inertial><mass value="{mass * off}"/>'
            f'<origin xyz="0 0 {length / 2}"/><inertia ixx="{x}" iyy="{y}" izz="{z}" '
            'ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
        below = length
    return text + "</robot>"


def _mjcf(made: Machine, hidden: dict[str, Any]) -> str:
    text = (
        f'<mujoco><compiler angle="radian"/><option timestep="{STEP}" integrator="implicitfast" '
        'gravity="0 0 -9.81"><flag contact="disable"/></option><worldbody>'
    )
    below, ends = 0.2, ""
    for i, (axis, (mass, centre, inertia, length)) in enumerate(
        zip(made.axes, made.bodies, strict=True)
    ):
        along = f'axis="{XYZ[axis]}"'
        motor = f'<joint name="j{i}" type="hinge" {along} armature="{made.rotor[i]}"'
        text += f'<body pos="0 0 {below}">'
        if i == hidden.get("gap", (None,))[0]:
            half = hidden["gap"][1]
            text += (
                '<inertial pos="0 0 0" mass="1e-6" diaginertia="1e-9 1e-9 1e-9"/>'
                f'{motor}/><body pos="0 0 0"><joint name="e{i}" type="hinge" {along} '
                f'limited="true" range="{-half} {half}" solreflimit="0.004 1" '
                'solimplimit="0.99 0.999 0.0001"/>'
            )
            ends += "</body>"
        elif i == hidden.get("spring", (None,))[0]:
            _, stiffness, rest = hidden["spring"]
            text += f'{motor} stiffness="{stiffness}" springref="{rest}"/>'
        else:
            text += f"{motor}/>"
        x, y, z = centre
        about = " ".join(str(k) for k in inertia)
        text += f'<inertial pos="{x} {y} {z}" mass="{mass}" diaginertia="{about}"/>'
        ends, below = ends + "</body>", length
    motors = "".join(f'<motor joint="j{i}"/>' for i in range(made.n))
    return f"{text}{ends}</worldbody><actuator>{motors}</actuator></mujoco>"


class _Bristles:
    """ż = v - σ0·|v|·z/g(v), F = σ0·z + σ1·ż + Fv·v, stepped implicitly."""

    def __init__(self, made: Machine) -> None:
        self.made, self.stiffness = made, made.coulomb / BRISTLE
        self.bent = np.zeros(made.n)

    def force(self, v, q, at):
        made = self.made
        level = made.coulomb + made.stribeck * np.exp(-((v / made.stribeck_speed) ** 2))
        oil = made.viscous.copy()
        if "worn" in made.hidden:
            j, height, centre, width = made.hidden["worn"]
            level[j] += height * np.exp(-0.5 * ((q[j] - centre) / width) ** 2)
        if "warm" in made.hidden:
            j, loss, time = made.hidden["warm"]
            less = 1 - loss * (1 - np.exp(-at / time))
            level[j] *= less
            oil[j] *= less
        slip = self.stiffness * np.abs(v) / level
        self.bent = (self.bent + STEP * v) / (1 + STEP * slip)
        rate = v - slip * self.bent
        damping = 0.5 * np.sqrt(self.stiffness) * np.exp(-((v / 0.02) ** 2))
        return self.stiffness * self.bent + damping * rate + oil * v


def _outside(made: Machine, q, v):
    """(n,) N·m that act on the joints from elsewhere."""
    out = np.zeros(made.n)
    if "ripple" in made.hidden:
        j, size, order, phase = made.hidden["ripple"]
        out[j] -= size * np.sin(order * q[j] + phase)
    if "stop" in made.hidden:
        j, stiffness, begins = made.hidden["stop"]
        out[j] -= stiffness * max(0.0, q[j] - begins)
    if "pair" in made.hidden:
        a, size = made.hidden["pair"]
        out[a : a + 2] -= size * np.tanh((v[a] + v[a + 1]) / 0.01)
    return out


def _run(made: Machine, seed: int, seconds: float) -> Recording:
    """A servo with what it knows of the arm ahead follows sums of sines; its commands, held for a
    sample each, are what is recorded."""
    n, rate = made.n, made.rate
    model = mujoco.MjModel.from_xml_string(_mjcf(made, made.hidden))
    known = mujoco.MjModel.from_xml_string(_mjcf(made, {}))
    arm, ahead = mujoco.MjData(model), mujoco.MjData(known)
    rng = np.random.default_rng([seed, 5])
    w = 2 * np.pi * rng.uniform(0.07, 0.8, (6, n))
    size, phase = rng.uniform(0.15, 0.4, (6, n)) / w**0.5, rng.uniform(0, 2 * np.pi, (6, n))
    middle = rng.uniform(-0.4, 0.4, n)
    at = [model.joint(f"j{i}").qposadr[0] for i in range(n)]
    dof = [model.joint(f"j{i}").dofadr[0] for i in range(n)]
    masses = np.array([sum(b[0] * 0.1 for b in made.bodies[i:]) for i in range(n)])
    inertia = 0.6 * np.maximum(made.rotor + masses, 0.05)
    servo = 2 * np.pi * SERVO_HZ
    bristles, samples, before = _Bristles(made), round(seconds * rate), np.zeros(n)
    q, tau = np.zeros((samples, n)), np.zeros((samples, n))
    for k in range(round(RUN_IN * rate) + samples):
        ease = min(k / rate / RUN_IN, 1.0)
        ease *= ease * (3 - 2 * ease)
        angle = w * (k / rate) + phase
        target = ease * (middle + made.reach * (size * np.sin(angle)).sum(0))
        speed = ease * made.reach * (size * w * np.cos(angle)).sum(0)
        ahead.qpos[:], ahead.qvel[:] = target, speed
        ahead.qacc[:] = -ease * made.reach * (size * w**2 * np.sin(angle)).sum(0)
        mujoco.mj_inverse(known, ahead)
        read = np.floor(arm.qpos[at] / made.resolution + 0.5) * made.resolution
        turning = (read - before) * rate if k else np.zeros(n)
        before = read
        asked = (
            ahead.qfrc_inverse
            + inertia * servo * (servo * (target - read) + 1.4 * (speed - turning))
            + made.coulomb * np.tanh(speed / 0.05)
            + made.viscous * speed
        )
        for _ in range(round(1 / rate / STEP)):
            v, here = arm.qvel[dof], arm.qpos[at]
            rubs = bristles.force(v, here, k / rate)
            arm.ctrl[:] = asked
            arm.qfrc_applied[dof] = _outside(made, here, v) - rubs
            mujoco.mj_step(model, arm)
        if (i := k - round(RUN_IN * rate)) >= 0:
            q[i], tau[i] = read, asked + made.noise * rng.standard_normal(n)
    if "delay" in made.hidden:
        j, late = made.hidden["delay"]
        tau[late:, j] = tau[:-late, j].copy()
    return Recording(f"r{seed}", np.arange(samples) / rate, q, tau)


def _quantised(run, made, rng):
    step = 0.01 * made.peak
    return Recording(run.name, run.t, run.q, np.round(run.tau / step) * step)


def _jittered(run, made, rng):
    read = run.t + rng.uniform(0, 0.3 / made.rate, len(run.t))
    q, tau = (np.column_stack([np.interp(read, run.t, x) for x in y.T]) for y in (run.q, run.tau))
    return Recording(run.name, run.t, q, tau)


def _averaged(run, made, rng):
    """Of 40 ms."""
    k = max(2, round(made.rate * 0.04))
    sums = np.cumsum(np.vstack([np.zeros((1, made.n)), run.tau]), 0)
    tau = np.vstack([run.tau[: k - 1], (sums[k:] - sums[:-k]) / k])
    return Recording(run.name, run.t, run.q, tau)


def _slow_noise(run, made, rng):
    more = lfilter([1], [1, -0.98], rng.standard_normal(run.tau.shape), axis=0)
    return Recording(run.name, run.t, run.q, run.tau + 0.5 * made.noise * more)


def _short(run, made, rng):
    end = round(8 * made.rate)
    return Recording(run.name, run.t[:end], run.q[:end], run.tau[:end])


SOILS: dict[str, Callable[..., Recording]] = {
    "": lambda run, made, rng: run,
    "quantised": _quantised,
    "jitter": _jittered,
    "averaged": _averaged,
    "slow noise": _slow_noise,
    "short": _short,
}
