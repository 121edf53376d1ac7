"""Order and frequency spectra, whiteness, autocorrelation, reversals: against plain formulas."""

import compare_arm as arm
import numpy as np
import pytest
import scipy.signal
from scipy import stats

from pa10d.compare import compare, run_residual
from pa10d.compare.above_band import lines_above_band
from pa10d.compare.angle_periodogram import periodogram
from pa10d.compare.correlation import autocorrelation
from pa10d.compare.frequencies import frequency_spectrum
from pa10d.compare.order_lines import has_line
from pa10d.compare.orders import OrderSpectrum, order_spectrum
from pa10d.compare.reversals import reversal_samples, since_reversal
from pa10d.compare.surrogates import chance, surrogates
from pa10d.compare.whiteness import in_band, whiteness


def residual(extra=None, **more):
    return [run_residual(arm.model(), arm.recording(3, extra=extra, **more))]


def test_periodogram_is_least_squares_at_every_order():
    rng = np.random.default_rng(0)
    q = 1.3 * np.sin(np.linspace(0, 40, 3000)) + rng.normal(0, 0.01, 3000)
    y = np.sin(17.5 * q) + rng.standard_normal(3000)
    order = np.array([5.0, 17.5, 17.75, 60.25])
    share, amplitude = periodogram(q, y, order)
    for k, n in enumerate(order):
        basis = np.column_stack([np.cos(n * q), np.sin(n * q), np.ones_like(q)])
        fit, rest, *_ = np.linalg.lstsq(basis, y, rcond=None)
        assert share[k] == pytest.approx(1 - rest[0] / np.sum((y - y.mean()) ** 2), abs=2e-3)
        assert amplitude[k] == pytest.approx(np.hypot(fit[0], fit[1]), rel=0.02, abs=2e-3)


def test_ripple_is_one_line_at_its_order_with_its_amplitude():
    runs = residual(lambda t, q, dq: arm.on_joint(1, 0.3 * np.sin(37.5 * q[:, 1] + 0.4)))
    lines = order_spectrum(runs, 1).lines
    assert len(lines) == 1
    assert lines[0] == (pytest.approx(37.5, abs=0.05), pytest.approx(0.3, rel=0.1))
    assert order_spectrum(runs, 0).lines == ()


def test_what_the_low_pass_hides_is_told():
    """Ripple of 0.5 N·m that the joint's speed takes above the cut-off."""

    def extra(t, q, dq):
        return arm.on_joint(1, 0.5 * np.sin(130.5 * q[:, 1] + 0.4))

    warnings = [
        compare(arm.model(), [arm.recording(1, 40.0, 0.1, more)]).warnings for more in (extra, None)
    ]
    (said,) = (w for w in warnings[0] if "comes again" in w)
    assert said.startswith("joint 2: an error that comes again 130.5 (0.5")
    higher = float(said.partition("--cutoff ")[2])
    frequency = float(said.partition("at about ")[2].partition(" Hz")[0])
    assert higher == pytest.approx(1.5 * frequency, rel=0.05)
    assert not [w for w in warnings[1] if "comes again" in w]


@pytest.mark.parametrize("of_torque", [1.0, 0.0])
def test_a_line_of_the_models_torque_alone_is_none_of_the_gears(of_torque):
    """An encoder's steps, differentiated twice, were "1.7 N·m 834 times a turn"."""
    rng = np.random.default_rng(2)
    t = np.arange(8000) / 200
    q, dq = 1.2 * np.sin(0.5 * t), 0.6 * np.cos(0.5 * t)
    line = 0.5 * np.sin(830.5 * q + 0.3)
    torque = 20.0 * np.sin(q) + 3.0 * np.sign(dq) + of_torque * line + rng.normal(0, 0.3, len(t))
    error = torque - (20.0 * np.sin(q) + 3.0 * np.sign(dq) - (1.0 - of_torque) * line)
    assert has_line(q, dq, torque, error, 830.5) == bool(of_torque)
    found = OrderSpectrum(
        *np.zeros((3, 1)), ((830.5, 0.5), (12.0, 0.4)), (bool(of_torque), True), 0.6, 200.0
    )
    assert found.above(10.0) == ([(830.5, 0.5)] if of_torque else [])


def test_a_vibration_in_hertz_is_no_order():
    runs = residual(lambda t, q, dq: arm.on_joint(1, 0.3 * np.sin(2 * np.pi * 18.0 * t)))
    assert order_spectrum(runs, 1).lines == ()
    spectrum = frequency_spectrum(runs, 1)
    assert spectrum.frequency[np.argmax(spectrum.error)] == pytest.approx(18.0, abs=0.3)


