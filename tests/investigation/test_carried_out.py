"""The daemon's side: what a pause, a stop, a fault or a refused motion leaves behind."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest
from made_up import answer, finding, investigation

from pa10d.common.errors import NoRoom, NotNow, Stopped, UserError
from pa10d.daemon.motions import investigations
from pa10d.daemon.robot.stops import Stops
from pa10d.experiments.outcome import Outcome, RecordedRun
from pa10d.investigation import course
from pa10d.investigation.archive import Archive

RESULTS = {"identify": {"models": ["m0"], "notes": ["Rank lost."]}, "add": {"models": ["m1"]}}


class PaperDaemon:
    """on: called with a step's id before it is carried out; what it raises, the step raises."""

    def __init__(self, data, on=lambda step: None, refuses=()):
        self.data, self.on, self.refuses = data, on, refuses
        self.investigations, self.pauses = Archive(data), set()
        self.events = SimpleNamespace(publish=lambda *_: None)
        self.robot = SimpleNamespace(state="inactive", stops=Stops())
        self.carried_out = []
        self.bars = []  # what the pre-check of the next motions raises
        self.notes, self.tuned = [], []  # of each motion

    async def compute_now(self, task, progress, investigation, step):
        assert task == "investigation_step"
        self.on(step)
        await asyncio.sleep(0)
        self.carried_out.append(step)
        kind = step.split("-")[0]
        result = {"result": answer(finding())} if kind == "diagnose" else {}
        return {**RESULTS.get(kind, {}), **result}

    def experiment(self, request):
        daemon = self

        class Experiment:
            moved = False

            async def carry_out(self):
                if daemon.bars:
                    raise daemon.bars.pop()
                if request.kind in daemon.refuses:
                    raise UserError("the pre-check refused the motion: floor")
                self.moved = True
                daemon.on(request.kind)
                await asyncio.sleep(0)
                daemon.carried_out.append((request.kind, tuple(request.tags)))
                runs = [f"r{len(daemon.carried_out)}"]
                told = [RecordedRun(runs[0], runs[0], "success", 9.0)]
                notes, tuned = daemon.notes, daemon.tuned
                return Outcome(request.kind, runs, told, seconds=9.0, notes=notes, tuned=tuned)

        return Experiment()


async def asked_for(daemon, carrier):
    """As a job is: a stop from now on ends it."""
    with daemon.robot.stops.heard_by(daemon.robot.stops.count):
        return await carrier.carry_out()


@pytest.fixture
def carry(tmp_path, monkeypatch):
    """carry(daemon) carries out the one investigation of the folder, in a loop of its own."""
    state = investigation()
    Archive(tmp_path).save(state)

    def carried(daemon):
        monkeypatch.setattr(
            investigations, "experiment_of", lambda _, request, report: daemon.experiment(request)
        )
        carrier = investigations._Carrier(daemon, state.id, lambda *_: None, recover=False)
        carry_out = asked_for(daemon, carrier)
        with ThreadPoolExecutor(1) as pool:
            return pool.submit(asyncio.run, carry_out).result()

    return carried


def test_to_its_end(tmp_path, carry):
    daemon = PaperDaemon(tmp_path)
    found = carry(daemon)
    assert found["status"] == "done"
    assert [s["status"] for s in found["steps"]] == ["done"] * len(found["steps"])
    assert ("point_to_point", ("fresh", "look")) in daemon.carried_out
    assert ("excitation", ("fit", "look")) in daemon.carried_out
    assert found["moved_seconds"] == pytest.approx(6 * 9.0)
    assert found["models"] == ["m0", "m1"]
    assert [s["notes"] for s in found["steps"] if s["notes"]] == [["Rank lost."]]


def test_what_was_set_of_the_servo_is_kept_beside_what_is_said(tmp_path, carry):
    """Nobody has to do anything about it; the story is told without it."""
    daemon = PaperDaemon(tmp_path)
    daemon.notes, daemon.tuned = ["run at half the speed"], ["gains twice as firm were set"]
    step = next(s for s in carry(daemon)["steps"] if s["kind"] == "motion")
    assert step["said"].endswith(" Run at half the speed.")
    assert "gains" not in step["said"]
    assert step["tuned"] == ["Gains twice as firm were set."]


def fails_once(at, error):
    left = [error]

    def on(step):
        if step == at and left:
            raise left.pop()

    return on


def test_a_motion_that_the_disk_has_no_room_for_is_still_to_be_made(tmp_path, carry):
    daemon = PaperDaemon(tmp_path)
    daemon.bars.append(NotNow("the pre-check refused the motion: 13 MB are free"))
    with pytest.raises(NotNow, match="13 MB are free"):
        carry(daemon)
    (left,) = daemon.investigations.all()
    assert left.status == "failed"
    assert {step.status for step in left.steps} == {"waiting"}, "none is left out"
    found = carry(daemon)
    assert [s["status"] for s in found["steps"]] == ["done"] * len(found["steps"])


