"""Experiments and stops as a client asks for them, on an arm of few joints: the way is the same."""

from __future__ import annotations

import time

import pytest
from small_arm import small_arm

from pa10d.client import ApiError, Client, JobFailed, local_daemon

BUSY = 120.0  # s for what takes long on a busy machine


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    folder = tmp_path_factory.mktemp("moving")
    with local_daemon(folder / "data", str(small_arm(folder)), clock="simulated") as client:
        yield client


def test_experiment_run_export_and_delete(arm, tmp_path):
    told = []
    plan = {"kind": "tracking", "parameters": {"cycles": 1}, "about": "kept for people"}
    found = arm.experiment(plan=plan, name="one", tags=["cold"], progress=lambda *a: told.append(a))
    (run,) = found["runs"]
    assert told[-1][0] == 1.0
    said = [c["sentence"] for c in found["checks"] if c["level"] != "ok"]
    assert all("the joints have not been measured" in sentence for sentence in said)
    assert len(found["analysis"]["one"]["tracking_rms"]) == 3
    assert found["recommendation"]
    assert arm.robot()["state"] == "inactive"  # left as it was found
    stored = arm.run("one")
    assert (stored["id"], stored["kind"], stored["tags"]) == (run, "tracking", ["cold"])
    assert [r["id"] for r in arm.runs(tag="cold", kind="tracking")] == [run]
    for form in ("csv", "mcap", "parquet", "mat"):
        assert arm.export("one", form, tmp_path / f"one.{form}").stat().st_size > 10_000
    with pytest.raises(ApiError, match="there is a run 'one' already") as taken:
        arm.experiment("tracking", {"cycles": 1}, name="one")
    assert taken.value.status == 409
    arm.delete_run(run)
    with pytest.raises(ApiError) as gone:
        arm.run(run)
    assert gone.value.status == 404


def test_the_precheck_looks_at_plan_and_arm(arm):
    asked = {"kind": "tracking", "parameters": {"cycles": 1}}
    found = arm.check_experiment(asked)
    assert found["go"]
    subjects = {c["subject"] for c in found["checks"]}
    assert subjects >= {"state", "bus", "drives", "position", "torque", "collision"}
    arm.disconnect()
    found = arm.check_experiment(asked)
    arm.connect()
    assert not found["go"]
    (wrong,) = [c["sentence"] for c in found["checks"] if c["level"] == "error"]
    assert "the arm is offline: disconnected on request" in wrong


def test_cancel_stops_the_arm(arm):
    job = arm.start("experiments", {"kind": "warm_up", "parameters": {}})
    arm.wait_for_robot("running", timeout=BUSY)
    arm.cancel(job["id"])
    assert arm.job(job["id"])["status"] == "cancelled"
    arm.wait_for_robot("inactive", timeout=BUSY)
    arm.cancel(job["id"])  # twice is no error


def test_only_one_client_commands_but_everybody_stops(arm):
    job = arm.start("experiments", {"kind": "warm_up", "parameters": {}})
    arm.wait_for_robot("running", timeout=BUSY)
    with Client(arm.url, name="another") as other:
        with pytest.raises(ApiError) as held:
            other.disable()
        assert held.value.problem["holder"].startswith("client-")
        assert held.value.status == 409
        assert other.stop()["state"] in ("holding", "inactive")
    with pytest.raises(JobFailed):
        arm.wait(job)
    arm.wait_for_robot("inactive", timeout=BUSY)


def test_a_stop_is_heard_by_what_has_not_moved_yet(arm):
    runs = len(arm.runs())
    job = arm.start("experiments", {"kind": "excitation", "parameters": {"cycles": 1}})
    assert arm.stop()["state"] == "inactive"
    with pytest.raises(JobFailed, match="stopped"):
        arm.wait(job)
    assert arm.job(job["id"])["status"] == "cancelled"
    assert arm.robot()["state"] == "inactive"
    assert len(arm.runs()) == runs


def test_a_job_does_not_power_an_arm_that_was_disabled_meanwhile(arm):
    job = arm.start("experiments", {"kind": "excitation", "parameters": {"cycles": 1}})
    assert arm.disable()["state"] == "inactive"
    with pytest.raises(JobFailed, match="stopped"):
        arm.wait(job)
    assert arm.robot()["state"] == "inactive"


def test_a_stop_between_two_motions_ends_the_series(arm):
    brief = {"kind": "tracking", "parameters": {"cycles": 1}}
    job = arm.start("experiments/series", {"experiments": [brief] * 3})
    until = time.monotonic() + BUSY
    while not arm.job(job["id"])["message"].startswith(("2 of", "3 of")):
        assert time.monotonic() < until
        time.sleep(0.01)
    arm.stop()
    with pytest.raises(JobFailed, match="stopped"):
        arm.wait(job)
    assert arm.robot()["state"] == "inactive"
    assert len(arm.job(job["id"])["result"]["runs"]) < 3
    assert arm.enable()["state"] == "holding", "whoever asks after the stop is obeyed"
    arm.disable()


@pytest.mark.long
def test_twenty_listeners_do_not_disturb_the_loop(arm):
    """The loop does its cycles whoever listens (its own timing is measured by bench.py)."""
    streams = [arm.telemetry(history=2.0) for _ in range(20)]
    try:
        for stream in streams:
            next(stream)
        before = arm._http.get("/metrics").text
        job = arm.start("experiments", {"kind": "tracking", "parameters": {"cycles": 1}})
        for _ in range(10):
            for stream in streams:
                next(stream)
        assert "pa10d_telemetry_listeners 20" in before
        assert arm.wait(job)["result"]["runs"]
    finally:
        for stream in streams:
            stream.close()
    until = time.monotonic() + 60
    while "pa10d_telemetry_listeners 0" not in arm._http.get("/metrics").text:
        assert time.monotonic() < until
        time.sleep(0.1)
