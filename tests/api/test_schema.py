"""Requests that nobody thought of, drawn from the OpenAPI document by schemathesis."""

from __future__ import annotations

import pytest
import schemathesis
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
MODES = (GenerationMode.POSITIVE, GenerationMode.NEGATIVE)


def try_everything(url: str, examples: int) -> list[str]:
    """What goes wrong, one line per operation and mode."""
    wrong = []
    for found in schemathesis.openapi.from_url(f"{url}/openapi.json").get_all_operations():
        operation = found.ok()
        for mode in MODES:
            wrong += try_operation(operation, mode, examples)
    return wrong


def try_operation(operation, mode, examples: int) -> list[str]:
    @seed(1)
    @settings(
        max_examples=examples, deadline=None, database=None, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(case=operation.as_strategy(generation_mode=mode))
    def ask(case):
        case.call_and_validate(checks=CHECKS, timeout=30)

    try:
        ask()
    except Unsatisfiable:
        pass  # nothing can be wrong with a request that has no parts
    except (Exception, BaseExceptionGroup) as failure:
        parts = getattr(failure, "exceptions", [failure])
        return [f"{operation.label} ({mode.value}): {part}" for part in parts]
    return []


def test_some_requests(arm):
    wrong = try_everything(arm.url, 2)
    assert not wrong, "\n\n".join(wrong)


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_many_requests(arm):
    wrong = try_everything(arm.url, 60)
    assert not wrong, "\n\n".join(wrong)
