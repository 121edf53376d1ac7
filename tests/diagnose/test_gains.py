"""Torque constants that are each off by their own few percent: joints carry the same bodies."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from two_links import recordings, textbook

from pa10d.diagnose.outcome.next_experiment import settle_doubt
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search.candidates import Candidate
from pa10d.effects import effect

TRUE = np.array([0.96, 1.04])


@pytest.mark.long
def test_gains_that_differ_are_named_and_leave_nothing_to_explain():
    """No base parameters fit both joints; which of the two is right no motion can tell."""
    runs = {name: replace(run, tau=run.tau * TRUE) for name, run in recordings(5).items()}
    found = diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )
    assert [f.term.effect_id for f in found.findings] == ["torque_gain"]
    assert found.unexplained == ()
    assert not any(line.significant for line in found.remaining)
    (finding,) = found.findings
    (joint,) = finding.term.joints
    gain = finding.parameters["gain"]
    ratio = TRUE[joint] / TRUE[1 - joint] - 1.0
    assert abs(gain.value - ratio) < 3.0 * gain.std_error
    rivals = [(c.effect, c.joints) for c in finding.confounded_with]
    assert rivals == [("torque_gain", (1 - joint,))]
    # measured against a joint that may be off itself: whoever reads the figure has to know
    assert f"against that of joint {2 - joint}" in finding.sentence


def test_no_motion_is_promised_to_tell_which_gain_is_off():
    """Bodies a little heavier make up for the one as well as for the other."""
    model, kind = textbook(recordings(5)), effect("torque_gain")
    one, other = (
        Candidate(kind, (j,), {}, SimpleNamespace(theta=np.array([size])))  # type: ignore[arg-type]
        for j, size in ((0, 0.08), (1, -0.08))
    )
    assert settle_doubt(model, one, [other]) is None
