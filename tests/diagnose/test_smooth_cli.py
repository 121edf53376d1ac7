"""``pa10d add … smooth_map`` and ``improve --smooth``, from what a diagnosis could not explain."""

from __future__ import annotations

import numpy as np
import pytest
from importing import imported
from two_links import CUTOFF, NAMES, recordings

from pa10d.cli import main
from pa10d.cli.diagnose import in_words
from pa10d.services.diagnoses import add_effect, diagnose_runs
from pa10d.services.library import open_library

FIT, VALIDATE = NAMES[:2], NAMES[2:]
SIDES = ["--fit", *FIT, "--validate", *VALIDATE]


def product(t, q, dq, ddq):
    return np.column_stack([0.5 * np.sin(2 * q[:, 0]) * q[:, 1], np.zeros(len(t))])


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Four runs of an arm that hides what is in no library, and its textbook model."""
    store, profile = imported(tmp_path_factory.mktemp("smooth"), recordings(0, product))
    command = ["identify", *FIT, "--profile", profile, "--name", "m0"]
    assert main(["--data", store, *command, "--cutoff", str(CUTOFF)]) == 0
    return store


@pytest.fixture(scope="module")
def diagnosis(data):
    return diagnose_runs(open_library(data), "m0", FIT, VALIDATE)


@pytest.fixture(scope="module")
def unexplained(diagnosis):
    """Its one entry, as a client has it."""
    found = diagnosis.document()
    assert (found["verdict"], found["findings"]) == ("unknown", [])
    (entry,) = found["unexplained"]
    assert (entry["joint"], set(entry["depends_on"])) == (1, {"q1", "q2"})
    return entry


@pytest.mark.long
def test_what_is_unexplained_is_removed_as_it_stands(run, unexplained):
    over = ",".join(unexplained["depends_on"])
    command = ["add", "m0", "smooth_map", "--joint", str(unexplained["joint"]), "--over", over]
    _, made, said = run(*command, "--fit", *FIT, "--name", "mapped")
    assert (made["parent"], made["warnings"]) == ("m0", [])
    assert made["change"].endswith("(removes the error, explains nothing: no physical effect)")
    _, old, _ = run("compare", "m0", *VALIDATE)
    _, new, said = run("compare", "mapped", *VALIDATE)
    before, after, floor = (
        np.array(found["pooled"][key])
        for found, key in ((old, "rms"), (new, "rms"), (new, "noise_floor"))
    )
    assert (before - after)[0] > 0.85 * (before - floor)[0]
    assert after[1] < 1.02 * before[1]
    assert "explains nothing: no physical effect" in new["warnings"][0]
    assert "lies outside the range" in new["warnings"][1]
    assert new["warnings"][0] in said
    _, history, _ = run("model", "history", "mapped")
    assert "explains nothing" in history[-1]["change"]
    _, shown, _ = run("model", "show", "mapped")
    own = [p for p in shown["parameters"] if p["name"].startswith("smooth_map")]
    assert {"explains nothing" in p["meaning"] for p in own} == {True}
    assert {p["name"].split(": ")[1] for p in own} >= {"lowest", "highest", "smoothing"}


@pytest.fixture(scope="module")
def by_service(data, unexplained):
    return add_effect(
        open_library(data), "m0", "smooth_map", [unexplained["joint"]], FIT, name="by-service",
        over=unexplained["depends_on"],
    )  # fmt: skip


@pytest.mark.long
def test_the_service_takes_the_entry_as_well(by_service, unexplained):
    info, model, warnings = by_service
    assert warnings == []
    assert model.terms[-1].over == tuple(unexplained["depends_on"])
    assert info.change.startswith("added smooth_map J1 over ")


@pytest.mark.long
def test_improve_draws_a_map_when_asked_to(run):
    _, smooth, _ = run("improve", "m0", *SIDES, "--smooth", "--name", "smooth")
    (version,) = smooth["versions"]
    assert version["name"] == smooth["name"] == "smooth"
    assert "explains nothing" in version["change"]
    assert version["held_out"][0] < 0.3 * smooth["rms"][0]
    assert smooth["findings"] == [], "it is none"


@pytest.mark.long
def test_improve_draws_none_unless_asked_to_and_with_it_nothing_is_left(run, unexplained):
    _, plain, _ = run("improve", "m0", *SIDES, "--name", "plain")
    assert (plain["versions"], plain["name"]) == ([], None)
    assert plain["unexplained"] == [unexplained]
    over = ",".join(unexplained["depends_on"])
    run("add", "m0", "smooth_map", "--joint", "1", "--over", over, "--fit", *FIT, "--name", "full")
    _, again, _ = run("diagnose", "full", *SIDES)
    assert again["verdict"] == "none"


@pytest.mark.long
def test_words_for_a_person(diagnosis, unexplained):
    over = ",".join(unexplained["depends_on"])
    said = in_words(diagnosis)
    assert "a smooth map removes that part, and explains nothing" in said
    assert f"smooth_map --joint 1 --over '{over}'" in said


ADD = ["--fit", *FIT, "--name", "other"]
REFUSED = {
    "no quantities": (["add", "m0", "smooth_map", "--joint", "1", *ADD], "over nothing: expected"),
    "no joint": (["add", "m0", "smooth_map", "--over", "q1", *ADD], "expected one joint"),
    "unknown": (["add", "m0", "smooth_map", "--joint", "1", "--over", "wind", *ADD], "'wind'"),
    "no such joint": (["add", "m0", "smooth_map", "--joint", "1", "--over", "q9", *ADD], "'q9'"),
    "another effect": (["add", "m0", "spring", "--joint", "1", "--over", "q", *ADD], "smooth_map"),
    "as a suspicion": (["diagnose", "m0", "--effect", "smooth_map", *SIDES], "no suspect"),
    "no temperature": (
        ["add", "m0", "smooth_map", "--joint", "1", "--over", "temperature", *ADD],
        "have no temperature",
    ),
}


@pytest.mark.by_default("no quantities", "no such joint")
@pytest.mark.parametrize("case", REFUSED)
def test_nonsense_is_refused_in_one_line(run, case):
    arguments, expected = REFUSED[case]
    status, _, said = run(*arguments)
    assert status == 1
    assert len([line for line in said.splitlines() if expected in line]) == 1
    assert "Traceback" not in said


@pytest.mark.parametrize("name", ["smooth_map", "dead_band"])
def test_no_first_model_begins_with_what_is_no_effect(run, data, name):
    profile = str(data).removesuffix("data") + "two.yaml"
    status, _, said = run("identify", *FIT, "--with", name, "--profile", profile,
                          "--name", "other")  # fmt: skip
    assert status == 1
    assert f"--with {name}: explains nothing; expected an effect" in said
    assert "add … smooth_map --over" in said


@pytest.mark.long
def test_exports_say_that_the_map_stays_behind(run, by_service, tmp_path):
    out = str(tmp_path / "m.py")
    _, document, _ = run("model", "export", by_service[0].name, "--format", "python", "--out", out)
    assert len(document["not_carried"]) == 1
    assert "a map of what nobody understands" in document["not_carried"][0]
