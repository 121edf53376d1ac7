"""One parameter of one model: one standard error, whichever command, file or page says it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from same_error import assert_one_error
from two_links import CUTOFF, RATE, URDF, recordings, state_of, textbook

from pa10d.cli import main
from pa10d.diagnose.evidence import stated as one_error
from pa10d.diagnose.evidence.errors_of import honest_covariance, term_covariance
from pa10d.diagnose.evidence.stated import stated
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search.steps import Search
from pa10d.effects import effect
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import delayed

PROFILE = "name: two\nurdf: two.urdf\nsimulation: {}\n"
STIFF, LEVEL, FINE = 60.0, 0.9, 20  # N·m/rad, N·m, steps per sample


def bump(t, q, dq, ddq):
    """Stribeck friction on the second joint."""
    v = dq[:, 1]
    rise = 1.2 * np.exp(-((np.abs(v) / 0.15) ** 1.3))
    return np.column_stack([np.zeros(len(t)), rise * np.tanh(v / 0.01)])


def bristles(t, q, dq, ddq):
    """Part of the second joint's dry friction begins as a spring (Dahl)."""
    z, out = 0.0, np.zeros((len(t), 2))
    fine = np.interp(np.arange(len(t) * FINE) / FINE, np.arange(len(t)), dq[:, 1])
    for i, v in enumerate(fine):
        z += (v - abs(v) * STIFF * z / LEVEL) / (RATE * FINE)
        if i % FINE == 0:
            out[i // FINE, 1] = STIFF * z
    out[:, 1] -= LEVEL * np.tanh(dq[:, 1] / 0.01)
    return out


def late(runs):
    """The second joint's torque comes 6 ms late."""
    return {
        name: Recording(
            name, r.t, r.q, np.column_stack([r.tau[:, 0], delayed(r.tau[:, 1:], 0.006, RATE)])
        )
        for name, r in runs.items()
    }


CASES = {
    "stribeck": lambda: recordings(5, bump),
    "presliding_hysteresis": lambda: recordings(5, bristles),
    "torque_delay": lambda: late(recordings(5)),
}


@pytest.mark.long  # test_one_judgement asks the same of the model that it makes
@pytest.mark.parametrize("kind", CASES)
def test_whoever_tells_of_a_parameter_tells_one_error(kind, tmp_path, capsys):
    (tmp_path / "two.urdf").write_text(URDF)
    (tmp_path / "two.yaml").write_text(PROFILE)
    data, profile = str(tmp_path / "data"), str(tmp_path / "two.yaml")

    def ask(*words: str):
        capsys.readouterr()
        assert main(["--data", data, "--json", *words]) == 0
        return json.loads(capsys.readouterr().out)

    for name, run in CASES[kind]().items():
        table = np.column_stack([run.t, run.q, run.tau])
        file, head = tmp_path / f"{name}.csv", "time,q1,q2,tau1,tau2"
        np.savetxt(file, table, delimiter=",", header=head, comments="", fmt="%.9g")
        ask("run", "import", str(file), "--profile", profile)
    fit, judge_by = ["fit_a", "fit_b"], ["valid_a", "valid_b"]
    ask("identify", *fit, "--profile", profile, "--name", "m0", "--cutoff", str(CUTOFF))
    page = tmp_path / "d.html"
    found = ask(
        "improve", "m0", "--fit", *fit, "--validate", *judge_by, "--name", "m1",
        "--report", str(page),
    )  # fmt: skip
    (finding,) = found["findings"]
    assert finding["effect"] == kind
    assert_one_error(ask, data, tmp_path, found, page)


def test_a_stored_error_knows_what_shapes_and_reversals_leave_open():
    """Fs of a Stribeck bump whose width was fitted, too, is not known ten times better than the
    finding says; nor is the dry friction beside it as sure as with a given width."""
    runs = recordings(5, bump)
    state = state_of(runs, textbook(runs))
    search = Search(state, [(effect("stribeck"), (1,))], len(state.terms))
    state.push(search.best(effect("stribeck"), (1,)).term)
    search.settle()
    state = search.state
    index = len(state.terms) - 1
    place = state.place(index)
    alone, shapes = term_covariance(state, index)
    whole = stated(state, [index])
    fixed = np.sqrt(np.diag(honest_covariance(state)))
    errors = np.sqrt(np.diag(whole.covariance))
    np.testing.assert_allclose(errors[place], np.sqrt(np.diag(alone)), rtol=1e-3)
    assert whole.shape_errors[index] == pytest.approx(shapes, rel=1e-3)
    assert errors[place] > 3.0 * fixed[place]
    assert np.all(errors > 0.999 * fixed)
    values = np.linalg.eigvalsh(whole.covariance)
    assert values[0] > -1e-9 * values[-1]


def test_without_free_shapes_it_is_the_fit_s_own(monkeypatch):
    """But for how late torque is, which is as unsure as it was found."""
    runs = recordings(5)
    state = state_of(runs, textbook(runs))
    known = {j: basis[:, :0] for j, basis in state.fit.basis.items()}
    monkeypatch.setattr(one_error, "channel_slopes", lambda _: known)
    np.testing.assert_allclose(stated(state, []).covariance, honest_covariance(state), rtol=1e-9)


@pytest.mark.long
def test_a_version_of_a_version_keeps_its_doubt():
    """What was found before is fitted again beside what is found now, its shape with it."""
    runs = recordings(5, bump)
    fit, judge_by = [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    first = diagnose(textbook(runs), fit, judge_by).model
    again = diagnose(first, fit, judge_by)
    assert not again.findings
    before, after = (
        first.term_values(-1 % len(first.terms)),
        again.versions[0].term_values(len(first.terms) - 1),
    )
    assert after["Fs"].std_error == pytest.approx(before["Fs"].std_error, rel=0.1)
