"""What MuJoCo's arms hide is named, on its joint and within its errors; clean ones are cleared,
however their recordings were soiled."""

from __future__ import annotations

import pytest

from pa10d.diagnose.procedure import diagnose
from pa10d.identify.procedure import identify

pytest.importorskip("mujoco")
from mujoco_arms import machine, recordings

FEW = 4.0  # standard errors

EFFECTS = {
    "stribeck": ("stribeck", {"Fs": 1, "vs": 2}),
    "spring": ("spring", {"k": 1, "q0": 2}),
    "gap": ("backlash", {"b": 1}),
    "worn": ("position_friction", {"A": 1, "qc": 2, "w": 3}),
    "warm": ("thermal_friction", {"T": 2}),
    "ripple": ("torque_ripple", {"amplitude": 1, "N": 2}),
    "stop": ("contact", {"k": 1, "qs": 2}),
    "pair": ("coupling_friction", {"F": 1}),
    "delay": ("torque_delay", {}),
}
"""kind -> the library's effect, and where the kind's numbers stand that it shares with it."""


@pytest.mark.long
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("kinds", "seed", "dirt"),
    [
        ("none", 11, ""), ("none", 133, "quantised"), ("none", 167, "jitter"),
        ("none", 184, "averaged"), ("none", 201, "slow noise"), ("none", 218, "short"),
        ("stribeck", 22, ""), ("spring", 33, ""), ("gap", 55, ""), ("worn", 77, ""),
        ("warm", 88, ""), ("ripple", 26, ""), ("stop", 39, ""), ("pair", 52, ""),
        ("delay", 65, ""), ("stribeck+spring", 133, "quantised"),
        ("stribeck+spring", 167, "jitter"), ("stribeck+spring", 184, "averaged"),
        ("stribeck+spring", 201, "slow noise"), ("stribeck+spring", 218, "short"),
    ],
)  # fmt: skip
def test_what_another_simulator_hides_is_named(kinds, seed, dirt):
    made, robot = machine(seed, kinds)
    runs = recordings(made, seed, dirt)
    found = diagnose(identify(runs[:2], robot, name="m0"), runs[:2], runs[2:])
    named = {(f.term.effect_id, f.term.joints): f.parameters for f in found.findings}
    wanted = {}
    for kind, numbers in made.hidden.items():
        effect_id, shared = EFFECTS[kind]
        joints = (numbers[0], numbers[0] + 1) if kind == "pair" else (numbers[0],)
        wanted[effect_id, joints] = {name: numbers[at] for name, at in shared.items()}
    assert set(named) == set(wanted)
    for place, values in wanted.items():
        for name, true in values.items():
            told = named[place][name]
            assert abs(told.value - true) < FEW * told.std_error, f"{place} {name}: {told}, {true}"
    if not wanted:
        assert found.verdict == "none"
