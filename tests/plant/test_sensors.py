"""What is measured against what is true: counts, gains, offsets, delays, saturation, noise."""

import numpy as np
import pytest
from plant_robots import bare, seven_axes, turntable
from scipy.signal import welch

from backends.virtual.plant import build

DT = 0.002


def held(plant, torques):
    """Measured torque (N,) of joint 1 under a sequence of held torques."""
    out = []
    for torque in torques:
        plant.step(np.full(plant.n, torque), DT)
        out.append(plant.measure()[1][0])
    return np.array(out)


def test_encoder_counts():
    plant = build(seven_axes(), noise="none")
    plant.reset(np.linspace(-1, 1, 7) * 0.7)
    counts = plant.measure()[0] * 819200 / (2 * np.pi)
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert np.all(np.abs(plant.measure()[0] - plant.state.q) <= np.pi / 819200 * 1.000001)


def test_encoder_offset_is_read_not_lived(tmp_path):
    plant = bare(turntable(tmp_path), [{"effect": "encoder_offset", "joint": 1, "offset": 0.03}])
    plant.reset(np.array([0.5]))
    assert plant.measure()[0][0] == pytest.approx(0.53)
    assert plant.state.q[0] == 0.5


def test_gain_and_offset_of_the_current_sensor(tmp_path):
    effects = [
        {"effect": "torque_gain", "joint": 1, "gain": 1.2},
        {"effect": "torque_offset", "joint": 1, "offset": 0.7},
    ]
    plant = bare(turntable(tmp_path, inertia=2.0), effects)
    np.testing.assert_allclose(held(plant, [3.0, -5.0]), [4.3, -5.3])
    assert plant.state.v[0] == pytest.approx((3.0 - 5.0) * DT / 2.0)


@pytest.mark.parametrize("delay", [0.0, 0.0013, 0.002, 0.0075])
def test_delayed_torque_lags_by_the_delay(tmp_path, delay):
    """A staircase that rises evenly is read as the same staircase, later by Td on average."""
    plant = bare(turntable(tmp_path), [{"effect": "torque_delay", "joint": 1, "Td": delay}])
    stairs = 10.0 * np.arange(40) * DT
    read = held(plant, stairs)
    np.testing.assert_allclose(stairs[10:] - read[10:], 10.0 * delay, atol=1e-12)


def test_delay_beyond_memory_is_refused(tmp_path):
    from pa10d.common.errors import UserError

    plant = bare(turntable(tmp_path), [{"effect": "torque_delay", "joint": 1, "Td": 2.0}])
    with pytest.raises(UserError, match="torque_delay"):
        plant.step(np.zeros(1), DT)


def test_saturated_motor_gives_less_than_it_says(tmp_path):
    effect = {"effect": "torque_saturation", "joint": 1, "cubic": 1e-4}
    plant = bare(turntable(tmp_path, inertia=2.0), [effect])
    assert held(plant, [30.0])[0] == 30.0
    assert plant.state.v[0] == pytest.approx((30.0 - 1e-4 * 30.0**3) * DT / 2.0)


@pytest.mark.long
def test_noise_levels_and_colours():
    profile, spectra = seven_axes(), {}
    for kind in ("white", "strong", "coloured"):
        plant = build(profile, noise=kind, seed=1, dynamics={"coulomb": 100.0})
        log = [plant.step(np.zeros(7), DT) or plant.measure()[1] for _ in range(8000)]
        noise = np.array(log)
        spectra[kind] = welch(noise, 500.0, nperseg=2000, axis=0)[1]
        if kind == "white":
            np.testing.assert_allclose(
                noise.std(axis=0)[[0, 2, 4]], [0.5, 0.277, 0.0718], rtol=0.05
            )
            assert np.all(np.abs(np.corrcoef(noise.T) - np.eye(7)) < 0.05)
    frequency = np.fft.rfftfreq(2000, DT)
    low, high = (frequency > 0.2) & (frequency < 1.5), frequency > 100
    white, strong, coloured = (
        (s[low].mean(), s[high].mean())
        for s in (spectra["white"], spectra["strong"], spectra["coloured"])
    )
    assert white[0] == pytest.approx(white[1], rel=0.3)
    assert strong[1] == pytest.approx(16 * white[1], rel=0.1)
    assert coloured[0] > 30 * white[0]
    assert coloured[1] < 1.5 * white[1]


def test_same_seed_same_noise_other_seed_other_noise():
    profile = seven_axes()

    def readings(seed):
        plant = build(profile, seed=seed)
        plant.reset(np.zeros(7))
        first = plant.measure()[1]
        plant.reset(np.zeros(7))
        return first, plant.measure()[1]

    one, same, other = readings(3), readings(3), readings(4)
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one[0], other[0])
    assert not np.array_equal(one[0], one[1])  # a second run is not a repeat of the first
