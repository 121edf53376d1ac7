"""What does not fit into memory is said before it is read, with what would fit."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pa10d.common.errors import UserError
from pa10d.services import diagnoses, memory, models

MINUTES = 60
GB = 1_000_000_000


def run(name, minutes=MINUTES):
    return SimpleNamespace(
        id=name, samples=minutes * 60_000, joints=tuple("abcdefg"), duration=minutes * 60.0
    )


@pytest.fixture
def free(monkeypatch):
    def set_to(size):
        monkeypatch.setattr(memory, "free_memory", lambda: int(size))

    return set_to


def test_two_hours_are_too_much_for_a_diagnosis_and_little_for_a_comparison(free):
    free(8 * GB)
    hours = [run("monday"), run("friday")]
    said = r"diagnose: 120 min .* need about 20\.5 GB .* 8\.0 GB are free; .* 46 min of such"
    with pytest.raises(UserError, match=said):
        memory.refuse_beyond_memory("diagnose", hours)
    memory.refuse_beyond_memory("compare", hours)
    memory.refuse_beyond_memory("diagnose", [run("short", 20), run("short", 20)])


def test_nobody_looks_at_a_crowded_machine_for_something_small(free):
    free(1)
    memory.refuse_beyond_memory("diagnose", [run("train", 5)])
    with pytest.raises(UserError, match=r"expected fewer or shorter ones, 0 min of such"):
        memory.refuse_beyond_memory("diagnose", [run("train", 60)])


def test_what_is_free_is_a_number_of_bytes():
    assert 0 < memory.free_memory() < 1 << 50


@pytest.mark.parametrize("asked", ["compare", "diagnose", "add"])
def test_the_services_ask_before_they_read(free, monkeypatch, asked):
    free(3 * GB)
    shelf = SimpleNamespace(find=run)
    model = SimpleNamespace(robot=SimpleNamespace(n=7))
    store = SimpleNamespace(find=str, load=lambda info: model, refuse_taken=lambda name: None)
    library = SimpleNamespace(runs=shelf, models=store)
    monkeypatch.setattr(diagnoses, "refuse_slips", lambda *slips: None)
    for room in (models, diagnoses):
        monkeypatch.setattr(room, "read_runs", lambda *runs, **how: pytest.fail("it was read"))
    ask = {
        "compare": lambda: models.compare_runs(library, "m0", ["a", "b"]),
        "diagnose": lambda: diagnoses.diagnose_runs(library, "m0", ["a"], ["b"]),
        "add": lambda: diagnoses.add_effect(library, "m0", "any", [1], ["a", "b"], name="m1"),
    }[asked]
    with pytest.raises(UserError, match=r"GB of memory, 3\.0 GB are free"):
        ask()
