"""Structure that no effect is: three quantities and more, memories, other joints' pasts, changes
within a run. Its name may be wrong, but it is never called nothing."""

from __future__ import annotations

import numpy as np
import pytest
from foreign_laws import LAWS, cable_in_the_elbow, grease_that_remembers, heat_from_next_door
from two_links import motion, recordings, textbook, textbook_torque

from pa10d.diagnose.procedure import diagnose


def found_in(law, draw: int):
    """The diagnosis of an arm that obeys the law, and the joint on which it acts."""
    extra = law(np.random.default_rng([draw, 7]))
    runs = recordings(300 + draw, extra=extra)
    joint = int(np.argmax(np.sum(extra(*motion(1)) ** 2, axis=0)))
    return diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    ), joint


def _is_said(law, draw: int) -> None:
    found, joint = found_in(law, draw)
    assert found.verdict != "none"
    line = found.remaining[joint]
    assert line.ratio > 2
    assert line.significant
    assert line.material
    assert joint in {one.joint for one in found.unexplained}


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "draw"),
    [
        (heat_from_next_door, 1),
        (grease_that_remembers, 1),
    ],
)
def test_what_is_remembered_is_no_noise(law, draw):
    """No map of one or two quantities sees these."""
    _is_said(law, draw)


@pytest.mark.long  # test_structure finds such laws by themselves
def test_findings_do_not_hide_what_remains():
    _is_said(cable_in_the_elbow, 0)


def swaying(draw: int, joint: int, size: float):
    """The diagnosis of an arm one of whose torques reads right on average, and so much too large
    at one end of the joint's range."""
    phase = np.random.default_rng([draw, 6]).uniform(-1, 1, 2)[1]

    def extra(t, q, dq, ddq):
        out = np.zeros((len(t), 2))
        out[:, joint] = size * np.sin(q[:, joint] + phase) * textbook_torque(q, dq, ddq)[:, joint]
        return out

    runs = recordings(400 + draw, extra=extra)
    return diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )


@pytest.mark.long
@pytest.mark.parametrize(("draw", "joint"), [(0, 1), (4, 0)])
def test_a_gain_that_sways_is_not_put_together_from_the_library(draw, joint):
    """Springs, offsets, contacts and worn spots were named, ten times the noise from the truth."""
    found = swaying(draw, joint, 0.1)
    assert (found.verdict, found.findings) == ("unknown", ())
    assert [one.joint for one in found.unexplained] == [joint]
    assert "read differently from angle to angle" in found.remaining[joint].sentence


@pytest.mark.long
def test_findings_that_a_swaying_gain_outdoes_are_doubted():
    """Of 2 % three effects leave little more than the noise: they stay, with what may be wrong."""
    found = swaying(1, 1, 0.02)
    assert len(found.findings) > 1
    assert "alone would leave less than what was found there" in found.remaining[1].sentence


@pytest.mark.long
@pytest.mark.parametrize("draw", range(5))
@pytest.mark.parametrize("law", LAWS, ids=[law.__name__ for law in LAWS])
def test_no_foreign_law_is_called_nothing(law, draw):
    found, joint = found_in(law, draw)
    assert found.verdict != "none"
    assert found.remaining[joint].significant or found.remaining[joint].material is False
