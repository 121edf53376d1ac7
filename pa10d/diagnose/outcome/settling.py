"""The experiment that would settle a doubt, on its way through files and jobs."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pa10d.common.jsonable import JsonObject


@dataclass(frozen=True)
class NextExperiment:
    """What to run next. parameters: as the kind's own schema says (JSON: who builds the motion
    parses it); apart: standard errors that the two explanations should then be apart.

    Two of the same motion are equal, whatever is expected of it.
    """

    kind: str
    parameters: JsonObject = field(default_factory=dict)
    apart: float | None = field(default=None, compare=False)

    @classmethod
    def read(cls, document: Mapping[str, Any]) -> NextExperiment:
        """From what ``document`` made, or from ``{kind, parameters}`` of somebody else."""
        about = document.get("about") or {}
        parameters = dict(document.get("parameters") or {})
        return cls(document["kind"], parameters, about.get("expected_standard_errors"))

    def document(self) -> JsonObject:
        """As INTERFACES has it: a request that the experiments take as it stands."""
        request = {"kind": self.kind, "parameters": self.parameters}
        if self.apart is None:
            return request
        return {**request, "about": {"expected_standard_errors": self.apart}}

    @property
    def command(self) -> str:
        """What runs it from the command line."""
        words = [
            shlex.quote(f"{key}={json.dumps(value, separators=(',', ':'))}")
            for key, value in self.parameters.items()
        ]
        return " ".join(["pa10d experiment", self.kind, *(["--set", *words] if words else [])])
