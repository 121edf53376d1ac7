"""Which experiment a diagnosis asks for next."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

Document = Mapping[str, Any]


def new_plan(findings: Sequence[Document], tried: Sequence[Document]) -> Document | None:
    """The first finding (as JSON) whose ``next_experiment`` is not among the plans tried."""
    known = {_essence(plan) for plan in tried}
    for finding in findings:
        plan = finding["next_experiment"]
        if plan is not None and _essence(plan) not in known:
            return finding
    return None


def _essence(plan: Document) -> str:
    return json.dumps([plan["kind"], plan.get("parameters") or {}], sort_keys=True)
