"""A client that somebody else's generator makes of our OpenAPI document has every operation."""

from __future__ import annotations

import importlib
import json
import pkgutil
import sys
from types import SimpleNamespace

import httpx
import pytest
from openapi_python_client import generate
from openapi_python_client.config import Config, ConfigFile, MetaType

from pa10d.api.app import create_app

ARROW = {"application/vnd.apache.arrow.stream": "application/octet-stream"}
LONGEST = 24  # letters of an operation's name
COMPARED = {
    "id": "abc", "name": "m0", "cutoff_hz": 10.0, "mask": "moving", "where": [],
    "runs": [], "pooled": {
        "rms": [0.1], "rms_raw": [0.2], "nrmse": [None], "max": [0.4], "r2": [0.9],
        "noise_floor": [None], "cutoff_hz": 10.0, "mask": "moving",
    },
}  # fmt: skip
JOB = {
    "id": "j1", "kind": "compare", "request": {"model": "m0", "runs": ["r1"]},
    "status": "succeeded", "progress": 1.0, "message": "",
    "error": None, "created": "", "started": None, "finished": None,
    "result": COMPARED,
}  # fmt: skip


@pytest.fixture(scope="module")
def document():
    return create_app(SimpleNamespace()).openapi()  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def operations(document):
    """(tag, operation's name) of each."""
    return [
        (operation["tags"][0], operation["operationId"])
        for path in document["paths"].values()
        for operation in path.values()
    ]


@pytest.fixture(scope="module")
def client(document, tmp_path_factory):
    """The generated package, imported."""
    folder = tmp_path_factory.mktemp("generated")
    source = folder / "openapi.json"
    source.write_text(json.dumps(document))
    asked = ConfigFile(content_type_overrides=ARROW, post_hooks=[])
    errors = generate(
        config=Config.from_sources(
            asked,
            MetaType.NONE,
            source,
            "utf-8",
            overwrite=False,
            output_path=folder / "pa10d_made",
        )
    )
    assert not errors, [f"{error.header} {error.detail}" for error in errors]
    sys.path.insert(0, str(folder))
    yield importlib.import_module("pa10d_made")
    sys.path.remove(str(folder))


def test_names_are_short_and_meant_once(operations):
    names = [name for _, name in operations]
    assert len(set(names)) == len(names)
    assert not [name for name in names if len(name) > LONGEST]


def test_no_schema_bears_the_name_of_a_module(document):
    assert not [name for name in document["components"]["schemas"] if "__" in name]


def test_every_operation_is_a_function_and_every_module_imports(client, operations):
    made = {found.name for found in pkgutil.walk_packages(client.__path__, "pa10d_made.")}
    for module in made:
        importlib.import_module(module)
    assert not {f"pa10d_made.api.{tag}.{name}" for tag, name in operations} - made


def calls(client, answer):
    """A generated client that is answered without a network, and the requests it made."""
    seen: list[httpx.Request] = []

    def respond(request: httpx.Request) -> httpx.Response:
        seen.append(request)
        return httpx.Response(200, json=answer)

    transport = httpx.MockTransport(respond)
    return client.Client("http://arm", httpx_args={"transport": transport}), seen


def test_a_recording_is_uploaded(client):
    import_run = importlib.import_module("pa10d_made.api.runs.import_run")
    types = importlib.import_module("pa10d_made.types")
    arm, seen = calls(client, {})
    body = types.File(payload=b"time,q1,tau1\n")
    import_run.sync_detailed(client=arm, body=body, filename="a.csv")
    (request,) = seen
    assert (request.method, request.url.path) == ("POST", "/api/v1/runs")
    assert request.content == b"time,q1,tau1\n"
    assert request.url.params["filename"] == "a.csv"


def test_a_result_is_an_object_with_fields(client):
    show = importlib.import_module("pa10d_made.api.analyses.show_comparison")
    arm, _ = calls(client, JOB)
    job = show.sync("j1", client=arm)
    assert (job.request.model, job.request.runs) == ("m0", ["r1"])
    assert job.result.pooled.rms == [0.1]
    assert job.result.pooled.noise_floor == [None]


def test_any_job_s_result_is_the_one_of_its_kind(client):
    show = importlib.import_module("pa10d_made.api.jobs.show_job")
    models = importlib.import_module("pa10d_made.models")
    arm, _ = calls(client, JOB)
    assert isinstance(show.sync("j1", client=arm).result, models.Compare)


def test_what_an_experiment_takes_has_a_type_with_fields(client):
    start = importlib.import_module("pa10d_made.api.experiments.start_experiment")
    models = importlib.import_module("pa10d_made.models")
    arm, seen = calls(client, {})
    asked = models.TrackingParameters(amplitude=0.3, period=4.0, joints=[4])
    start.sync_detailed(client=arm, body=models.ExperimentRequest("tracking", parameters=asked))
    sent = json.loads(seen[0].content)
    assert sent["kind"] == "tracking"
    assert sent["parameters"] == asked.to_dict()
    assert sent["parameters"]["joints"] == [4]
