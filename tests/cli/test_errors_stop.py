"""What would make a fit wrong stops the import that checks, and every fit after one that did not;
what is mistyped is said before anything is started."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from test_run_commands import URDF

import pa10d.services.runs as services_runs
from pa10d.checks import CheckFinding
from pa10d.cli import main
from pa10d.client import Client
from pa10d.common.errors import UserError
from pa10d.compare import compare
from pa10d.diagnose.asked.adding import refuse_slips
from pa10d.diagnose.search.suspects import lacking, suspicion
from pa10d.identify import identify
from pa10d.model import Term
from pa10d.services.robots import load_robot
from pa10d.store import Channels, RunStore, Samples
from pa10d.store.models import ModelStore

T = np.arange(4000) / 200
Q = np.stack([0.8 * np.sin(T), np.cos(1.7 * T)], axis=1)


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A two-joint arm; a sound recording of it, and the same one in degrees."""
    monkeypatch.setenv("PA10D_DATA", str(tmp_path / "data"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.urdf").write_text(URDF)
    (tmp_path / "two.yaml").write_text("urdf: two.urdf\n")
    rng = np.random.default_rng(0)
    ddq = -np.stack([0.8 * np.sin(T), 1.7**2 * np.cos(1.7 * T)], axis=1)
    tau = 0.3 * ddq + 2 * np.cos(Q) * [0, 1] + rng.normal(0, 0.01, (4000, 2))
    for name, q in (("sound", Q), ("degrees", np.degrees(Q))):
        table = np.column_stack([T, q, tau, np.gradient(Q, T, axis=0)])
        header = "time,q1,q2,tau1,tau2,dq1,dq2"
        np.savetxt(f"{name}.csv", table, delimiter=",", header=header, comments="")
    return tmp_path


@pytest.fixture
def fitted(place, capsys):
    """With a model m0 of the sound recording."""
    assert _import("sound") == 0
    assert main(["identify", "sound", "--profile", "two.yaml", "--name", "m0"]) == 0
    capsys.readouterr()


def _import(name, *more):
    file = f"{name}.csv"
    return main(["run", "import", file, "--profile", "two.yaml", "--name", name, *more])


def test_a_checked_import_stores_nothing_that_a_fit_must_not_use(place, capsys):
    assert _import("degrees", "--check", "--json") == 1
    said = capsys.readouterr()
    document = json.loads(said.out)
    assert "these look like degrees" in document["error"]
    assert "--force" in document["error"]
    assert [f["code"] for f in document["findings"]] == ["degrees"]
    assert said.err.count("\n") == 1
    assert RunStore().all() == []
    assert _import("degrees", "--check", "--force") == 0
    assert [info.name for info in RunStore().all()] == ["degrees"]


def test_what_else_has_to_be_mended_is_said_of_a_refused_recording(place, capsys, monkeypatch):
    found = [
        CheckFinding("error", "dull", "joint 1: too dull", "record it finer", 1),
        CheckFinding("warning", "turned", "joint 2: tau counts the other way", "--map …", 2),
        CheckFinding("warning", "limits", "joint 2: tau is beyond its limit", joint=2),
    ]
    monkeypatch.setattr(services_runs, "findings_of", lambda *_, **__: found)
    assert _import("sound", "--check", "--json") == 1
    said = capsys.readouterr()
    assert "warning: joint 2: tau counts the other way → --map …" in said.err
    assert "warning: joint 2: tau is beyond its limit\n" in said.err
    document = json.loads(said.out)
    assert "joint 2" not in document["error"]
    assert [f["code"] for f in document["findings"]] == ["dull", "turned", "limits"]


def test_no_fit_takes_a_run_with_an_error_unless_forced(place, capsys):
    assert _import("sound", "--check") == 0
    assert _import("degrees") == 0
    assert "error: q reaches 57.3" in capsys.readouterr().err
    assert main(["run", "check", "degrees", "--profile", "two.yaml"]) == 1
    assert main(["run", "check", "sound", "--profile", "two.yaml"]) == 0
    identify = ["identify", "degrees", "--profile", "two.yaml", "--name", "wrong"]
    assert main(identify) == 1
    assert "run 'degrees': q reaches 57.3" in capsys.readouterr().err
    assert ModelStore().all() == []
    assert main(["identify", "sound", "--profile", "two.yaml", "--name", "m0"]) == 0
    for command in (
        ["compare", "m0", "degrees"],
        ["diagnose", "m0", "--fit", "sound", "--validate", "degrees"],
        ["add", "m0", "stribeck", "--joint", "1", "--fit", "degrees", "--name", "m1"],
        ["improve", "m0", "--fit", "degrees", "--name", "m1"],
    ):
        assert main(command) == 1, command
        assert "these look like degrees" in capsys.readouterr().err
    assert main(["compare", "m0", "degrees", "--force"]) == 0
    assert main([*identify, "--force"]) == 0


def test_a_run_that_was_recorded_here_is_looked_at_when_it_is_asked_for(place, capsys):
    writer = RunStore().start("live", Channels(("a", "b")))
    writer.append(Samples((T * 1e9).astype(np.int64), np.degrees(Q), Q))
    writer.close()
    assert main(["identify", "live", "--profile", "two.yaml", "--name", "m"]) == 1
    assert "run 'live': q reaches 57.3" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["experiment", "trackin"], "trackin"),
        (["experiment", "tracking", "--set", "perod=4"], "perod"),
        (["experiment", "single_joint", "--set", "joints=[9]"], "joints: found 9"),
        (["experiment", "tracking", "--model", "nothing"], "model 'nothing'"),
        (["experiment", "tracking", "--profile", "pa10-sin"], "pa10-sin"),
        (["experiment", "tracking", "--profile", "typo.yaml"], "typo.yaml:2: joint"),
        (["improve", "m0", "--experiments", "--fit", "a", "--name", "b"], "model 'm0'"),
        (["demo", "--hide", "strbeck"], "strbeck"),
        (["serve", "--port", "0", "--hide", "strbeck"], "strbeck"),
    ],
)
def test_a_typo_is_said_before_anything_is_started(place, capsys, monkeypatch, command, said):
    def started(*_, **__):
        raise AssertionError("a process was started")

    (place / "typo.yaml").write_text("urdf: two.urdf\njoint: [a]\n")
    monkeypatch.setattr("subprocess.Popen", started)
    assert main(command) == 1
    assert said in capsys.readouterr().err


