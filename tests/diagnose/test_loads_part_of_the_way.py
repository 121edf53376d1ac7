"""What follows the loads of a model draws its bodies along, and those the loads."""

from __future__ import annotations

import numpy as np
import pytest
from small_machines import machine

from pa10d.diagnose.procedure import diagnose
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording

FIT = (
    "sin_sin_kp100",
    "sin_sin_kp200",
    "sin_time_square_kp200",
    "up_and_down_kp200",
    "up_and_down_kp400",
)
JUDGE = ("sin_sin_kp400", "sin_time_square_kp400")
MORE = 0.02  # N·m·s/rad: half of what it drags more one way than the other


def dragged(run: Recording) -> Recording:
    """The servo's run with a viscous drag that acts in one direction."""
    speed = np.gradient(run.q[:, 0]) * run.rate
    tau = run.tau + 2 * MORE * np.maximum(speed, 0.0)[:, None]
    return Recording(run.name, run.t, run.q, tau)


@pytest.mark.long
def test_drag_in_one_direction_is_named_beside_friction_of_a_load():
    """Added, it drew the weight, that its load, and that friction of the load below zero: 0.104 N·m
    where 0.091 had been without, and neither was named with the other."""
    robot, runs = machine("bam_xl330", [f"xl330_{name}.csv" for name in (*FIT, *JUDGE)])
    runs = [dragged(run) for run in runs]
    model = identify(runs[: len(FIT)], robot, name="m0")
    found = diagnose(model, runs[: len(FIT)], runs[len(FIT) :])
    named = {f.term.effect_id: f.parameters for f in found.findings}
    assert {"load_friction", "coulomb_asymmetry"} <= set(named)
    more = named["coulomb_asymmetry"]["dFv"]
    assert abs(more.value - MORE) < 3 * more.std_error
    assert more.std_error < 0.2 * MORE
    promise = found.model.notes.delivery
    assert np.allclose(promise.achieved, promise.promised, rtol=0.02)
