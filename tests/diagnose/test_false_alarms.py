"""On data with nothing hidden nothing is claimed: findings and unexplained entries alike."""

from __future__ import annotations

import json

import pytest
from bare_sides import ar1
from hidden_arms import arm, drawn, joints_of
from scipy.stats import binom
from two_links import recordings, textbook

from pa10d.diagnose.procedure import diagnose

LEVEL = 0.01  # of searches
NOISES = ("white", "strong", "coloured")


def claims(found) -> list[str]:
    """What is claimed, in words."""
    return [f.term.label for f in found.findings] + [
        f"J{u.joint + 1} depends on {', '.join(u.variables)}" for u in found.unexplained
    ]


def allowed(searches: int) -> int:
    """Most alarms that a true rate of LEVEL leaves within 99 % of all tests."""
    return int(binom.ppf(0.99, searches, LEVEL))


@pytest.mark.long
@pytest.mark.parametrize("seed", [11, 12])
@pytest.mark.parametrize("noise", NOISES)
def test_a_clean_arm_is_cleared(seed, noise):
    """Short sets of seven joints."""
    assert claims(arm(seed, noise=noise, seconds=15.0, cutoff=12.0).diagnose()) == []


COLOURS = {
    "white": None,
    "coloured": lambda rng, n: ar1(rng, n, 0.99),
    "slow": lambda rng, n: ar1(rng, n, 0.9995),
}


@pytest.mark.parametrize(
    ("names", "seeds"),
    [(["slow"], range(1)), pytest.param(list(COLOURS), range(24), marks=pytest.mark.long)],
    ids=["one", "many"],
)
def test_a_clean_small_arm_is_cleared_under_any_noise(names, seeds):
    said, searches = {}, 0
    for name, colour in ((name, COLOURS[name]) for name in names):
        for seed in seeds:
            runs = recordings(40 + seed, colour=colour)
            found = diagnose(
                textbook(runs),
                [runs["fit_a"], runs["fit_b"]],
                [runs["valid_a"], runs["valid_b"]],
            )
            searches += 1
            if claims(found):
                said[name, seed] = claims(found)
    assert len(said) <= allowed(searches), said


@pytest.mark.long
@pytest.mark.timeout(5400)
@pytest.mark.parametrize("noise", NOISES)
def test_false_alarms_over_clean_arms(noise, record_property):
    """67 sets of 4 × 40 s each with three kinds of noise, refitted."""
    said = _alarms(noise, range(100, 167), frozen=False)
    record_property("alarms", json.dumps(said))
    assert len(said) <= allowed(67), said


@pytest.mark.long
@pytest.mark.timeout(2400)
def test_false_alarms_of_a_frozen_model():
    """Nothing changed since the model was made."""
    said = {}
    for noise in NOISES:
        said.update(_alarms(noise, range(300, 310), frozen=True))
    assert len(said) <= allowed(30), said


def _alarms(noise: str, seeds: range, frozen: bool) -> dict[str, list[str]]:
    said = {}
    for seed in seeds:
        found = claims(arm(seed, noise=noise, frozen=frozen).diagnose())
        if found:
            said[f"{noise} {seed}"] = found
    return said


@pytest.mark.long
@pytest.mark.parametrize("name", ["spring"])
def test_the_short_sets_can_show_something(name):
    """The counterpart: with as little data, an effect is found."""
    hidden = drawn(name, 3)
    found = arm(13, [hidden], seconds=15.0, cutoff=12.0).diagnose()
    assert [(f.term.effect_id, f.term.joints) for f in found.findings] == [
        (name, joints_of(hidden))
    ]