@pytest.mark.by_default("more0", "more2")
@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--effect", "strbeck"], "strbeck"),
        (["--effect", "stribeck", "--joint", "3"], "joint 3: expected 1 to 2"),
        (["--validate", "nothing"], "run 'nothing'"),
    ],
)
def test_a_typo_is_said_before_anything_is_computed(fitted, capsys, more, said):
    assert main(["diagnose", "m0", "--fit", "sound", *more]) == 1
    err = capsys.readouterr().err
    assert said in err
    assert "%" not in err  # no progress was made


@pytest.mark.by_default("0", "nan")
@pytest.mark.parametrize("cutoff", ["0", "nan", "1e-300", "-1", "inf"])
def test_a_cutoff_that_no_filter_has_is_one_line(fitted, capsys, cutoff):
    """``1e-300`` overflowed, ``0`` divided by itself, and ``nan`` became no integer."""
    for command in (
        ["compare", "m0", "sound"],
        ["identify", "sound", "--profile", "two.yaml", "--name", "m1"],
    ):
        assert main([*command, f"--cutoff={cutoff}"]) == 1
        said = [line for line in capsys.readouterr().err.splitlines() if "%" not in line]
        assert said == [
            f"cut-off {float(cutoff):g} Hz: expected between 2e-05 Hz and half the sampling rate "
            "(100 Hz)"
        ]
    run, robot = RunStore().recording(RunStore().find("sound")), load_robot("two.yaml")[1]
    model = ModelStore().load(ModelStore().find("m0"))
    with pytest.raises(UserError, match="half the sampling rate"):
        compare(model, [run], cutoff=float(cutoff))
    with pytest.raises(UserError, match="half the sampling rate"):
        identify([run], robot, name="m1", cutoff=float(cutoff))


