"""What moves several joints' errors together is told by each of the others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import six_fast as six
from bare_sides import ar1
from test_remaining import judged

from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.diagnose.unknown.common_cause import in_common
from pa10d.diagnose.unknown.remaining import remaining
from pa10d.dynamics import inverse_dynamics
from pa10d.effects.library.base_tilt import rotation
from pa10d.identify import identify
from pa10d.measurement.recording import Recording

SECONDS = (24.0, 16.0)
PACE = 0.15  # of six fast joints: gravity is seen
TIPS = 0.052, 0.035  # rad, about x and y


def runs(seed: int, extra=None, colour: float = 0.0) -> list[Recording]:
    """To fit and to judge by."""
    out = []
    for k, seconds in enumerate(SECONDS):
        run = six.recording(f"r{k}", 2 * seed + k, seconds, extra, PACE)
        if colour:
            rng = np.random.default_rng([seed, k])
            shape = run.tau.shape
            slow = np.column_stack([ar1(rng, shape[0], colour) for _ in range(shape[1])])
            run = replace(run, tau=run.tau + 3.0 * six.NOISE * six.LIMITS * slow)
        out.append(run)
    return out


def state_between(fit: Recording, judge: Recording) -> SearchState:
    """The textbook model of the one, asked about the other."""
    model = identify([fit], six.robot(), name="m0")
    train, held, _ = two_sides(model, [fit], [judge])
    return SearchState.start(model, train, held)


def tipping(q, dq, ddq, rigid):
    """The base tips to and fro by 3° about x and 2° about y, at frequencies of its own."""
    t = np.arange(len(q)) / six.RATE
    still = np.zeros_like(q)
    plain = inverse_dynamics(six.robot(), six.robot().parameters, q, still, still)
    out = np.zeros_like(q)
    for axis, angle, hertz in zip((0, 1), TIPS, (0.37, 0.53), strict=True):
        turned = six.robot().with_gravity(rotation(axis, 0.01).T @ six.robot().gravity)
        by = (inverse_dynamics(turned, turned.parameters, q, still, still) - plain) / 0.01
        out += by * (angle * np.sin(2 * np.pi * hertz * t + axis))[:, None]
    return out


def jittered(run: Recording, seed: int, scatter: float) -> Recording:
    """Positions of moments that scatter (s, standard deviation) around their even stamps."""
    rng = np.random.default_rng([seed, 77])
    when = run.t + scatter * rng.standard_normal(len(run.t))
    q = np.column_stack([np.interp(when, run.t, x) for x in run.q.T])
    return replace(run, q=q)


def told(found: list[Recording]) -> dict[int, Unnamed]:
    """By joint."""
    joints = range(six.robot().n)
    return {one.joint: Unnamed.of_common(one) for one in in_common(state_between(*found), joints)}


def test_a_base_that_tips_is_told_by_the_other_joints():
    """ "Motion does not predict it: slow noise", of three joints at 2 to 6 times their floors."""
    found = told(runs(3, tipping))
    assert {1, 2} <= set(found)
    assert {one.witness for one in found.values()} == {"sway"}
    assert found[1].share > 0.4
    assert found[1].degrees == pytest.approx(
        np.degrees(np.hypot(0.052, 0.035) / np.sqrt(2)), rel=0.3
    )
    (*_, line) = remaining(judged(5.0, 5.0), [None] * 2, [found[1]], ["N·m"] * 2)
    assert "a base that tips or gives, or a load that swings" in line.sentence


@pytest.mark.long
def test_stamps_that_scatter_are_told_by_the_other_joints():
    """Seven joints at 3 to 4 times their floors, each with a region of its own by accident."""
    found = told([jittered(run, k, 1e-3) for k, run in enumerate(runs(4))])
    assert {1, 2} <= set(found)
    assert {one.witness for one in found.values()} == {"stamps"}
    (*_, line) = remaining(judged(5.0, 5.0), [None] * 2, [found[1]], ["N·m"] * 2)
    assert "rather of the recording than of the arm" in line.sentence


@pytest.mark.long
@pytest.mark.parametrize("seeds", [range(1), pytest.param(range(1, 20), marks=pytest.mark.long)])
@pytest.mark.parametrize(
    "colour", [0.99, *(pytest.param(phi, marks=pytest.mark.long) for phi in (0.0, 0.999))]
)
def test_noise_of_one_joint_tells_nothing_of_another(seeds, colour):
    for seed in seeds:
        sides = runs(10 + seed, colour=colour)
        assert in_common(state_between(*sides), range(six.robot().n)) == []
