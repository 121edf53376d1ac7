"""Requests that nobody thought of, drawn from the OpenAPI document by schemathesis."""

from __future__ import annotations

from itertools import islice

import pytest
import requests
import schemathesis
from how_often import how_often
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
]
LONGEST = 40_000  # characters of a request that an HTTP server need not read to its end
CUT = (requests.exceptions.ConnectionError, requests.exceptions.ChunkedEncodingError)
MODES = (GenerationMode.POSITIVE, GenerationMode.NEGATIVE)


class Asked:
    """How many requests were made, and what went wrong: one line per operation and mode."""

    def __init__(self) -> None:
        self.count = 0
        self.wrong: list[str] = []


def try_everything(url: str, examples: int, every: int = 1) -> Asked:
    """every: which of the operations, the first and so many further on; their draws cost most."""
    asked = Asked()
    document = schemathesis.openapi.from_url(f"{url}/openapi.json")
    for found in islice(document.get_all_operations(), 0, None, every):
        operation = found.ok()
        for mode in MODES:
            asked.wrong += try_operation(operation, mode, examples, asked)
    return asked


def try_operation(operation, mode, examples: int, asked: Asked) -> list[str]:
    @seed(1)
    @settings(
        max_examples=examples, deadline=None, database=None, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(case=operation.as_strategy(generation_mode=mode))
    def ask(case):
        asked.count += 1
        try:
            case.call_and_validate(checks=CHECKS, timeout=30)
        except CUT as cut:
            asked_for = case.as_curl_command()
            if len(asked_for) < LONGEST:
                raise AssertionError(f"{cut}: {asked_for}") from cut

    try:
        ask()
    except Unsatisfiable:
        pass  # nothing can be wrong with a request that has no parts
    except (Exception, BaseExceptionGroup) as failure:
        parts = getattr(failure, "exceptions", [failure])
        return [f"{operation.label} ({mode.value}): {part}" for part in parts]
    return []


@pytest.fixture
def attacked(arm):
    """Afterwards nobody commands the arm, and it is connected and unpowered as before."""
    yield arm
    for job in arm._ask("GET", "/api/v1/jobs", params={"status": "running"})["items"]:
        arm.cancel(job["id"])
    while (holder := arm.robot()["lease"]["holder"]) is not None:
        arm._http.delete("/api/v1/robot/lease", headers={"X-Client": holder})
    back = {"offline": arm.connect, "fault": arm.reset, "holding": arm.disable}
    while (state := arm.wait_for_robot(*back, "inactive")["state"]) != "inactive":
        back[state]()
    arm.let_others_command()


def test_some_requests(attacked):
    asked = try_everything(attacked.url, 2, every=6)
    assert not asked.wrong, "\n\n".join(asked.wrong)


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_many_requests(attacked, request):
    asked = try_everything(attacked.url, how_often(request.config, 2, 60))
    request.node.user_properties.append(("requests", asked.count))
    assert not asked.wrong, "\n\n".join(asked.wrong)
