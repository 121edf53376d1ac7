"""Who is let in: origins, hosts, tokens, sizes, paths."""

from __future__ import annotations

import base64
import hashlib
import re
import socket
import subprocess
import sys
from pathlib import Path

import httpx
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

import pa10d
from pa10d.api.access import UPLOAD, tokens_from
from pa10d.api.assets import AHEAD_HASH
from pa10d.cli import main
from pa10d.common.errors import UserError

PROBLEM = "application/problem+json"


def refused(response: httpx.Response, status: int, kind: str) -> dict:
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == PROBLEM
    document = response.json()
    assert document["type"].endswith(kind)
    assert document["status"] == status
    return document


def test_a_foreign_page_cannot_command_the_arm(http):
    for headers in (
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
    ):
        refused(http.post("/api/v1/robot/enable", headers=headers), 403, "origin")
    assert http.get("/api/v1/robot").json()["state"] == "inactive"


def test_a_rebound_name_is_not_served(http):
    for host in ("evil.example", "evil.example:8010", "127.0.0.1.evil.example"):
        refused(http.get("/api/v1/runs", headers={"Host": host}), 403, "origin")


def test_the_own_page_is_let_in(http):
    own = {"Origin": str(http.base_url).rstrip("/"), "Sec-Fetch-Site": "same-origin"}
    assert http.get("/api/v1/robot", headers=own).status_code == 200


def test_sockets_are_closed_to_foreign_pages(arm):
    address = "ws" + arm.url.removeprefix("http") + "/api/v1/telemetry"
    with pytest.raises(InvalidStatus) as refusal:
        connect(address, origin="http://evil.example", proxy=None)
    assert refusal.value.response.status_code == 403


def test_sockets_are_closed_to_rebound_names(arm):
    address = "ws" + arm.url.removeprefix("http") + "/api/v1/events"
    with pytest.raises(InvalidStatus) as refusal:
        connect(address, additional_headers={"Host": "evil.example"}, proxy=None)
    assert refusal.value.response.status_code in (400, 403)


def test_sockets_want_the_token(guarded):
    address = "ws" + str(guarded.base_url).removeprefix("http").rstrip("/") + "/api/v1/events"
    for query in ("", "?token=wrong"):
        with pytest.raises(InvalidStatus) as refusal:
            connect(address + query, proxy=None)
        assert refusal.value.response.status_code == 403
    with connect(address + "?token=seer", proxy=None) as socket_:
        assert socket_.protocol.state.name == "OPEN"


def test_the_page_itself_is_not_served_under_a_rebound_name(http):
    for path in ("/", "/assets/now/main.js", "/assets/now/plotly.js"):
        assert http.get(path).status_code == 200
        refused(http.get(path, headers={"Host": "evil.example"}), 403, "origin")
    refused(http.get("/assets/now/..%2fapp.py"), 404, "not-found")


@pytest.mark.parametrize(
    "path",
    [
        "/api/v1/runs/..%2f..%2fdaemon.json",
        "/api/v1/runs/%2e%2e%2f%2e%2e%2fetc%2fpasswd/export?format=csv",
        "/api/v1/models/..%2F..%2Fdaemon.json",
        "/api/v1/jobs/..%2f..%2fdaemon",
        "/docs/..%2f..%2f__init__.py",
        "/..%2f..%2f..%2fetc/passwd",
        "/%2e%2e/%2e%2e/pyproject.toml",
    ],
)
def test_no_path_leaves_the_store(http, path):
    response = http.get(path)
    assert response.status_code == 404
    assert "token" not in response.text
    assert "root:" not in response.text


@pytest.mark.parametrize("name", ["../../escape.csv", "..\\..\\escape.csv", "/etc/escape.csv"])
def test_an_upload_stays_in_its_folder(http, csv_file, name):
    response = http.post("/api/v1/runs", params={"filename": name}, content=csv_file.read_bytes())
    assert response.status_code == 201, response.text
    assert response.json()["source"] == "escape.csv"
    http.delete(f"/api/v1/runs/{response.json()['id']}")


@pytest.mark.parametrize("name", ["..", ".", "a/..", "\x00.csv"])
def test_a_name_that_is_none_is_refused(http, csv_file, name):
    response = http.post("/api/v1/runs", params={"filename": name}, content=csv_file.read_bytes())
    assert response.status_code in (400, 422)


