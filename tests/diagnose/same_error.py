"""Whoever tells of a parameter tells one standard error."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from pa10d.daemon.jobs import tasks
from pa10d.face.model import Model
from pa10d.services.library import open_library


def assert_one_error(
    ask: Callable[..., Any], data: str, folder: Path, found: Mapping[str, Any], page: Path
) -> None:
    """found: what ``improve`` told that made m1, whose last finding is on joint 2; page: its
    report; ask: of the command line, about this data; folder: for what is written."""
    finding = found["findings"][-1]
    kind = finding["effect"]
    says = {name: (v["value"], v["std_error"]) for name, v in finding["parameters"].items()}
    label = f"{kind} J2: "

    def same(told):
        """told: name -> (value, error), of this effect at least."""
        assert set(says) <= set(told)
        for name, pair in says.items():
            assert told[name] == pytest.approx(pair, rel=1e-6)

    shown = ask("model", "show", "m1")["parameters"]
    own = [p for p in shown if p["name"].startswith(label)]
    same({p["name"].removeprefix(label): (p["value"], p["std_error"]) for p in own})
    here = tasks.model_document(data, "m1")["parameters"]
    assert [p["std_error"] for p in here] == pytest.approx([p["std_error"] for p in shown])

    library = open_library(data)
    stored = library.models.load(library.models.find("m1"))
    same({k: (v.value, v.std_error) for k, v in stored.term_values(-1 % len(stored.terms)).items()})
    face = Model(stored)
    same({p.name: (p.value, p.std_error) for p in face.effects[-1].parameters})
    bodies = [p.std_error for p in face.base_parameters]
    assert bodies == pytest.approx([p["std_error"] for p in shown[: len(bodies)]])

    ask(
        "model",
        "export",
        "m1",
        "--format",
        "json",
        "--parameters",
        "free",
        "--out",
        str(folder / "m1.json"),
    )
    exported = json.loads((folder / "m1.json").read_text())
    (sent,) = [e for e in exported["effects"] if e["effect"] == kind]
    same({k: (v["value"], v["std_error"]) for k, v in sent["values"].items()})
    for name, told in {**sent["coefficients"], **sent["shape"]}.items():
        if name in says:
            assert told["std_error"] == pytest.approx(says[name][1], rel=1e-6)
    sent_bodies = [p["std_error"] for p in exported["base_parameters"]]
    assert sent_bodies == pytest.approx(bodies)

    ask("model", "report", "m1", "--out", str(folder / "m.html"))
    for file in (page, folder / "m.html"):
        text = re.sub(r"<[^>]+>", " ", Path(file).read_text(encoding="utf-8"))
        assert all(f"± {error:.2g}" in text for _, error in says.values())
