"""Every JSON document says what it is, and holds what its schema promises."""

from __future__ import annotations

import argparse
import json

import pytest
from pydantic import TypeAdapter, ValidationError

from pa10d.cli import main, whole_parser
from pa10d.services.command_documents import KINDS_OF_DOCUMENT
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


def holds(kind, document):
    """What the schema of its kind promises."""
    TypeAdapter(KINDS_OF_DOCUMENT[kind]).validate_python(document)


def test_every_command_has_a_schema():
    """A command that is added without one is told."""
    kinds = set()

    def walk(parser):
        kinds.update({parser.get_default("answers")} - {None})
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                for inner in action.choices.values():
                    walk(inner)

    walk(whole_parser())
    assert len(kinds) > 40
    assert kinds | {"error"} == set(KINDS_OF_DOCUMENT)


@pytest.mark.long
def test_the_story_of_a_small_machine(told, half_a_minute, tmp_path, capsys):
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
        holds(kind, document)
    status, runs = told("run", "list", capsys=capsys)
    assert {entry["schema"] for entry in runs} == {"pa10d/run-list/1"}
    folder = tmp_path
    for kind, words in [
        ("run-list", ["run", "list"]),
        ("run-check", ["run", "check", "train", *profile]),
        ("run-preview", ["run", "preview", str(source / "train.csv"), *profile]),
        ("run-export", ["run", "export", "train", "--out", str(folder / "o.csv"),
                        "--format", "csv"]),
        ("run-repair", ["run", "repair"]),
        ("model-list", ["model", "list"]),
        ("model-show", ["model", "show", "m1"]),
        ("model-history", ["model", "history", "m1"]),
        ("model-export", ["model", "export", "m0", "--out", str(folder / "m0.json"),
                          "--format", "json"]),
        ("model-report", ["model", "report", "m0", "--out", str(folder / "m0.html")]),
        ("add", ["add", "m0", "torque_offset", "--joint", "1", "--fit", "train", "--name", "m2"]),
        ("effect-list", ["effect", "list"]),
        ("effect-page", ["effect", "page", "viscous"]),
        ("effect-check", ["effect", "check", "viscous", "--draws", "1"]),
        ("effect-new", ["effect", "new", "soft_x", "--out", str(folder / "soft_x")]),
        ("profile-list", ["profile", "list"]),
        ("profile-show", ["profile", "show", "--profile", "pa10-sim"]),
        ("profile-versions", ["profile", "versions", "--profile", "pa10-sim"]),
        ("completion", ["completion", "bash"]),
        ("schema", ["schema"]),
        ("run-delete", ["run", "delete", "valid"]),
    ]:  # fmt: skip
        status, document = told(*words, capsys=capsys)
        assert status == 0, kind
        for entry in document if isinstance(document, list) else [document]:
            assert entry["schema"] == f"pa10d/{kind}/1"
            holds(kind, entry)
    status, document = told("compare", "nobody", "valid", capsys=capsys)
    assert status == 1
    holds("error", document)


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


@pytest.mark.by_default("add", "diagnose", "error", "identify", "run-import", "serve", "weigh-show")
@pytest.mark.parametrize("name", sorted(KINDS_OF_DOCUMENT))
def test_schemas_are_printed(name, told, capsys):
    _, document = told("schema", f"pa10d/{name}/1", capsys=capsys)
    assert document["$id"] == f"pa10d/{name}/1"
    assert document.get("type") == "object" or "anyOf" in document
