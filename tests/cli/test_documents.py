"""Every JSON document says what it is, and holds what its schema promises."""

from __future__ import annotations

import json

import pytest
from pydantic import TypeAdapter, ValidationError

from pa10d.cli import main
from pa10d.services.documents import SCHEMAS, Plan
from pa10d.trajectory.kinds import KINDS


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Run a command on a folder of its own; the document."""
    folder = tmp_path_factory.mktemp("documents")

    def run(*words, capsys):
        status = main(["--data", str(folder), "--json", *words])
        return status, json.loads(capsys.readouterr().out)

    return run


def test_the_story_of_a_small_machine(told, half_a_minute, capsys):
    source = half_a_minute
    profile = ["--profile", str(source / "robot.urdf")]
    sides = ["--fit", "train", "--validate", "valid"]
    story = [
        ("run-import", ["run", "import", str(source / "train.csv"), *profile, "--name", "train"]),
        ("run-import", ["run", "import", str(source / "valid.csv"), *profile, "--name", "valid"]),
        ("run-show", ["run", "show", "train"]),
        ("identify", ["identify", "train", *profile, "--name", "m0"]),
        ("compare", ["compare", "m0", "valid"]),
        ("diagnose", ["diagnose", "m0", *sides]),
        ("improve", ["improve", "m0", *sides, "--name", "m1"]),
    ]
    for kind, words in story:
        status, document = told(*words, capsys=capsys)
        assert status == 0
        assert document["schema"] == f"pa10d/{kind}/1"
        SCHEMAS[kind].model_validate(document)
    status, runs = told("run", "list", capsys=capsys)
    assert {entry["schema"] for entry in runs} == {"pa10d/run-list/1"}
    status, document = told("compare", "nobody", "valid", capsys=capsys)
    assert status == 1
    SCHEMAS["error"].model_validate(document)


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_what_is_to_be_run_next_has_the_parameters_of_its_kind(kind):
    """In the schema by name, and not judged where a document is read: it may be an older one."""
    schema = SCHEMAS["diagnose"].model_json_schema()
    (plan, _) = schema["$defs"]["Finding"]["properties"]["next_experiment"]["anyOf"]
    of_kind = schema["$defs"][plan["discriminator"]["mapping"][kind].rpartition("/")[2]]
    assert of_kind["properties"]["kind"]["const"] == kind
    named = schema["$defs"][of_kind["properties"]["parameters"]["$ref"].rpartition("/")[2]]
    assert named["properties"].keys() == KINDS[kind].model_json_schema()["properties"].keys()
    plans = TypeAdapter(Plan)
    told = {"kind": kind, "parameters": {}, "about": {"expected_standard_errors": 4.5}}
    if not named.get("required"):
        assert isinstance(plans.validate_python(told).parameters, KINDS[kind])
    with pytest.raises(ValidationError, match="of_tomorrow"):
        plans.validate_python({**told, "parameters": {"of_tomorrow": 1}})


@pytest.mark.parametrize("name", sorted(SCHEMAS))
def test_schemas_are_printed(name, told, capsys):
    _, document = told("schema", f"pa10d/{name}/1", capsys=capsys)
    assert document["$id"] == f"pa10d/{name}/1"
    assert document["type"] == "object"