def test_a_large_request_is_refused_before_it_is_read(http):
    refused(http.post("/api/v1/comparisons", content=b" " * (2 << 20)), 413, "too-large")


def test_a_large_request_without_a_length_is_cut_off(http):
    def parts():
        for _ in range(64):
            yield b" " * 65536

    response = http.post(
        "/api/v1/comparisons", content=parts(), headers={"content-type": "application/json"}
    )
    refused(response, 413, "too-large")


def test_an_oversized_upload_is_refused_by_its_stated_length(arm):
    host, port = arm.url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), 10) as raw:
        head = f"POST /api/v1/runs HTTP/1.1\r\nHost: {host}:{port}\r\nContent-Length: {1 << 40}\r\n"
        raw.sendall(head.encode() + b"Content-Type: text/csv\r\n\r\ntime,q1")
        answer = b""
        while b"pa10d run import" not in answer and (part := raw.recv(4096)):
            answer += part
        assert b" 413 " in answer.split(b"\r\n")[0]
        assert b"on the daemon's machine 'pa10d run import FILE' takes it" in answer


def test_the_page_refuses_what_the_daemon_would():
    page = (Path(pa10d.__file__).parent / "web" / "parts" / "drop.js").read_text()
    said = re.search(r"LARGEST = (\d+) \* 2 \*\* 20;", page)
    assert said
    assert int(said[1]) << 20 == UPLOAD


def test_other_machines_need_a_token(tmp_path):
    options = ["--data", str(tmp_path), "serve", "--port", "0", "--host", "0.0.0.0", "--no-sim"]
    made = subprocess.run(
        [sys.executable, "-m", "pa10d", *options], capture_output=True, text=True, timeout=60
    )
    assert made.returncode == 1
    assert "expected a loopback address, or tokens" in made.stderr


def test_tokens_are_what_was_written():
    assert tokens_from(" secret\n", "file") == {"admin": "secret"}
    assert tokens_from('{"admin": "a", "look": "b"}', "file") == {"look": "b", "admin": "a"}


@pytest.mark.parametrize(
    "text",
    ["", " \n", "{}", '{"admn": "x"}', '{"look": "x", "adminn": "y"}', '{"admin": ""}', "{admin",
     '{"admin": 5}', '{"admin": ["x"]}', "two\nlines", "b\u00e4r", '{"a":' * 5000],
)  # fmt: skip
def test_a_file_without_sound_tokens_lets_nobody_in(text):
    """Without any token whoever is on this machine commands the arm."""
    with pytest.raises(UserError, match=r"^file: ") as refusal:
        tokens_from(text, "file")
    assert "\n" not in str(refusal.value)


def test_serve_does_not_begin_with_a_typo_among_its_tokens(tmp_path, capsys):
    (tmp_path / "tokens").write_text('{"admn": "x"}')
    options = ["--data", str(tmp_path), "serve", "--port", "0", "--no-sim", "--token-file"]
    assert main([*options, str(tmp_path / "tokens")]) == 1
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith(f"{tmp_path / 'tokens'}: found 'admn', expected one token")


def test_tokens_reach_as_far_as_they_say(guarded):
    def ask(method, path, token=None):
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        return guarded.request(method, path, headers=headers)

    assert ask("GET", "/healthz").status_code == 200
    refused(ask("GET", "/api/v1/robot"), 401, "token")
    refused(ask("GET", "/api/v1/robot", "wrong"), 401, "token")
    refused(ask("GET", "/metrics"), 401, "token")
    assert ask("GET", "/api/v1/robot", "seer").status_code == 200
    assert ask("POST", "/api/v1/robot/stop", "seer").status_code == 200
    refused(ask("POST", "/api/v1/robot/enable", "seer"), 403, "scope")
    assert ask("POST", "/api/v1/robot/enable", "mover").status_code in (409, 503)
    refused(ask("POST", "/api/v1/experiments/series", "seer"), 403, "scope")
    refused(ask("POST", "/api/v1/runs", "seer"), 403, "scope")
    refused(ask("DELETE", "/api/v1/runs/x", "mover"), 403, "scope")
    refused(ask("DELETE", "/api/v1/runs/x", "root"), 404, "not-found")
    refused(ask("PATCH", "/api/v1/profile", "mover"), 403, "scope")
    refused(ask("POST", "/api/v1/profile/undo", "mover"), 403, "scope")
    refused(ask("PATCH", "/api/v1/profile", "root"), 422, "invalid")
    refused(ask("POST", "/api/v1/profile/check", "mover"), 422, "invalid")
    refused(ask("POST", "/api/v1/weighings/x/apply", "mover"), 403, "scope")
    refused(ask("POST", "/api/v1/weighings/x/undo", "mover"), 403, "scope")
    refused(ask("POST", "/api/v1/weighings/x/undo", "root"), 404, "not-found")
    refused(ask("POST", "/api/v1/weighings", "mover"), 422, "invalid")


