"""The resources as a client meets them, with a simulated arm behind them."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest

from pa10d.client import ApiError, Client, JobFailed

BUSY = 120.0  # s for what takes long on a busy machine


def test_health_and_metrics(http):
    health = http.get("/healthz").json()
    assert (health["status"], health["robot"]) == ("ok", "inactive")
    text = http.get("/metrics").text
    values = dict(line.rsplit(" ", 1) for line in text.splitlines())
    assert values['pa10d_arm_state{state="inactive"}'] == "1"
    assert float(values["pa10d_loop_cycles_total"]) > 0
    assert sum("pa10d_joint_torque" in k for k in values) == 7


def test_robot_by_hand(arm):
    robot = arm.robot()
    assert [a["joint"] for a in robot["axes"]] == [1, 2, 3, 4, 5, 6, 7]
    assert robot["axes"][0]["drive_state"] == "switch on disabled"
    with pytest.raises(ApiError) as refused:
        arm._ask("POST", "/api/v1/robot/disconnect") and arm.enable()
    assert refused.value.problem["state"] == "offline"
    assert refused.value.problem["needed"] == ["inactive"]
    assert refused.value.problem["remedy"]
    arm._ask("POST", "/api/v1/robot/connect")
    assert arm.enable()["state"] == "holding"
    assert arm.enable()["state"] == "holding"  # repeating oneself is no error
    assert arm.robot()["axes"][0]["drive_state"] == "operation enabled"
    assert arm.stop()["state"] == "holding"
    assert arm.disable()["state"] == "inactive"


def test_experiment_run_export_and_delete(arm, tmp_path):
    told = []
    plan = {"kind": "tracking", "parameters": {"cycles": 1}, "about": "kept for people"}
    found = arm.experiment(plan=plan, name="one", tags=["cold"], progress=lambda *a: told.append(a))
    (run,) = found["runs"]
    assert told[-1][0] == 1.0
    said = [c["sentence"] for c in found["checks"] if c["level"] != "ok"]
    assert all("the joints have not been measured" in sentence for sentence in said)
    assert len(found["analysis"]["one"]["tracking_rms"]) == 7
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


def test_a_motion_into_the_floor_is_refused(arm):
    low = {"joints": [1], "pose": [0.0, 1.5, 0.0, 0.9, 0.0, 0.0, 0.0], "cycles": 1}
    with pytest.raises(JobFailed, match="floor"):
        arm.experiment("tracking", low)
    assert arm.robot()["state"] == "inactive"


def test_wrong_parameters_are_one_line(arm):
    with pytest.raises(ApiError, match="tracking: period"):
        arm.experiment("tracking", {"period": -1})
    with pytest.raises(ApiError, match="no kind 'dance'"):
        arm.experiment("dance", {})


def test_kinds_have_schemas(arm):
    kinds = {k["kind"]: k for k in arm.experiment_kinds()}
    assert set(kinds) == {
        "boundary_velocity", "excitation", "tracking", "point_to_point", "velocity_sweep",
        "load_sweep", "reversals", "warm_up", "chirp", "single_joint", "first_motion",
        "known_weight", "step",
    }  # fmt: skip
    assert kinds["tracking"]["parameters"]["properties"]["period"]["default"] == 4.0


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


def test_lease_is_taken_and_given_back(arm):
    with Client(arm.url, name="another") as other:
        arm._ask("DELETE", "/api/v1/robot/lease")
        taken = other._ask("PUT", "/api/v1/robot/lease", json={"seconds": 100})
        assert taken["holder"] == "another"
        assert 90 < taken["expires_in"] <= 100
        with pytest.raises(ApiError, match="another commands the arm"):
            arm.enable()
        with pytest.raises(ApiError):
            arm._ask("DELETE", "/api/v1/robot/lease")
        assert other._ask("DELETE", "/api/v1/robot/lease")["holder"] is None
    assert arm.enable()["state"] == "holding"
    arm.disable()


def test_upload_and_paging(arm, csv_file):
    ids = [arm.upload(csv_file, name=f"swing{k}")["id"] for k in range(3)]
    first = arm._ask("GET", "/api/v1/runs", params={"name": "swing", "limit": 2})
    assert (first["total"], len(first["items"])) == (3, 2)
    query = {"name": "swing", "limit": 2, "cursor": first["next"]}
    rest = arm._ask("GET", "/api/v1/runs", params=query)
    assert [r["id"] for r in first["items"] + rest["items"]] == ids[::-1]
    assert rest["next"] is None
    changed = arm._ask("PATCH", f"/api/v1/runs/{ids[0]}", json={"tags": ["old"], "name": "renamed"})
    assert (changed["name"], changed["tags"]) == ("renamed", ["old"])
    with pytest.raises(ApiError) as taken:
        arm._ask("PATCH", f"/api/v1/runs/{ids[1]}", json={"name": "renamed"})
    assert taken.value.status == 409
    for run in ids:
        arm.delete_run(run)


def test_a_broken_upload_says_line_and_column(arm, tmp_path):
    bad = tmp_path / "bad.csv"
    bad.write_text("time,q1,tau1\n0,1,2\n0.1,x,3\n")
    with pytest.raises(ApiError) as refused:
        arm.upload(bad)
    assert refused.value.status == 400
    assert "bad.csv" in refused.value.problem["detail"]


def test_unknown_things_are_not_found(arm):
    for path in ("runs/nothing", "models/nothing", "jobs/nothing", "diagnoses/x", "comparisons/x"):
        with pytest.raises(ApiError) as missing:
            arm._ask("GET", f"/api/v1/{path}")
        assert missing.value.status == 404
    with pytest.raises(ApiError) as missing:
        arm.identify(["nothing"], "m")
    assert missing.value.status == 404


def test_effects_are_explained(arm):
    items = {e["id"]: e for e in arm._ask("GET", "/api/v1/effects")["items"]}
    assert len(items) == 24
    assert items["stribeck"]["coefficients"] == {"Fs": "N·m"}


def test_telemetry_with_history(arm):
    columns, start, rows = next(arm.telemetry(history=5.0))
    assert columns[:2] == ["time", "state"]
    assert rows.shape[1] == len(columns)
    assert rows[0, 0] == 0.0
    assert np.all(np.diff(rows[:, 0]) > 0)
    assert len(rows) > 25  # the past, at once
    live = arm.telemetry(history=5.0)
    next(live)
    seen = []
    for command in (arm.enable, arm.disable, arm.enable):  # simulated time passes
        command()
        seen.append(next(live)[1])
    arm.disable()
    assert start < seen[0] < seen[1] < seen[2]


def test_events_tell_what_happened_before(arm):
    arm.enable()
    arm.disable()
    states = []
    for event in arm.events(since=0):
        if event["kind"] == "robot":
            states.append(event["data"]["state"])
            if states[-3:] == ["holding", "disabling", "inactive"]:
                break
    assert "inactive" in states


def test_openapi_names_every_error(http):
    document = http.get("/openapi.json").json()
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            for status, answer in operation["responses"].items():
                if int(status) >= 400:
                    content = answer["content"]
                    assert list(content) == ["application/problem+json"], (path, method, status)
    assert "ProblemDocument" in document["components"]["schemas"]


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


def test_problem_pages_exist(http):
    document = http.get("/api/v1/runs/nothing").json()
    assert http.get(document["type"]).json()["title"] == document["title"]
    assert json.dumps(document)
