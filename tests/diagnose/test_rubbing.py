"""Friction that is other in the runs held out than in those fitted, and no warm-up from cold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bare_sides import ar1
from two_links import motion, recordings, robot, state_of, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.unknown.rubbing import other_friction
from pa10d.identify.procedure import identify
from pa10d.report.finding_section import Asked
from pa10d.report.unexplained_section import unexplained_section
from pa10d.report.verdict import structure_words

LOST, T, SECONDS = 1.5, 12.0, 30.0  # N·m·s/rad, s, s


def warming(begins):
    """A run to fit and one held out, of which joint 2's grease is so many s old as each begins."""
    runs = recordings(4, noise=0.02)
    out = []
    for name, number, age in zip(("fit_a", "valid_a"), (0, 2), begins, strict=True):
        t, _, dq, _ = motion(400 + number)
        tau = runs[name].tau.copy()
        tau[:, 1] += LOST * np.exp(-(t + age) / T) * dq[:, 1]
        out.append(replace(runs[name], tau=tau))
    return out


def diagnosed(begins):
    fit, held = warming(begins)
    return diagnose(identify([fit], robot(), name="m0", cutoff=8.0), [fit], [held])


@pytest.mark.long
def test_a_warm_up_that_goes_on_in_the_run_held_out_is_told():
    """It was "motion does not predict it: slow noise, or what this data cannot show"."""
    found = diagnosed((0.0, SECONDS))
    line = found.remaining[1]
    assert (found.verdict, found.findings, line.significant) == ("unknown", (), True)
    assert "its friction is lower in the runs held out" in line.sentence
    assert "it falls in the course of these, too" in line.sentence
    assert "slow noise" not in line.sentence
    section = unexplained_section(found, found.unexplained[0], None, Asked("m0", ["a"], ["b"]))
    assert section.title == "Joint 2: friction that is other in the runs held out"
    assert "is gone if its friction is lower" in structure_words(found.unexplained[0])
    assert not found.remaining[0].material


@pytest.mark.long
def test_where_both_begin_cold_it_is_named():
    found = diagnosed((0.0, 0.0))
    assert [(f.term.effect_id, f.term.joints) for f in found.findings] == [
        ("thermal_friction", (1,))
    ]
    assert not found.unexplained


@pytest.mark.long
@pytest.mark.parametrize("phi", [0.0, 0.9, 0.99, 0.9995])
def test_slow_noise_is_no_friction(phi):
    for seed in range(6):
        runs = recordings(seed, colour=lambda rng, n: ar1(rng, n, phi))
        assert other_friction(state_of(runs, textbook(runs)), [0, 1]) == []
