"""What acts when a joint has stood and moves again: a brake that lets go late."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import NAMES, RATE, textbook, textbook_torque

from pa10d.compare import compare
from pa10d.diagnose.procedure import diagnose
from pa10d.measurement.recording import Recording
from pa10d.measurement.standstill import since_rest

LATE, DRAG = 0.35, 6.0  # s, N·m
STROKES, REST = 14, 0.5  # in a run; s between them


def strokes(rng):
    """t (N,), q, q̇, q̈ (N, 2): from point to point by quintics, joints each in their own time."""
    q, dq, ddq = [], [], []
    for _ in range(2):
        at, parts = 0.0, []
        for _ in range(STROKES):
            to, s = rng.uniform(-1.2, 1.2), rng.uniform(1.2, 2.2)
            u = np.arange(round(s * RATE)) / (s * RATE)
            way = to - at
            parts.append(np.column_stack([
                at + way * u**3 * (10.0 - 15.0 * u + 6.0 * u**2),
                way / s * 30.0 * u**2 * (1.0 - u) ** 2,
                way / s**2 * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
            ]))  # fmt: skip
            parts.append(np.tile([to, 0.0, 0.0], (round(REST * RATE), 1)))
            at = to
        whole = np.vstack(parts)
        for out, column in zip((q, dq, ddq), whole.T, strict=True):
            out.append(column)
    n = min(map(len, q))
    return np.arange(n) / RATE, *(np.column_stack([x[:n] for x in y]) for y in (q, dq, ddq))


def released(dq: np.ndarray) -> np.ndarray:
    """(N,) N·m: the brake of a joint drags until LATE after it was told to let go."""
    out, began = np.zeros(len(dq)), -np.inf
    for k in range(1, len(dq)):
        if dq[k] != 0.0 and dq[k - 1] == 0.0:
            began = k / RATE
        out[k] = DRAG * np.sign(dq[k]) * (k / RATE - began < LATE)
    return out


def recorded(seed: int) -> dict[str, Recording]:
    runs = {}
    for number, name in enumerate(NAMES):
        rng = np.random.default_rng([seed, number])
        t, q, dq, ddq = strokes(rng)
        tau = textbook_torque(q, dq, ddq) + 0.05 * rng.standard_normal(q.shape)
        tau[:, 1] += released(dq[:, 1])
        runs[name] = Recording(name, t, q, tau)
    return runs


def test_time_since_a_rest():
    dq = np.repeat([0.0, 1.0, 0.0, -1.0], [50, 100, 50, 100])
    seen = since_rest(dq, 100.0)
    assert np.all(seen[:50] == 0.0)
    assert np.allclose(seen[50:150], np.arange(100) / 100.0, atol=0.02)
    assert np.all(np.isinf(since_rest(np.ones(100), 100.0)))
    turning = np.sin(np.arange(1000) / 100.0 * 6.0) + 1e-6
    assert np.all(np.isinf(since_rest(turning, 100.0)))  # it turns round, and never rests


@pytest.mark.long
def test_a_brake_that_lets_go_late_is_told_by_when_it_acts():
    """It was "motion does not predict it: slow noise" at tens of times the floor, and no region of
    the error stood out."""
    runs = recorded(5)
    model = textbook(runs)
    fit, judge = [runs[k] for k in NAMES[:2]], [runs[k] for k in NAMES[2:]]
    said = [place.sentence for place in compare(model, judge).pooled.where]
    assert any("Joint 2 below 0." in text and "after a rest" in text for text in said), said
    found = diagnose(model, fit, judge)
    assert found.verdict != "none"
    (line,) = [one for one in found.remaining if one.joint == 1]
    assert line.depends_on == ("dq2", "moving2"), line.sentence
    assert "A brake that lets go late" in line.sentence
