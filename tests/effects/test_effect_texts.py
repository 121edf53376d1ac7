"""What the classes say about themselves: complete, consistent, and in agreement with EFFECTS.md."""

import re

import pytest

from pa10d.effects import all_effects

EFFECTS = all_effects()
KINDS = {
    "boundary_velocity", "excitation", "tracking", "point_to_point", "velocity_sweep",
    "load_sweep", "reversals", "warm_up", "chirp", "single_joint",
}  # fmt: skip
every = pytest.mark.parametrize("name", sorted(EFFECTS))


@every
def test_says_all_there_is_to_say(name):
    kind = EFFECTS[name]
    for text in (kind.meaning, kind.signature, kind.experiment, kind.remedy):
        assert text[0].isupper()
        assert text[-1] == "."
        assert 20 < len(text) < 480
    for text in (kind.title, kind.equation, kind.source):
        assert text == text.strip() != ""
    assert len(kind.plainly) < 60
    assert not kind.plainly.endswith(".")  # it stands within a sentence
    assert "τ" in kind.equation
    assert re.search(r"\(\d{4}\)", kind.source), "a source has a year"
    assert kind.experiment_kind in KINDS
    assert kind.coefficients


@every
def test_every_parameter_is_in_the_equation_or_explained(name):
    """A person who reads ``zs = 0.004`` in a finding can look up what zs is."""
    kind = EFFECTS[name]
    told = kind.equation + " " + kind.meaning
    for c in (*kind.coefficients, *kind.shapes):
        if getattr(c, "nuisance", False) or name == "payload":
            continue
        symbol = {"delta": "δ", "mu": "μ", "kq0": "q0"}.get(c.name, c.name)
        assert symbol in told, c.name


@every
def test_confusion_is_mutual_and_each_has_a_reason(name):
    kind = EFFECTS[name]
    assert kind.confounders or kind.question == "textbook"
    for other, why in kind.confounders.items():
        assert other in EFFECTS
        assert other != name
        assert name in EFFECTS[other].confounders
        assert len(why) > 15
        assert not why.endswith(".")  # it stands within a sentence


@every
def test_bounds_are_in_order_and_scales_possible(name):
    for c in EFFECTS[name].coefficients:
        assert c.lower < c.upper
    for s in EFFECTS[name].shapes:
        assert s.lower < s.upper
        assert s.scale != "log" or s.lower > 0


@every
def test_the_example_is_one(name):
    kind = EFFECTS[name]
    example = kind.example
    assert len(example.coefficients) == len(kind.coefficients)
    for c, value in zip(kind.coefficients, example.coefficients, strict=True):
        assert c.lower <= value <= c.upper
    shapes = kind.shapes_in(example.shape)
    assert set(example.shape) == {s.name for s in shapes}
    for s in shapes:
        assert s.lower <= example.shape[s.name] <= s.upper


def test_titles_and_files_are_as_the_ids_say():
    assert len({kind.title for kind in EFFECTS.values()}) == len(EFFECTS)
    for name, kind in EFFECTS.items():
        assert kind.id == name
        assert type(kind).__module__.endswith(f".{name}")


def test_the_library_is_the_one_of_the_standard(shared):
    rows = re.findall(
        r"^\| `(\w+)` \| (joint pair|joint|robot) \|.*?\| ([^|]*) \| [^|]* \|$",
        (shared / "EFFECTS.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    assert {row[0] for row in rows} == set(EFFECTS)
    for name, scope, confused in rows:
        kind = EFFECTS[name]
        assert kind.scope == {"joint pair": "pair"}.get(scope, scope)
        named = set(re.findall(r"`(\w+)`", confused))
        assert named <= set(kind.confounders), name
