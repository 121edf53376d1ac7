"""A file is looked at, corrected, imported or let go, over HTTP."""

from __future__ import annotations

import asyncio
import csv
import json

import numpy as np
import pytest
from fastapi import FastAPI, Request

from pa10d.api.problems import install

FIELDS = [f"{field}{j}" for field in ("q", "tau") for j in range(1, 8)]


@pytest.fixture(scope="module")
def strange(csv_file):
    """The recording with names and units of its logger's own: ms, degrees, joints from 0."""
    with csv_file.open(newline="") as file:
        rows = list(csv.reader(file))
    names = ["stamp", *(f"pos_{j}" for j in range(7)), *(f"trq_{j}" for j in range(7)), "mode"]
    names += [f"dq{j}" for j in range(1, 8)]
    table = np.array([row[:15] for row in rows[1:]], dtype=float)
    table[:, 1:8] *= 2  # a swing that this arm cannot do in rad
    speeds = np.gradient(table[:, 1:8], table[:, 0], axis=0)
    table[:, 1:8] = np.degrees(table[:, 1:8])
    table[:, 0] *= 1e3
    lines = [";".join(names)]
    for values, fast in zip(table, speeds, strict=True):
        lines.append(";".join([*(f"{v:.9g}" for v in values), "1", *(f"{v:.9g}" for v in fast)]))
    return "\n".join(lines).encode()


def send(http, content, name="log.csv"):
    return http.post("/api/v1/recordings", params={"filename": name}, content=content)


def test_a_guess_is_shown_and_becomes_a_run(http, arm, strange):
    runs = len(arm.runs())
    answer = send(http, strange)
    assert answer.status_code == 201
    seen = answer.json()
    assert seen["problem"] == ""
    assert seen["rules"] == ["stamp[ms]=time", "pos_{n-1}[deg]=q", "trq_{n-1}=tau"]
    assert (seen["file"], seen["samples"]) == ("log.csv", 600)
    assert {c["name"]: c["field"] for c in seen["columns"]}["mode"] == ""
    assert len(seen["columns"][1]["curve"]) == 120
    assert seen["columns"][0]["first"] == [0, 2, 4, 6, 8]
    assert len(arm.runs()) == runs
    asked = {"map": seen["rules"], "name": "by dialogue"}
    made = http.post(f"/api/v1/recordings/{seen['id']}/import", json=asked)
    assert made.status_code == 201
    assert "give --map" in made.json()["mapping_kept"]  # a shipped profile is nobody's to write
    run = arm.run("by dialogue")
    assert run["samples"] == 600
    gone = http.post(f"/api/v1/recordings/{seen['id']}/preview", json={})
    assert gone.status_code == 404
    arm.delete_run(run["id"])


def test_a_choice_is_corrected(http, strange):
    seen = send(http, strange).json()
    chosen = [
        {"column": c["name"], "field": c["field"], "unit": c["unit"]}
        for c in seen["columns"]
        if c["field"]
    ]
    plain = [c | {"unit": "" if c["field"].startswith("q") else c["unit"]} for c in chosen]
    at = f"/api/v1/recordings/{seen['id']}"
    wrong = http.post(f"{at}/preview", json={"columns": plain, "thorough": False}).json()
    (degrees,) = [f for f in wrong["findings"] if f["code"] == "degrees"]
    assert degrees["severity"] == "error"
    assert degrees["mends"] == [c for c in chosen if c["field"].startswith("q")]
    refused = http.post(f"{at}/import", json={"map": wrong["rules"]})
    assert refused.status_code == 409
    assert "look like degrees" in refused.json()["detail"]
    missing = http.post(f"{at}/preview", json={"columns": chosen[:3]}).json()
    assert "no column q3, q4" in missing["problem"]
    assert missing["findings"] == []
    assert http.delete(at).json() == {"id": seen["id"], "file": "log.csv"}
    assert http.delete(at).status_code == 404


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ([{"column": "pos_0", "field": "q99999"}], "pattern"),
        ([{"column": "pos_0", "field": "q1", "unit": "x" * 99}], "at most 40"),
        ([{"column": "pos_0"}], "Field required"),
    ],
)
def test_choices_are_typed(http, strange, columns, says):
    seen = send(http, strange).json()
    answer = http.post(f"/api/v1/recordings/{seen['id']}/preview", json={"columns": columns})
    assert answer.status_code == 422
    assert says in json.dumps(answer.json())
    http.delete(f"/api/v1/recordings/{seen['id']}")


def test_a_file_that_cannot_be_read_is_one_line_and_stays_nowhere(http):
    answer = send(http, b"\x89PNG\r\n" + bytes(3000), "photo.png")
    assert answer.status_code == 400
    assert answer.json()["detail"].startswith("photo.png: neither text nor a format")
    assert send(http, b"x", "..").status_code == 400


def test_only_so_many_wait(http, strange):
    seen = [send(http, strange).json()["id"] for _ in range(9)]
    first, last = (
        http.post(f"/api/v1/recordings/{one}/preview", json={"thorough": False})
        for one in (seen[0], seen[-1])
    )
    assert (first.status_code, last.status_code) == (404, 200)
    for one in seen[1:]:
        http.delete(f"/api/v1/recordings/{one}")


def test_a_stored_run_is_checked(http, arm, csv_file):
    run = arm.upload(csv_file, "to be checked")
    found = http.get(f"/api/v1/runs/{run['id']}/check").json()["items"]
    assert "short" in [one["code"] for one in found]
    assert "rate" in [one["code"] for one in found]
    assert http.get("/api/v1/runs/nobody/check").status_code == 404
    arm.delete_run(run["id"])


def test_a_sender_that_leaves_in_the_middle_is_no_bug_of_ours(caplog):
    """Whatever part of an upload was sent: no traceback in the log, for who reads it next."""
    app = FastAPI()
    install(app)

    @app.post("/upload")
    async def upload(request: Request) -> None:
        async for _ in request.stream():
            pass

    frames = [{"type": "http.request", "body": b"time,q", "more_body": True}]
    sent = []

    async def receive():
        return frames.pop() if frames else {"type": "http.disconnect"}

    async def send(message):
        sent.append(message)

    scope = {
        "type": "http",
        "method": "POST",
        "path": "/upload",
        "headers": [],
        "query_string": b"",
    }
    asyncio.run(app(scope, receive, send))
    assert sent[0]["status"] < 500
    assert caplog.records == []
