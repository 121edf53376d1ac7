"""Which effects the simulated arm can hide, and how they are asked for in a profile.

``effects: [{effect: stribeck, joint: 4, Fs: 3.0, vs: 0.08}]``; joints count from 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

REQUIRED = None
Where = Literal["joint", "pair", "robot"]
Value = float | str | list[float]


@dataclass(frozen=True)
class Spec:
    """Scope of an effect and its parameters with their defaults (REQUIRED: none)."""

    where: Where
    parameters: Mapping[str, Value | None]


LISTED: dict[str, Spec] = {
    # N·m read on top of the true torque
    "torque_offset": Spec("joint", {"offset": REQUIRED}),
    # Fc ± dFc and Fv ± dFv for positive and negative velocity
    "coulomb_asymmetry": Spec("joint", {"dFc": 0.0, "dFv": 0.0}),
    "stribeck": Spec("joint", {"Fs": REQUIRED, "vs": REQUIRED, "delta": 1.0}),
    "nonlinear_viscous": Spec("joint", {"Fp": REQUIRED, "p": 2.0}),
    # bristles of stiffness sigma0 (N·m/rad) and damping sigma1, or parallel slipping springs whose
    # shares of the friction level slip after the given displacements (rad)
    "presliding_hysteresis": Spec(
        "joint",
        {
            "model": "lugre",
            "sigma0": 0.0,
            "sigma1": 0.0,
            "shares": [0.1, 0.2, 0.3, 0.4],
            "displacements": [0.001, 0.002, 0.005, 0.01],
        },
    ),
    # mu + dmu of the load while the motor drives it, mu - dmu while it drives the motor
    "load_friction": Spec("joint", {"mu": REQUIRED, "dmu": 0.0}),
    # warm → 1 with time constant T (law: time) or with friction power / power (law: power)
    "thermal_friction": Spec(
        "joint",
        {
            "loss": REQUIRED,
            "T": REQUIRED,
            "coulomb_share": 0.5,
            "start": 0.0,
            "law": "time",
            "power": 1.0,
            "rise": 20.0,
        },
    ),
    # N·m more (or less) around an angle, and a wave of given cycles per revolution
    "position_friction": Spec(
        "joint",
        {"height": 0.0, "centre": 0.0, "width": 0.2, "wave": 0.0, "cycles": 1.0, "phase": 0.0},
    ),
    # sin · sin(N q) + cos · cos(N q)
    "torque_ripple": Spec("joint", {"N": REQUIRED, "sin": 0.0, "cos": 0.0}),
    "joint_elasticity": Spec("joint", {"K": REQUIRED, "D": 0.0}),
    # half the gap b, rad; teeth of stiffness K and damping D
    "backlash": Spec("joint", {"b": REQUIRED, "K": REQUIRED, "D": 0.0}),
    "spring": Spec("joint", {"k": REQUIRED, "q0": 0.0}),
    "payload": Spec(
        "robot", {"mass": REQUIRED, "cx": 0.0, "cy": 0.0, "cz": 0.0, "inertia": [0.0] * 6}
    ),
    # base turned about its own x, then y axis, rad
    "base_tilt": Spec("robot", {"x": 0.0, "y": 0.0}),
    "encoder_offset": Spec("joint", {"offset": REQUIRED}),
    # measured = gain · true
    "torque_gain": Spec("joint", {"gain": REQUIRED}),
    # true = measured - cubic · measured³
    "torque_saturation": Spec("joint", {"cubic": REQUIRED}),
    "torque_delay": Spec("joint", {"Td": REQUIRED}),
    # friction on q̇i + sign · q̇j
    "coupling_friction": Spec("pair", {"F": 0.0, "Fv": 0.0, "sign": 1.0}),
    "coupling_inertia": Spec("pair", {"Ia": REQUIRED}),
    # stop at qs that pushes back where side · (q - qs) > 0
    "contact": Spec("joint", {"k": REQUIRED, "qs": REQUIRED, "side": 1.0, "damping": 0.0}),
}

UNLISTED: dict[str, Spec] = {
    # torque amplitude · sin(qi) · sin(qj + phase) on joint i: a cable that crosses two axes
    "cable_drag": Spec("pair", {"amplitude": REQUIRED, "phase": 0.0}),
    # drag · q · |q̇| q̇: fan-like resistance that grows as the arm opens
    "windage": Spec("joint", {"drag": REQUIRED}),
    # friction level of joint i changes by amplitude · sin(cycles · qj): a clamp bent by a neighbour
    "cross_friction": Spec("pair", {"amplitude": REQUIRED, "cycles": 1.0}),
    # torque -pull · x/w · exp(½ - x²/2w²), x = q - centre: magnet catch in a narrow range
    "magnet_detent": Spec("joint", {"pull": REQUIRED, "centre": 0.0, "width": 0.15}),
    # spring of stiffness k that forgets with time constant T: stiff grease, rubber hose
    "creep": Spec("joint", {"k": REQUIRED, "T": REQUIRED}),
    # torque amplitude · q̇i · q̇j on joint i: gyroscopic wheel in the drive
    "gyroscope": Spec("pair", {"amplitude": REQUIRED}),
}

ALL = {**LISTED, **UNLISTED}
# scales, widths, stiffnesses and time constants: an effect has no meaning without them
ABOVE_ZERO = {"vs", "delta", "p", "T", "power", "width", "K", "mass", "gain", "N"}
