"""The OpenAPI document, with what FastAPI cannot know: our problems, and what each kind takes."""

from __future__ import annotations

from fastapi import FastAPI

from pa10d.api import problems
from pa10d.common.jsonable import JsonObject
from pa10d.trajectory.kinds import KINDS

OF_A_KIND = ("ExperimentRequest", "Shown", "Suggested", "TrackRequest")  # with parameters of a kind


def describe(app: FastAPI) -> None:
    """Have the app serve it."""
    made = app.openapi

    def openapi() -> JsonObject:
        if not app.openapi_schema:
            schema = made()
            _problems(schema)
            _parameters(schema)
            app.openapi_schema = schema
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]


def _problems(schema: JsonObject) -> None:
    """Wrong requests are problems too: our schema in the place of FastAPI's own one."""
    schemas = schema.setdefault("components", {}).setdefault("schemas", {})
    schemas["ProblemDocument"] = problems.ProblemDocument.model_json_schema()
    schemas.pop("HTTPValidationError", None)
    schemas.pop("ValidationError", None)
    invalid = problems.responses()[422]
    anywhere = problems.responses("too-large", "crowded", "busy", "ended", "no-room")
    anywhere = {str(status): said for status, said in anywhere.items() if status != 422}
    for path in schema["paths"].values():
        for operation in path.values():
            operation["responses"] = anywhere | operation["responses"]
            if "422" in operation["responses"]:
                operation["responses"]["422"] = invalid


def _parameters(schema: JsonObject) -> None:
    """Every kind's parameters as a type of their own, in the place of any object."""
    schemas = schema["components"]["schemas"]
    one_of_them = []
    for kind in KINDS.values():
        name = f"{kind.__name__}Parameters"
        schemas[name] = kind.model_json_schema() | {"title": name}
        one_of_them.append({"$ref": f"#/components/schemas/{name}"})
    for name in OF_A_KIND:
        parameters = schemas[name]["properties"]["parameters"]
        for of_any_object in ("type", "additionalProperties", "default"):
            parameters.pop(of_any_object, None)
        parameters["anyOf"] = one_of_them