def test_white_noise_has_its_density():
    spectrum = frequency_spectrum(residual(noise=0.5, seconds=120.0), 0)
    assert np.sqrt(np.mean(spectrum.error**2)) == pytest.approx(
        0.5 * np.sqrt(2 / arm.RATE), rel=0.03
    )


def test_white_noise_is_white_and_coloured_noise_is_not():
    p = [
        whiteness([run_residual(arm.model(), arm.recording(seed))], j).p_value
        for seed in range(4)
        for j in range(3)
    ]
    assert stats.kstest(p, "uniform").pvalue > 1e-3
    assert whiteness(residual(coloured=0.98), 0).p_value < 1e-6


def test_gaps_do_not_colour_white_noise():
    rng = np.random.default_rng(4)
    p = []
    for _ in range(40):
        counts = np.ones(5000, dtype=bool)
        for start in rng.integers(0, 4800, 8):
            counts[start : start + 200] = False
        x, mask = in_band(rng.standard_normal(5000), counts, 400)
        found = autocorrelation([(x, mask)], 21)
        p.append(stats.chi2.sf(np.sum(found.pairs[1:] * found.rho[1:] ** 2), 20))
    assert 0.2 < np.mean(np.array(p) < 0.5) < 0.8
    assert np.mean(np.array(p) < 0.01) < 0.15


def test_memory_of_a_first_order_process():
    rng = np.random.default_rng(0)
    x = scipy.signal.lfilter([1], [1, -0.9], rng.standard_normal(200_000))
    found = autocorrelation([(x, np.ones(len(x), dtype=bool))], 400)
    assert found.time == pytest.approx(1.9 / 0.1, rel=0.08)
    assert found.effective == pytest.approx(len(x) * 0.1 / 1.9, rel=0.08)


def test_reversals_of_a_sine():
    t = np.arange(5000) / 500
    q, dq = np.cos(2 * np.pi * 0.5 * t + 0.3), -np.pi * np.sin(2 * np.pi * 0.5 * t + 0.3)
    expected = (np.arange(1, 11) * np.pi - 0.3) / np.pi
    assert t[reversal_samples(dq)] == pytest.approx(expected, abs=0.003)
    time, travel = since_reversal(q, dq, 1 / 500)
    first = int(np.ceil(expected[0] * 500))
    assert np.all(np.isnan(time[: first - 1]))
    assert time[first + 50] == pytest.approx(t[first + 50] - expected[0], abs=0.003)
    assert travel[first + 50] == pytest.approx(abs(q[first + 50] + 1.0), abs=1e-3)


def test_noise_around_zero_speed_is_no_reversal():
    rng = np.random.default_rng(0)
    dq = np.concatenate([np.linspace(1, 0, 500), rng.normal(0, 0.002, 500), np.linspace(0, 1, 500)])
    assert len(reversal_samples(dq)) == 0


def test_surrogates_have_the_values_and_the_memory_but_not_the_phases():
    rng = np.random.default_rng(1)
    x = scipy.signal.lfilter([1], [1, -0.95], rng.standard_normal(6000))
    exists = np.ones(6000, dtype=bool)
    exists[2000:2600] = False
    drawn = surrogates([(x, exists)], rng, 40)
    assert np.allclose(np.sort(drawn, axis=0), np.sort(x[exists])[:, None])
    lag = [float(np.corrcoef(s[:1900], s[20:1920])[0, 1]) for s in drawn.T]
    assert np.mean(lag) == pytest.approx(0.95**20, abs=0.1)
    assert abs(np.mean([np.corrcoef(s, x[exists])[0, 1] for s in drawn.T])) < 0.1


def test_chance_continues_beyond_the_sample():
    rng = np.random.default_rng(2)
    maxima = rng.standard_normal((100, 50)).max(axis=1)
    exact = stats.norm.sf(4.5) * 50
    assert exact / 20 < chance(4.5, maxima) < exact * 20
    assert chance(float(np.median(maxima)), maxima) == pytest.approx(0.5, abs=0.12)


@pytest.mark.parametrize(("rate", "cutoff"), [(1000.0, "120"), (200.0, "90")])
def test_the_cut_off_that_is_advised_is_one_that_the_samples_allow(rate, cutoff):
    """1.5 times a line at 80 Hz was refused for samples at 200 Hz."""
    nothing = np.zeros(1)
    found = OrderSpectrum(nothing, nothing, nothing, ((80.0, 0.5),), (True,), 2 * np.pi, rate)
    (said,) = lines_above_band([found], 12.0, np.array([0.01])).values()
    assert said.endswith(f"--cutoff {cutoff}")
