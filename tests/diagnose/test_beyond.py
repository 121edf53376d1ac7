"""Error where the fit side has never been: said, with the place, instead of called a mystery."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from two_links import recordings, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.beyond import Beyond, places_of
from pa10d.diagnose.unknown.claims import unnamed
from pa10d.diagnose.unknown.of_joint import KnownBesides
from pa10d.diagnose.unknown.remaining import remaining
from pa10d.judgement import Judgement, NoiseFloor

PLACE = Beyond(0, "q1", "rad", above=True, edge=0.4, share=0.99, time=0.3)


@given(st.floats(0.02, 0.9), st.floats(0.0, 1.0), st.booleans())
def test_a_place_is_where_more_error_lies_than_time_is_spent(time, much, above):
    there = np.arange(1000) < 1000 * time
    held = np.where(there, 2.0, 0.5) * (1.0 if above else -1.0)
    residual = np.where(there, 1.0, np.sqrt(1.0 - much))
    share = np.sum(residual[there] ** 2) / np.sum(residual**2)
    found = places_of(0, "q1", "rad", np.linspace(-1.0, 1.0, 50), held, residual)
    if share > there.mean() + 0.5 * (1.0 - there.mean()):
        (place,) = found
        assert place.above == above
        assert place.edge == (1.0 if above else -1.0)
        assert place.share == pytest.approx(share)
        assert place.time == pytest.approx(there.mean())
    else:
        assert not found


def test_noise_alone_is_in_no_place():
    rng = np.random.default_rng(1)
    held, fitted = rng.uniform(-2, 2, 4000), rng.uniform(-1, 1, 4000)
    assert not places_of(0, "q1", "rad", fitted, held, rng.standard_normal(4000))
    assert not places_of(0, "q1", "rad", fitted, held, np.zeros(4000))


@pytest.mark.parametrize("source", ["high frequencies", None])
@pytest.mark.parametrize("ratio", [3.0, 130.0])
def test_the_line_says_the_place_and_what_to_do(ratio, source):
    floor = np.array([0.1 if source else np.nan])
    known = NoiseFloor(floor, (source,), 0.01 * floor, np.ones(1))
    left = Judgement("m", ("run",), 10.0, 0.1 * np.array([ratio]), known)
    claims = unnamed(left, [None], [], np.zeros(1))
    (line,) = remaining(left, [None], claims, ["N·m"], KnownBesides(beyond=[PLACE]))
    assert (
        "99 % of its squared error lies where q1 is above 0.4 rad, where the fit" in line.sentence
    )
    assert "Fit to motion that goes there." in line.sentence
    assert "noise that is slow" not in line.sentence
    (line,) = remaining(left, [None], claims, ["N·m"], KnownBesides(beyond=[None]))
    assert "has not been" not in line.sentence


@pytest.mark.parametrize("all_along", [True, False])
def test_what_the_fitted_runs_do_not_show_is_said_with_its_place(all_along):
    """Beside "as if a spring were there" nothing said that they never went there."""
    runs = {"runs": (), "others": ()} if all_along else {"runs": ("b",), "others": ("a",)}
    asked = Apart(0, 0.74, 0.9, 0.0, effects=("a spring",), held_out=True, **runs)
    known = NoiseFloor(np.array([0.1]), ("high frequencies",), np.array([0.001]), np.ones(1))
    left = Judgement("m", ("run",), 10.0, np.array([1.0]), known)
    (line,) = remaining(left, [None], [asked], ["N·m"], KnownBesides(beyond=[PLACE]))
    assert ("lies where q1 is above 0.4 rad" in line.sentence) is all_along


@pytest.mark.long
def test_a_stop_that_only_the_held_out_runs_touch():
    """130 times the floor was "a cause that is not in the recording, or noise that is slow"."""
    farthest = {name: run.q[:, 0].max() for name, run in recordings(4).items()}
    edge = max(farthest["fit_a"], farthest["fit_b"])
    assert min(farthest["valid_a"], farthest["valid_b"]) > edge + 0.2

    def stop(t, q, dq, ddq):
        return np.column_stack([60.0 * np.maximum(0.0, q[:, 0] - edge), np.zeros(len(t))])

    hit = recordings(4, stop)
    found = diagnose(textbook(hit), [hit["fit_a"], hit["fit_b"]], [hit["valid_a"], hit["valid_b"]])
    line = found.remaining[0]
    assert line.ratio > 3.0
    assert "lies where q1 is above" in line.sentence


@pytest.mark.long
def test_a_change_where_the_runs_that_it_is_sought_in_have_not_been():
    """A stop that only the held-out runs touch: of a frozen model's error it was said that it lies
    where the joint brakes hard."""
    calm = recordings(4)
    edge = max(calm[name].q[:, 0].max() for name in ("fit_a", "fit_b"))

    def stop(t, q, dq, ddq):
        return np.column_stack([60.0 * np.maximum(0.0, q[:, 0] - edge), np.zeros(len(t))])

    hit = recordings(4, stop)
    runs = [hit["fit_a"], hit["fit_b"]], [hit["valid_a"], hit["valid_b"]]
    found = diagnose(textbook(calm), *runs, frozen=True)
    assert found.findings == ()
    assert "lies where q1 is above" in found.remaining[0].sentence
