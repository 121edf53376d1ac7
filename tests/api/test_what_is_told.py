"""What clients are told has fields with types; what has none is listed here with the reason."""

from __future__ import annotations

from types import SimpleNamespace

from pa10d.api.app import create_app
from pa10d.api.schemas.arm import Fault
from pa10d.services.command_documents import KINDS_OF_DOCUMENT, FaultTold, schema_of

SAYS_NOTHING = {"title", "description", "default", "deprecated", "examples"}
FREE = {
    "Figure/data", "Figure/layout",  # Plotly's
    "KindAbout/parameters",  # a JSON schema
    "Job/request", "JobWithResult/request",  # of jobs of any kind, those of weighings, too
    "ProfileChanges/changes", "TuningBound/most", "TuningDifference/old", "TuningDifference/new",
    "TuningValue/written", "TuningValue/in_force",  # of a key of the profile: what its file holds
}  # fmt: skip


def free(schema, place):
    """Places of a schema under which anything may stand."""
    anything = schema.get("type") == "object" and "properties" not in schema
    if not set(schema) - SAYS_NOTHING or (
        anything and schema.get("additionalProperties", True) in (True, {})
    ):
        return {place}
    found = set()
    for name, inner in schema.get("properties", {}).items():
        found |= free(inner, f"{place}/{name}")
    for name, inner in schema.get("$defs", {}).items():
        found |= free(inner, name)
    for key in ("anyOf", "oneOf", "allOf", "prefixItems"):
        for inner in schema.get(key, []):
            found |= free(inner, place)
    for key in ("items", "additionalProperties"):
        if isinstance(schema.get(key), dict):
            found |= free(schema[key], place)
    return found


def test_what_goes_over_http_has_fields():
    schemas = create_app(SimpleNamespace()).openapi()["components"]["schemas"]  # type: ignore[arg-type]
    assert set().union(*(free(schema, name) for name, schema in schemas.items())) == FREE


def test_what_commands_print_has_fields():
    schemas = {name: schema_of(name) for name in KINDS_OF_DOCUMENT}
    assert set().union(*(free(schema, name) for name, schema in schemas.items())) <= FREE


def test_a_fault_is_told_alike_over_http_and_by_commands():
    assert FaultTold.model_fields.keys() == Fault.model_fields.keys()
