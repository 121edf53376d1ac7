"""What is sent twice acts once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest

CHECK = {"kind": "tracking", "parameters": {"cycles": 1}}


def ask(http: httpx.Client, key: str, body: dict, client: str = "one") -> httpx.Response:
    headers = {"Idempotency-Key": key, "X-Client": client}
    return http.post("/api/v1/experiments/check", json=body, headers=headers)


def checks(http: httpx.Client) -> int:
    return len(http.get("/api/v1/jobs", params={"kind": "check", "limit": 500}).json()["items"])


def test_a_repeated_request_gets_the_first_answer(http):
    before = checks(http)
    first, second = ask(http, "a", CHECK), ask(http, "a", CHECK)
    assert (first.status_code, second.status_code) == (202, 202)
    assert first.json()["id"] == second.json()["id"]
    assert first.headers["location"] == second.headers["location"]
    assert "idempotent-replayed" not in first.headers
    assert second.headers["idempotent-replayed"] == "true"
    assert checks(http) == before + 1


def test_two_at_once_act_once(http):
    before = checks(http)
    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(lambda _: ask(http, "b", CHECK), range(4)))
    assert len({answer.json()["id"] for answer in answers}) == 1
    assert checks(http) == before + 1


def test_a_key_belongs_to_one_client_and_one_request(http):
    first = ask(http, "c", CHECK)
    assert ask(http, "c", CHECK, client="two").json()["id"] != first.json()["id"]
    other = ask(http, "c", {**CHECK, "parameters": {"cycles": 2}})
    assert other.status_code == 409
    assert "came with another request" in other.json()["detail"]


def test_without_a_key_every_request_counts(http):
    ids = {http.post("/api/v1/experiments/check", json=CHECK).json()["id"] for _ in range(2)}
    assert len(ids) == 2


def test_a_body_longer_than_stated_is_refused_with_a_key_too(http):
    def endless():
        for _ in range(40):
            yield b"x" * 65536

    answer = http.post(
        "/api/v1/experiments/check", content=endless(), headers={"Idempotency-Key": "d"}
    )
    assert answer.status_code == 413


@pytest.mark.parametrize("length", [101, 5000])
def test_an_endless_key_is_refused(http, length):
    answer = ask(http, "x" * length, CHECK)
    assert answer.status_code == 422
    assert "at most 100" in answer.json()["detail"]


@pytest.mark.parametrize("what", ["stop", "enable", "disable"])
def test_a_command_that_may_be_repeated_is_carried_out_each_time(arm, http, what):
    """A program with one key for all it sends could stop the arm once."""
    arm._ask("DELETE", "/api/v1/robot/lease")
    headers = {"Idempotency-Key": "one for all", "X-Client": "one"}
    first, second = (http.post(f"/api/v1/robot/{what}", headers=headers) for _ in range(2))
    assert (first.status_code, second.status_code) == (200, 200)
    assert "idempotent-replayed" not in second.headers
    long = http.post("/api/v1/robot/stop", headers={"Idempotency-Key": "x" * 101})
    assert long.status_code == 200
    http.post("/api/v1/robot/disable", headers={"X-Client": "one"})
    http.delete("/api/v1/robot/lease", headers={"X-Client": "one"})
