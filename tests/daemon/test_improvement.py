"""Improving with the arm at hand: look, move, look again; and when it must not go on."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest
from loops import run_apart

from pa10d.common.errors import Stopped, UserError
from pa10d.daemon.motions import improvement
from pa10d.daemon.robot.stops import Stops
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.experiments.outcome import Outcome
from pa10d.services import diagnoses

SWEEP = {"kind": "velocity_sweep", "parameters": {"joints": [5]}}
CHIRP = {"kind": "chirp", "parameters": {"joints": [5]}}
REQUEST = improvement.ImprovementRequest("m", ["a"], ["v"], "new")


class PaperDaemon:
    """``doubts``: what each look asks for, one after the other."""

    def __init__(self, *doubts):
        self.doubts, self.looks = list(doubts), []
        self.robot = SimpleNamespace(stops=Stops())

    async def compute_now(self, task, progress, **arguments):
        assert task == "improve"
        self.looks.append({**arguments, "fit": list(arguments["fit"]),
                           "validate": list(arguments["validate"])})  # fmt: skip
        asked = self.doubts.pop(0) if self.doubts else None
        return {"doubt": asked if arguments["tried"] is not None else None, "name": "new"}


def improved(monkeypatch, daemon, request=REQUEST, refuses=(), stops=(), before=()):
    class Experiment:
        def __init__(self, daemon, request, report):
            self.request, self.moved = request, False

        async def carry_out(self):
            kind = self.request.kind
            if kind in refuses:
                raise UserError("the pre-check refused the motion")
            if kind in before:
                raise Stopped("stopped: it does not move any more")
            self.moved = True
            if kind in stops:
                raise UserError("run x: stopped")
            return Outcome(kind, [f"run of {kind}"])

    monkeypatch.setattr(improvement, "Experiment", Experiment)
    report = SimpleNamespace(job=SimpleNamespace(result=None))
    whole = type("Report", (), {"job": report.job, "__call__": lambda *_: None})()
    return run_apart(improvement._improve(daemon, request, whole))


def test_it_looks_moves_and_looks_again(monkeypatch):
    daemon = PaperDaemon(SWEEP, CHIRP)
    made = improved(monkeypatch, daemon)
    assert [e["plan"] for e in made["experiments"]] == [SWEEP, CHIRP]
    assert [look["tried"] for look in daemon.looks] == [[], [SWEEP], [SWEEP, CHIRP]]
    assert daemon.looks[-1]["fit"] == ["a", "run of velocity_sweep", "run of chirp"]
    assert daemon.looks[-1]["validate"] == ["v", "run of velocity_sweep", "run of chirp"]


def test_without_runs_to_judge_by_there_are_none_later(monkeypatch):
    daemon = PaperDaemon(SWEEP)
    improved(monkeypatch, daemon, replace(REQUEST, validate=[]))
    assert daemon.looks[-1]["validate"] == []


def test_a_doubt_that_never_ends_does_not_move_the_arm_for_ever(monkeypatch):
    plans = [{**SWEEP, "parameters": {"seed": k}} for k in range(20)]
    daemon = PaperDaemon(*plans)
    made = improved(monkeypatch, daemon)
    assert len(made["experiments"]) == improvement.MOST
    assert daemon.looks[-1]["tried"] is None, "the last look takes doubts as they are"


def test_an_experiment_that_this_arm_cannot_run_is_noted(monkeypatch):
    made = improved(monkeypatch, PaperDaemon(SWEEP, CHIRP), refuses=("velocity_sweep",))
    assert "pre-check" in made["experiments"][0]["error"]
    assert made["experiments"][1]["runs"] == ["run of chirp"]


def test_whoever_stops_the_arm_stops_the_improvement(monkeypatch):
    daemon = PaperDaemon(SWEEP, CHIRP)
    with pytest.raises(UserError, match="stopped"):
        improved(monkeypatch, daemon, stops=("velocity_sweep",))
    assert len(daemon.looks) == 1


def test_a_stop_before_the_first_motion_stops_it_too(monkeypatch):
    daemon = PaperDaemon(SWEEP, CHIRP)
    with pytest.raises(Stopped):
        improved(monkeypatch, daemon, before=("velocity_sweep",))
    assert len(daemon.looks) == 1


def test_a_stop_of_the_arm_ends_it_while_it_looks(monkeypatch):
    class Stopping(PaperDaemon):
        async def compute_now(self, task, progress, **arguments):
            self.robot.stops.ask()
            return await super().compute_now(task, progress, **arguments)

    async def asked_for(daemon, request, report):
        with daemon.robot.stops.heard_by(daemon.robot.stops.count):
            return await look(daemon, request, report)

    look = improvement._improve
    monkeypatch.setattr(improvement, "_improve", asked_for)
    with pytest.raises(Stopped, match="somebody stopped the arm"):
        improved(monkeypatch, Stopping())


def test_nothing_is_stored_while_an_experiment_is_asked_for(monkeypatch, tmp_path):
    sweep = NextExperiment.read(SWEEP)
    doubtful = SimpleNamespace(findings=[SimpleNamespace(next_experiment=sweep)])
    stored = []
    monkeypatch.setattr(diagnoses, "diagnose_runs", lambda *_, **__: doubtful)
    monkeypatch.setattr(diagnoses, "store_versions", lambda *_, **__: stored.append(1) or ())
    models = SimpleNamespace(refuse_taken=lambda _: None, find=lambda _: None, load=lambda _: None)
    library = SimpleNamespace(models=models)
    asked = {"name": "new", "fit": ["a"]}
    assert diagnoses.improve_model(library, "m", tried=[], **asked).doubt == sweep
    assert not stored
    assert diagnoses.improve_model(library, "m", tried=[sweep], **asked).doubt is None
    assert diagnoses.improve_model(library, "m", **asked).doubt is None
    assert len(stored) == 2
