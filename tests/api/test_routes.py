"""The resources as a client meets them, with a simulated arm behind them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pa10d.client import ApiError, Client, JobFailed


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


@pytest.mark.parametrize("name", ["a/b", ".a", " a"])
def test_a_name_that_cannot_be_is_refused_before_anything_begins(arm, http, name):
    before = http.get("/api/v1/jobs").json()["total"]
    one = {"kind": "tracking", "name": name}
    for path, asked in {
        "experiments": one,
        "experiments/series": {"experiments": [one | {"replace": True}]},
        "models": {"runs": ["train"], "name": name},
    }.items():
        with pytest.raises(ApiError, match="expected") as refused:
            arm.start(path, asked)
        assert refused.value.status == 400, path
    assert http.get("/api/v1/jobs").json()["total"] == before


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


def test_problem_pages_exist(http):
    document = http.get("/api/v1/runs/nothing").json()
    assert http.get(document["type"]).json()["title"] == document["title"]
    assert json.dumps(document)
