"""Regions and curves are found where they were put, and nowhere in noise."""

import compare_arm as arm
import numpy as np
import pytest

from pa10d.compare import places, run_residual
from pa10d.compare.curves import Curve
from pa10d.compare.phrases import sentence
from pa10d.compare.quantities import Quantity
from pa10d.compare.regions import Region


def found(extra=None, noise=0.2, seeds=(1, 2), level=0.01, **more):
    runs = [
        run_residual(
            arm.model(), arm.recording(seed, noise=noise, extra=extra, name=f"r{seed}", **more)
        )
        for seed in seeds
    ]
    return places(runs, arm.ROBOT, level=level)


def test_an_error_at_low_speed_is_found_there():
    def stribeck(t, q, dq):
        return arm.on_joint(1, 1.5 * np.exp(-((dq[:, 1] / 0.12) ** 2)) * np.tanh(dq[:, 1] / 0.01))

    best = next(place for place in found(stribeck) if isinstance(place.what, Region))
    assert best.joint == 1
    assert best.variable in ("|dq2|", "dq2", "reversal_time2", "reversal_travel2")
    assert best.what.share > 2 * best.what.samples
    if best.variable == "|dq2|":
        assert best.what.open_low
        assert 0.05 < best.what.high < 0.4
    assert "Joint 2" in best.sentence
    assert "of its squared error" in best.sentence


@pytest.mark.long
def test_a_contact_beyond_one_angle_is_found_there():
    def contact(t, q, dq):
        return arm.on_joint(2, 8.0 * np.maximum(0.0, q[:, 2] - 0.8))

    best = found(contact)[0]
    assert (best.joint, best.variable) == (2, "q3")
    region = next(p.what for p in found(contact) if isinstance(p.what, Region))
    assert region.open_high
    assert 0.6 < region.low < 1.2


@pytest.mark.long
def test_the_share_is_the_share():
    def contact(t, q, dq):
        return arm.on_joint(2, 8.0 * np.maximum(0.0, q[:, 2] - 0.8))

    runs = [
        run_residual(arm.model(), arm.recording(seed, extra=contact, name=f"{seed}"))
        for seed in (1, 2, 3)
    ]
    region = next(p.what for p in places(runs, arm.ROBOT) if isinstance(p.what, Region))
    q, e = (
        np.concatenate([of(run)[run.counts[:, 2], 2] for run in runs])
        for of in (lambda run: run.decimated(run.seen.q), lambda run: run.error)
    )
    inside = (q >= region.low) & (q <= region.high)
    assert region.quantity.name == "q3"
    assert region.share == pytest.approx(np.sum(e[inside] ** 2) / np.sum(e**2))
    assert region.samples == pytest.approx(np.mean(inside))


def test_a_constant_error_is_called_one():
    constant = found(lambda t, q, dq: arm.on_joint(0, np.full(len(t), 0.4)))
    assert [(p.joint, p.variable) for p in constant] == [(0, "constant")]
    assert constant[0].what.level == pytest.approx(0.4, abs=0.05)
    assert "constant +0.4" in constant[0].sentence


def test_a_slope_against_angle_is_a_curve():
    sloped = found(lambda t, q, dq: arm.on_joint(1, 0.5 * q[:, 1]))
    curve = next(p for p in sloped if isinstance(p.what, Curve))
    assert (curve.joint, curve.variable) == (1, "q2")
    assert curve.what.share > 0.5


def test_a_late_drift_is_found_in_time():
    def drift(t, q, dq):
        return arm.on_joint(0, np.where(t > 30.0, 0.6 * np.tanh(dq[:, 0] / 0.05), 0.0))

    best = next(p for p in found(drift) if isinstance(p.what, Region))
    assert (best.joint, best.variable) == (0, "time")
    assert best.what.low == pytest.approx(30.0, abs=3.0)


@pytest.mark.long
@pytest.mark.by_default("0.99")
@pytest.mark.parametrize("coloured", [0.0, 0.99])
def test_noise_alone_makes_no_place(coloured):
    for seed in range(4):
        assert found(seeds=(20 + seed,), coloured=coloured, level=1e-3) == []


@pytest.mark.long
@pytest.mark.parametrize("coloured", [0.0, 0.97, 0.998])
def test_false_places_stay_at_the_level(coloured):
    """The level is 1 % per comparison; 80 comparisons may show 4 by chance (p < 0.01)."""
    alarms = sum(
        bool(found(seeds=(100 + seed,), coloured=coloured, seconds=30.0)) for seed in range(80)
    )
    assert alarms <= 4


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        (0.12, 0.3, "between 0.12 and 0.30 rad/s"),
        (0.1201, 0.1248, "between 0.120 and 0.125 rad/s"),
        (0.12, 0.12, "at 0.120000 rad/s"),
    ],
)
def test_a_narrow_range_has_two_ends(low, high, said):
    """ "between 0.12 and 0.12 m/s" says nothing."""
    found = Region(Quantity("|dq|", 0, "rad/s"), low, high, False, False, 0.5, 0.1)
    assert sentence(0, found, "N·m").startswith(f"Joint 1 {said} carries 50 %")