@pytest.mark.by_default("more0")
@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["coulomb"], "coulomb J1, coulomb J2"),
        (["coulomb", "--joint", "1"], "coulomb J1"),
        (["viscous", "--joint", "1", "2"], "viscous J1, viscous J2"),
    ],
)
def test_an_effect_is_not_added_where_the_model_has_it(fitted, capsys, more, said):
    """Two of the same columns share one torque in any way they like: 1.22 and -0.496 N·m."""
    assert main(["add", "m0", *more, "--fit", "sound", "--name", "m1"]) == 1
    err = capsys.readouterr().err
    assert f"{said}: model 'm0' has it already; expected an effect that it lacks there" in err
    assert "%" not in err
    assert [info.name for info in ModelStore().all()] == ["m0"]


def test_what_a_joint_may_have_twice_is_no_slip_and_one_without_a_joint_goes_where_it_lacks(fitted):
    model = ModelStore().load(ModelStore().find("m0"))
    ripple = Term.of("torque_ripple", (0,), {"order": 4.0})
    more = replace(model, terms=(*model.terms, ripple, Term.of("stribeck", (0,))))
    refuse_slips(more, "torque_ripple", [0], ())
    refuse_slips(more, "payload", [], ())
    assert [joints for _, joints in lacking(more, "stribeck", [])] == [(1,)]
    with pytest.raises(UserError, match=r"^stribeck J1: model 'm0' has it already"):
        refuse_slips(more, "stribeck", [0], ())


def test_the_joints_of_a_robot_of_one_are_said_as_such():
    with pytest.raises(UserError, match="joint 7: expected 1, the only one"):
        suspicion(("stribeck", [6]), 1)


def test_an_interrupted_wait_cancels_its_job_and_names_it():
    class Interrupted(Client):
        def __init__(self):
            self.cancelled = []

        def job(self, number):
            raise KeyboardInterrupt

        def cancel(self, number):
            self.cancelled.append(number)

    client = Interrupted()
    with pytest.raises(KeyboardInterrupt, match="job 7 was cancelled"):
        client.wait({"id": "7"})
    assert client.cancelled == ["7"]


@pytest.mark.long
def test_what_a_check_doubted_is_heard_again_by_whoever_fits(fitted, place, capsys):
    """A joint that counts the other way in one run was a spring that had come or gone."""
    (kept,) = (place / "data" / "runs").glob("*/run.json")
    run = json.loads(kept.read_text())
    doubt = {"severity": "warning", "code": "turned", "sentence": "joint 2: q counts the other way"}
    run["findings"] = [{**doubt, "advice": "--map 'q2[-1]=q2'", "joint": 2}]
    kept.write_text(json.dumps(run))
    again = "run sound: joint 2: q counts the other way, as its check said → --map 'q2[-1]=q2'"
    for command in (
        ["identify", "sound", "--profile", "two.yaml", "--name", "m1"],
        ["compare", "m0", "sound"],
        ["diagnose", "m0", "--fit", "sound"],
    ):
        assert main(command) == 0
        said = capsys.readouterr()
        assert again in said.out + said.err, command


@pytest.mark.long
def test_what_add_tells_of_the_error_has_a_unit_for_every_joint(fitted, capsys):
    added = ["add", "m0", "torque_offset", "--joint", "1", "--fit", "sound", "--name", "m1"]
    assert main(added) == 0
    said = capsys.readouterr().out
    assert re.search(r"data held out of the fit, joint by joint: \S+ N·m, \S+ N·m RMS\n", said)