def test_stop_pressed_before_its_script_is_there_says_that_nobody_heard(guarded):
    """A plain form shows no token: a bare refusal would leave the user with a moving arm."""
    made = guarded.post("/api/v1/robot/stop-page")
    assert made.status_code == 401
    assert made.headers["content-type"].startswith("text/html")
    assert "STOP WAS NOT HEARD" in made.text
    assert "Press the hardware emergency stop" in made.text
    assert "<form" not in made.text, "nobody would hear it either"
    made = guarded.post("/api/v1/robot/stop-page", headers={"Authorization": "Bearer seer"})
    assert "Stop was heard" in made.text
    assert "<form" in made.text


def test_replacing_takes_away_and_needs_what_deleting_needs(guarded):
    def ask(path, token, **more):
        headers = {"Authorization": f"Bearer {token}"}
        return guarded.post(f"/api/v1/{path}", headers=headers, **more)

    fit = {"runs": ["x"], "name": "m", "replace": True}
    motion = {"kind": "tracking", "name": "x", "replace": True}
    refused(ask("models", "mover", json=fit), 403, "scope")
    refused(ask("models", "root", json=fit), 404, "not-found")
    refused(ask("experiments", "mover", json=motion), 403, "scope")
    refused(ask("runs?name=x&replace=true", "mover", content=b"time"), 403, "scope")
    refused(ask("models", "mover", json=fit | {"replace": False}), 404, "not-found")


@pytest.mark.parametrize("host", ["[::1", "[", "localhost:x:y", "a" * 5000, "]", "[::1]x"])
def test_a_host_that_is_none_is_refused(http, host):
    answer = http.get("/api/v1/robot", headers={"Host": host})
    assert answer.status_code in (400, 403)


def test_a_request_that_says_its_length_twice_is_refused(arm):
    host, port = arm.url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=10) as raw:
        raw.sendall(
            b"POST /api/v1/robot/stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n"
            b"Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"
        )
        assert b" 400 " in raw.recv(4096).split(b"\r\n")[0]


def test_pages_may_not_fetch_from_elsewhere(http):
    for path in ("/", "/docs"):
        policy = http.get(path).headers["content-security-policy"]
        assert "default-src 'self'" in policy
        assert "frame-ancestors 'none'" in policy
        assert f"script-src 'self' 'sha256-{AHEAD_HASH}';" in policy
    script = re.search(r"<script>(.+?)</script>", http.get("/").text, re.DOTALL)
    assert script
    told = base64.b64encode(hashlib.sha256(script[1].encode()).digest()).decode()
    assert told == AHEAD_HASH, "the one script that stands in the page itself"


def test_what_is_no_document_has_no_rules_for_documents(http):
    for path in ("/api/v1/robot", "/assets/now/main.js", "/assets/now/style/frame.css"):
        headers = http.get(path).headers
        assert headers["x-content-type-options"] == "nosniff"
        assert "content-security-policy" not in headers


def test_docs_need_no_internet(http):
    import re

    page = http.get("/docs")
    assert page.status_code == 200
    assets = re.findall(r'(?:src|href)="([^"]+)"', page.text)
    assert len(assets) == 3
    for asset in assets:
        assert asset.startswith("/docs/")
        assert http.get(asset).status_code == 200
    assert "http" not in page.text.replace("http-equiv", "")


def test_a_listener_that_talks_on_and_on_is_left(arm):
    """A flood of messages kept 'stop' from being heard."""
    from websockets.exceptions import ConnectionClosed

    with connect(arm.url.replace("http", "ws") + "/api/v1/events", proxy=None) as one:
        with pytest.raises(ConnectionClosed):  # noqa: PT012
            for _ in range(100_000):
                one.send("x" * 64)
        assert one.close_code in (1008, 1006)
    assert arm.stop(wait=0)["state"]
