"""``pa10d track`` and its table: one motion, many laws, and what is said where they are not one."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from pa10d.cli import main
from pa10d.cli.track import in_words
from pa10d.common.errors import UserError
from pa10d.experiments.request import laws_for
from pa10d.services.documents import SCHEMAS
from pa10d.services.tracking import Moved, as_csv, compared
from pa10d.store.channels import CommandedMotion, Samples
from pa10d.store.run_reader import StoredRun

JOINTS = ("shoulder", "elbow")
OFF = {"pid": 4.0, "feed_forward m0": 2.0, "feed_forward m1": 0.5,
       "computed_torque m0": 1.0, "computed_torque m1": 0.8}  # mrad of the elbow  # fmt: skip


def moved(off, scale=1.0):
    """A run whose elbow is off by so many mrad, its shoulder by a tenth of that."""
    t = np.arange(200)
    wanted = scale * np.sin(t / 30.0)[:, None] * np.ones(2)
    error = 1e-3 * off * np.where(t % 2, 1.0, -1.0)[:, None] * np.array([0.1, 1.0])
    none = np.zeros_like(wanted)
    sent = CommandedMotion(wanted, none, none)
    samples = Samples(t * 2_000_000, wanted - error, none, commands=sent)
    return StoredRun(JOINTS, samples, 0, {}, True)


def table():
    laws = [
        Moved(law.controller, law.model, f"r{k}", f"id{k}")
        for k, law in enumerate(laws_for(["m0", "m1"]))
    ]
    runs = [moved(OFF[f"{law.controller} {law.model or ''}".strip()]) for law in laws]
    return laws, runs


def test_the_table_has_every_law_and_what_the_last_model_is_worth():
    found = compared(*table()).document()
    assert [(law["controller"], law["model"]) for law in found["laws"]] == [
        ("pid", None), ("feed_forward", "m0"), ("feed_forward", "m1"),
        ("computed_torque", "m0"), ("computed_torque", "m1"),
    ]  # fmt: skip
    assert [law["rms"][1] for law in found["laws"]] == pytest.approx([4e-3, 2e-3, 5e-4, 1e-3, 8e-4])
    assert found["laws"][2]["max"][1] == pytest.approx(5e-4)
    assert found["laws"][2]["of_pid"] == pytest.approx([0.125, 0.125])
    ahead, computed = found["worth"]
    assert (ahead["from"], ahead["to"], ahead["rms"]) == ("m0", "m1", pytest.approx([0.25, 0.25]))
    assert computed["rms"] == pytest.approx([0.8, 0.8])
    document = {**found, "kind": "tracking", "parameters": {}, "runs": []}
    told = SCHEMAS["track"].model_validate(document)
    json.dumps(document, allow_nan=False)
    words = in_words(found)
    assert "PID + feed-forward, m1" in words
    assert "0.5 (0.5)" in words
    assert "m0 joint 2 is off by 0.5 instead of 2 mrad" in words
    rows = as_csv(told).splitlines()
    assert len(rows) == 1 + 5 * 2
    assert rows[4].split(",")[:4] == ["feed_forward", "m0", "elbow", "0.002"]


def test_one_model_alone_has_nothing_to_be_compared_with():
    laws, runs = table()
    found = compared([laws[0], laws[1], laws[3]], [runs[0], runs[1], runs[3]])
    assert found.worth == []


def test_runs_of_different_motions_are_refused():
    laws, runs = table()
    other = [*runs[:4], moved(1.0, scale=0.98)]  # as the servo alone turns less far
    with pytest.raises(UserError, match="run r4: another motion than r0: the servo alone could"):
        compared(laws, other)
    blind = replace(runs[0], samples=replace(runs[0].samples, commands=None))
    with pytest.raises(UserError, match="run r0: no commands in it"):
        compared(laws, [blind, *runs[1:]])


REFUSED = {
    "neither": ([], "expected MODELs of this data, or --hide"),
    "both": (["m0", "--hide", "stribeck:4"], "expected MODELs of this data, or --hide"),
    "a change": (["--hide", "payload"], "it happens to an arm that was good before"),
    "no effect": (["--hide", "nix"], "no such effect"),
    "no model": (["nobody"], "none of this name"),
    "too fast": (["--hide", "stribeck:4", "--set", "period=0.1"], "expected a smaller amplitude"),
    "no kind": (["--hide", "stribeck:4", "--kind", "nix"], "nix"),
}


@pytest.mark.parametrize("case", sorted(REFUSED))
def test_what_is_wrong_is_said_before_anything_moves(case, tmp_path, capsys):
    words, expected = REFUSED[case]
    status = 2 if case in ("neither", "both") else 1
    assert main(["--data", str(tmp_path), "track", *words]) == status
    assert expected in capsys.readouterr().err
