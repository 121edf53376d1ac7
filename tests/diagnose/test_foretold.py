"""What motion foretells is no noise, though the held-out side moves where no fit was made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bare_sides import ar1
from foreign_laws import on, turn
from two_links import NAMES, motion, recordings, robot, state_of, textbook, textbook_torque

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.unknown.foretold import foretold
from pa10d.dynamics import inverse_dynamics
from pa10d.measurement.recording import Recording

AWAY = np.array([4.0, 4.0])  # rad, by which the held-out side moves around another pose


def squeezed(t, q, dq, ddq):
    """(N, 2) N·m: a bearing that the load of the other joint clamps."""
    load = inverse_dynamics(robot(), robot().parameters, q, dq, ddq)
    return 0.3 * on(1, turn(dq[:, 1]) * np.abs(load[:, 0]))


def elsewhere(seed: int, extra=None, colour=None) -> dict[str, Recording]:
    """Runs of which those to judge by move where the others never do."""
    out = recordings(seed, extra=extra, colour=colour)
    for number, name in enumerate(NAMES[2:], 2):
        _, q, dq, ddq = motion(100 * seed + number)
        noise = out[name].tau - textbook_torque(q, dq, ddq)
        tau = textbook_torque(q + AWAY, dq, ddq) + noise
        out[name] = replace(out[name], q=q + AWAY, tau=tau)
    return out


def test_what_the_held_out_side_cannot_say_is_said_by_stretches_of_the_fit_side():
    runs = elsewhere(5, extra=squeezed)
    found = diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    assert found.verdict != "none"
    line = found.remaining[1]
    assert 2 < line.ratio < 10  # by its size alone it might be slow noise
    assert line.significant
    assert "from one stretch to another" in line.sentence


@pytest.mark.parametrize("seeds", [range(1), pytest.param(range(1, 40), marks=pytest.mark.long)])
def test_noise_of_one_stretch_foretells_no_other(seeds):
    """However slow: what is beside a stretch in time is not asked about it."""
    colours = {"white": None, "coloured": 0.99, "slow": 0.999, "slower": 0.9995}
    said = {
        (name, seed): found
        for name, phi in colours.items()
        for seed in seeds
        if (
            found := foretold(
                state_of(
                    elsewhere(
                        60 + seed,
                        colour=None if phi is None else lambda rng, n, phi=phi: ar1(rng, n, phi),
                    )
                ),
                [0, 1],
            )
        )
    }
    assert not said