def test_a_disk_that_keeps_no_state_is_told_as_what_it_is(tmp_path, carry, monkeypatch):
    daemon = PaperDaemon(tmp_path, fails_once("identify", NoRoom("no room")))
    save = daemon.investigations.save

    def full(state):
        if state.status == "failed":
            raise OSError(28, "No space left on device")
        save(state)

    daemon.investigations.save = full
    with pytest.raises(NoRoom, match="no room"):
        carry(daemon)
    daemon.investigations.save = save
    assert carry(daemon)["status"] == "done"


@pytest.mark.parametrize("at", ["first_motion", "excitation", "identify", "diagnose-1", "report"])
def test_after_a_fault_it_goes_on_where_it_was(tmp_path, carry, at):
    daemon = PaperDaemon(tmp_path, fails_once(at, UserError("following error of joint 2")))
    with pytest.raises(UserError, match="following error"):
        carry(daemon)
    (left,) = daemon.investigations.all()
    assert (left.status, left.error) == ("failed", "following error of joint 2")
    before = list(daemon.carried_out)
    assert carry(daemon)["status"] == "done"
    assert daemon.carried_out[: len(before)] == before
    kinds = [s for s in daemon.carried_out if isinstance(s, str)]
    assert len(kinds) == len(set(kinds)), "nothing is computed twice"
    assert len(daemon.carried_out) - len(kinds) == 6, "nor recorded"


def test_a_stop_leaves_it_ready_to_go_on(tmp_path, carry):
    daemon = PaperDaemon(tmp_path, fails_once("compare", asyncio.CancelledError()))
    with pytest.raises(BaseException):  # noqa: B017 - the future's own kind of it
        carry(daemon)
    (left,) = daemon.investigations.all()
    assert left.status == "stopped"
    assert course.next_step(left).id == "compare"
    assert carry(daemon)["status"] == "done"


@pytest.mark.parametrize("at", ["identify", "diagnose-1", "add", "judge", "report"])
def test_a_stop_of_the_arm_ends_it_while_it_computes(tmp_path, carry, at):
    """Also where no motion is left: it is not done as if nobody had pressed anything."""
    left = [at]

    def stop(step):
        if [step] == left:
            left.clear()
            daemon.robot.stops.ask()

    daemon = PaperDaemon(tmp_path, stop)
    with pytest.raises(Stopped, match="somebody stopped the arm"):
        carry(daemon)
    (found,) = daemon.investigations.all()
    assert (found.status, course.next_step(found).id) == ("stopped", at)
    assert carry(daemon)["status"] == "done"


def test_a_stop_of_the_arm_leaves_an_investigation_of_recordings_be(tmp_path, carry):
    (state,) = Archive(tmp_path).all()
    state.moves, state.fit = False, ["r1"]
    state.steps = [step for step in state.steps if step.kind != "motion"]
    Archive(tmp_path).save(state)
    daemon = PaperDaemon(tmp_path, lambda step: daemon.robot.stops.ask())
    assert carry(daemon)["status"] == "done"


def test_a_pause_rests_after_the_step(tmp_path, carry):
    def pause(step):
        if step == "identify":
            daemon.pauses.add(daemon.investigations.all()[0].id)

    daemon = PaperDaemon(tmp_path, pause)
    found = carry(daemon)
    assert found["status"] == "paused"
    assert daemon.carried_out[-1] == "identify"
    assert not daemon.pauses, "the next start goes on"
    daemon.on = lambda step: None
    assert carry(daemon)["status"] == "done"


def test_a_motion_that_this_arm_cannot_make_is_left_out(tmp_path, carry):
    found = carry(PaperDaemon(tmp_path, refuses=("point_to_point",)))
    assert found["status"] == "done"
    assert [s["said"] for s in found["steps"] if s["status"] == "left_out"] == [
        "the pre-check refused the motion: floor"
    ] * 2


def test_an_arm_whose_joints_cannot_be_measured_is_not_moved_further(tmp_path, carry):
    """Its gains follow the URDF until then, and the others are large motions."""
    daemon = PaperDaemon(tmp_path, refuses=("first_motion",))
    with pytest.raises(UserError, match="floor"):
        carry(daemon)
    assert not daemon.carried_out
    (left,) = daemon.investigations.all()
    assert {step.status for step in left.steps} == {"waiting"}


def test_an_arm_in_a_fault_is_not_taken_for_a_motion_it_cannot_make(tmp_path, carry):
    daemon = PaperDaemon(tmp_path, refuses=("excitation",))
    daemon.robot.state = "fault"
    with pytest.raises(UserError):
        carry(daemon)
    assert daemon.investigations.all()[0].status == "failed"
