"""Model files: exact both ways, and one clear line where they are broken."""

import re
from dataclasses import fields, replace

import model_examples as examples
import numpy as np
import pytest
import yaml

from pa10d.common.errors import UserError
from pa10d.effects import all_effects
from pa10d.model import Delivery, ModelNotes
from pa10d.model.notes import (
    CutoffNote,
    FeasibleNote,
    GivenNote,
    LeftOutNote,
    Noted,
    PriorNote,
    ShiftNote,
)
from pa10d.store.models import ModelStore


@pytest.fixture
def store(tmp_path):
    return ModelStore(tmp_path)


def same(one, other):
    for key in ("h", "covariance", "noise", "standard"):
        assert np.array_equal(getattr(one, key), getattr(other, key)), key
    assert np.array_equal(one.base.kept, other.base.kept)
    assert np.array_equal(one.base.relations, other.base.relations)
    assert one.base.gap == other.base.gap
    for key in ("cutoff", "shift", "feasible", "runs", "change", "name"):
        assert getattr(one, key) == getattr(other, key), key
    for a, b in zip(one.terms, other.terms, strict=True):
        assert (a.effect_id, a.joints, a.shape) == (b.effect_id, b.joints, b.shape)
        assert a.shape_errors == b.shape_errors
        assert np.array_equal(a.coefficients, b.coefficients)
    for key in ("lower", "upper", "velocity", "effort", "acceleration", "gravity", "parameters"):
        assert np.array_equal(getattr(one.robot, key), getattr(other.robot, key)), key
    assert one.held_out.keys() == other.held_out.keys()
    assert all(np.array_equal(one.held_out[k], other.held_out[k]) for k in one.held_out)


def test_a_model_comes_back_to_the_last_bit(store):
    model = examples.textbook()
    store.save(model)
    again = ModelStore(store.folder.parent).load("m0")
    same(model, again)
    assert again.notes == model.notes
    motion = examples.motion()
    assert np.array_equal(model.predict(motion), again.predict(replace(motion, robot=again.robot)))


WHOLE = ModelNotes(
    condition_number=83.5,
    warnings=("joint 2: weak",),
    cutoff=CutoffNote(8.0, "torque falls to the noise", (7.5, 9.0), (30.0, 31.5)),
    shift=ShiftNote(1.5e-3, 2e-4),
    feasible=FeasibleNote((0.5, 0.25), {"coulomb J1: Fc": 3.0}),
    weights=(0.5, 0.1 + 0.2),
    correlation_s=(0.125, 0.25),
    rank=12,
    open=("Izz1",),
    robust=True,
    faster_than=(0.05, 0.05),
    prior=PriorNote(30.0, (GivenNote("coulomb J1: Fc", 12.0, 2.0),), (None, 0.5)),
    left_out=(LeftOutNote("one", 6.0, 8.0),),
    delivery=Delivery((0.5, 0.5), (0.25, 0.5), (0.25, 0.75), (2,), 8.0, "all samples"),
    judged_on=("valid_a",),
    noise_floor=(0.125, 0.25),
)


def test_all_notes_come_back(store):
    model = replace(examples.textbook(), notes=WHOLE)
    model = replace(model, notes=replace(WHOLE, noise_floor=(0.5,) * model.robot.n))
    assert None not in vars(model.notes).values(), "a note that this test leaves out"
    store.save(model)
    assert ModelStore(store.folder.parent).load("m0").notes == model.notes
    plain = replace(model, name="plain", notes=ModelNotes())
    store.save(plain)
    assert ModelStore(store.folder.parent).load("plain").notes == ModelNotes()


@pytest.mark.parametrize("part", Noted.__subclasses__(), ids=lambda part: part.__name__)
def test_what_nobody_knows_may_be_left_out(part):
    """A note is written without what is None, and has to be read without it."""
    for one in fields(part):
        if str(one.type).endswith("None"):
            assert one.default is None, one.name


def test_a_parameter_that_somebody_knew_comes_back_without_a_share(store):
    notes = ModelNotes(prior=PriorNote(None, (GivenNote("mz1", -0.16, 0.001),), (None, 0.5)))
    store.save(replace(examples.textbook(), notes=notes))
    assert ModelStore(store.folder.parent).load("m0").notes == notes


def _with_notes(store, notes):
    store.save(replace(examples.textbook(), notes=replace(WHOLE, noise_floor=None)))
    (file,) = store.folder.glob("*.yaml")
    head, rest = file.read_text().split("notes:\n", 1)
    file.write_text(head + "notes:\n" + notes + rest[rest.index("covariance:") :])
    return ModelStore(store.folder.parent)


def test_notes_of_other_versions_are_read(store):
    """What an earlier version wrote, and what a later one may write."""
    told = _with_notes(
        store,
        "  condition_number: 12.5\n  cutoff: {hertz: 5.0, chosen_by: user}\n"
        "  open: []\n  delivery:\n    before: [1, 1]\n    promised: [1, 1]\n"
        "    achieved: [1, 1]\n    worse: []\n    cutoff_hz: 5.0\n    of_tomorrow: 1\n"
        "  of_tomorrow: {a: 1}\n",
    ).load("m0")
    assert told.notes == ModelNotes(
        condition_number=12.5, cutoff=CutoffNote(5.0, "user"),
        delivery=Delivery((1.0, 1.0), (1.0, 1.0), (1.0, 1.0), (), 5.0),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("notes", "says"),
    [
        ("  cutoff: 5.0\n", "notes.cutoff: found 5.0, expected a section of keys and values"),
        ("  cutoff: {hertz: wide, chosen_by: user}\n", "hertz: found 'wide', expected a number"),
        ("  delivery: {worse: [one]}\n", "worse.1: found 'one', expected a whole number"),
        ("  open: Izz1\n", "notes.open: found 'Izz1', expected a list"),
    ],
)
def test_a_note_that_is_none_is_one_line(store, notes, says):
    with pytest.raises(UserError) as told:
        _with_notes(store, notes).load("m0")
    assert says in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.by_default(
    "backlash", "coulomb", "payload", "stribeck", "torque_gain", "torque_ripple"
)
@pytest.mark.parametrize("effect_id", sorted(all_effects()))
def test_every_effect_comes_back(store, effect_id):
    store.save(examples.textbook())
    model = examples.with_effects(examples.textbook(), effect_id)
    store.save(model)
    same(model, store.load("m1"))


def test_loads_of_their_own_come_back_and_count(store):
    gap = replace(examples.some_term("backlash"), shape={"b": 0.01})
    model = examples.textbook(terms=(gap,))
    other = replace(model, loads=1.5 * model.h)
    store.save(other)
    again = store.load("m0")
    assert np.array_equal(again.loads, other.loads)
    assert "rotor" not in again.terms[0].shape, "a shape that only some joints have"
    motion = examples.motion()
    assert np.array_equal(other.predict(motion), again.predict(replace(motion, robot=again.robot)))
    # the bodies' own torque is that of h; only the gap looks at the loads
    seen, plain = other.contextualise(motion), model.contextualise(motion)
    thrown = gap.torque(seen) - gap.torque(plain)
    assert np.abs(thrown).max() > 1e-3
    assert other.predict(motion) - model.predict(motion) == pytest.approx(thrown)


def test_the_point_of_linearisation_comes_back(store):
    term = replace(examples.some_term("encoder_offset"), shape={"at": 0.0123})
    model = examples.textbook(terms=(term,))
    store.save(model)
    assert store.load("m0").terms[-1].shape == {"at": 0.0123}


def test_gravity_limits_and_tool_come_back(store):
    tilted = replace(
        examples.ROBOT,
        gravity=np.array([1.0, -2.0, 9.5]),
        velocity=np.array([1.0, np.inf, 3.0, 0.25]),
        parameters=examples.ROBOT.parameters + np.vstack([np.zeros((3, 10)), np.arange(1.0, 11.0)]),
    )
    model = examples.textbook(robot=tilted)
    store.save(model)
    same(model, store.load("m0"))


def test_a_person_can_read_it(store):
    text = store.path(store.save(examples.textbook())).read_text()
    plain = yaml.safe_load(text)  # any YAML reader will do
    first = plain["base_parameters"][0]
    assert set(first) >= {"name", "value", "std_error", "unit"}
    friction = next(e for e in plain["effects"] if e["effect"] == "coulomb" and e["joints"] == [2])
    assert friction["coefficients"]["Fc"]["unit"] == "N·m"
    assert plain["fit"]["runs"] == ["train a", "train b"]
    assert plain["noise_floor"]
    assert plain["held_out"]["valid"]
    assert plain["software"].startswith("pa10d ")
    assert "<joint" in plain["urdf"]
    assert max(map(len, text.splitlines())) < 200


def test_standard_errors_are_the_covariance_s_and_the_torque_constants(store):
    model = examples.textbook()
    plain = yaml.safe_load(store.path(store.save(model)).read_text())
    entries = list(plain["base_parameters"])
    entries += [c for e in plain["effects"] for c in e["coefficients"].values()]
    random = np.sqrt(np.diag(model.covariance))
    gains = [0.05 * e["value"] * (e["unit"] != "1") for e in entries]
    assert [e["std_error"] for e in entries] == pytest.approx(np.hypot(random, gains))


@pytest.mark.parametrize("name", ["true", "1e3", "12", "null", "ä ö", "a: b", "#1", "'x'"])
def test_odd_names_stay_names(store, name):
    store.save(examples.textbook(name))
    assert store.load(name).name == name


def line(pattern, text):
    """Replace by regular expression, once and for sure."""
    find, put = pattern
    changed, count = re.subn(find, put, text, count=1, flags=re.MULTILINE | re.DOTALL)
    assert count == 1, find
    return changed


# Numbers that a computer takes and no arm has.
ABSURD = {
    "value": ((r"value: [-0-9.e]+", "value: 1e308"), "value: found 1e+308, expected a number of"),
    "std_error": ((r"std_error: [-0-9.e]+", "std_error: 1e200"), "std_error: found 1e+200"),
    "plus": ((r"plus: {(\w+): [^,}]*", r"plus: {\1: -1e300"), "found -1e+300, expected"),
    "coefficient": ((r"Fc: {value: [^,]*", "Fc: {value: 1e308"), "Fc.value: found 1e+308"),
    "v0 of zero": (
        (r"v0: {value: [^,]*", "v0: {value: 0.0"),
        "shape.v0.value: found 0, expected 1e-07 to 1000 rad/s",
    ),
    "v0 below zero": ((r"v0: {value: [^,]*", "v0: {value: -1"), "v0.value: found -1, expected"),
    "v0 of nothing": ((r"v0: {value: [^,]*", "v0: {value: 1e-320"), "v0.value: found 9.99989e-321"),
    "v0 too large": ((r"v0: {value: [^,]*", "v0: {value: 1e5"), "v0.value: found 100000"),
    "cut-off of nothing": ((r"cutoff_hz: .*?$", "cutoff_hz: 1e-300"), "expected a frequency in Hz"),
    "cut-off": ((r"cutoff_hz: .*?$", "cutoff_hz: 1e9"), "cutoff_hz: found 1000000000"),
    "shift": ((r"shift_s: .*?$", "shift_s: 1e9"), "shift_s: found 1000000000.0, expected s of a"),
    "structure": ((r"structure: [^\]]*", "structure: [1e308, 1"), "structure.1: found 1e+308"),
    "gravity": ((r"gravity: [^\]]*", "gravity: [0, 0, 1e308"), "no more than 1e+06 m/s²"),
    "rms": ((r"rms: \[[^,]*", "rms: [1e300"), "fit.rms.1: found 1e+300"),
    "standard": ((r"  j1: \[[^,]*", "  j1: [1e308"), "j1.1: found 1e+308"),
    "covariance": (
        (r"data: \|\n    .{10}", "data: |\n    AAAAAAAA8H"),  # infinity, 8 bytes
        "covariance.data: found a number that no error is",
    ),
}

BROKEN = ABSURD | {
    "no YAML": ((r"^fit:", "fit: [1, {"), "expected"),
    "empty": ((r"\A.*\Z", ""), "found an empty file"),
    "a list": ((r"\A.*\Z", "- 1\n- 2\n"), "expected lines 'key: value'"),
    "no text": ((r"^name: m0", "name: \x01"), "expected"),
    "key missing": ((r"^covariance:.*?(?=^urdf)", ""), "covariance: found nothing"),
    "key twice": ((r"^name: m0", "name: m0\nname: m0"), "name: found a second time"),
    "unknown key": ((r"^change:", "chance:"), "chance: found an unknown key"),
    "other format": ((r"^pa10d_model: 1", "pa10d_model: 99"), "pa10d_model: found 99"),
    "not a number": ((r"value: [-0-9.e]+", "value: heavy"), "value: found 'heavy'"),
    "not finite": ((r"value: [-0-9.e]+", "value: .nan"), "expected a finite number"),
    "unknown effect": ((r"effect: viscous", "effect: viscose"), "effect: found viscose"),
    "loads in part": (
        (r"(- \{name: \w+, value: [^\n]*)\}$", r"\1, in_loads: 1.0}"),
        "in_loads: found nothing, expected a value",
    ),
    "coefficient's name": ((r"^    Fv:", "    Fw:"), "coefficients: found Fw, expected Fv"),
    "shape missing": ((r"  shape:\n    v0: [^\n]*\n", ""), "shape: found nothing, expected v0"),
    "joint too high": ((r"joints: \[4\]", "joints: [9]"), "expected 1 of joints 1 to 4"),
    "joint too many": ((r"joints: \[4\]", "joints: [1, 2]"), "expected 1 of joints 1 to 4"),
    "wrong size": ((r"rms: \[[^,]*,", "rms: ["), "rms: found 3 values, expected 4"),
    "limit size": ((r"lower: \[[^,]*,", "lower: ["), "lower: found 3 values, expected 4"),
    "standard size": ((r"  j1: \[[^,]*,", "  j1: ["), "j1: found 9 values, expected 10"),
    "base name": ((r"name: Izz4", "name: Izz5"), "found Izz5, expected a standard parameter"),
    "covariance cut": ((r"(data: \|\n    .{32})[^\n]*", r"\1"), "expected 496, the lower triangle"),
    "covariance no base64": ((r"data: \|\n    ", "data: |\n    ???"), "found what is no base64"),
    "URDF no XML": ((r"<robot name", "<robot <name"), "urdf: URDF: not well-formed XML"),
    "URDF joint": ((r'<joint name="j4"', '<joint name="j9"'), "'j4' is not a movable joint"),
    "URDF link": ((r'<child link="l4"', '<child link="l9"'), "found child link 'l9'"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_file_is_one_line_that_names_it(store, case):
    change, words = BROKEN[case]
    path = store.path(store.save(examples.textbook()))
    text = line(change, path.read_text())
    path.write_text(text)
    fresh = ModelStore(store.folder.parent)
    wanted = "m0" if "name: m0" in text else path.stem
    with pytest.raises(UserError) as error:
        fresh.load(wanted)
    message = str(error.value)
    assert "\n" not in message
    assert str(path) in message
    assert words in message
    assert path.read_text() == text


@pytest.mark.parametrize("number", [".inf", ".nan", "1e308"])
def test_an_absurd_parameter_of_a_controller_is_one_line(store, number):
    feasible = f"  feasible: {{rms: [1, 1, 1, 1], coefficients: {{'coulomb J1: Fc': {number}}}}}\n"
    with pytest.raises(
        UserError, match=r"yaml:\d+: notes\.feasible\.coefficients\.coulomb J1: Fc: "
    ):
        _with_notes(store, feasible).load("m0")


@pytest.mark.parametrize(
    ("end", "wrong"),
    [
        ("joint: 9, level: 1.0", "joint: found 9, expected a joint from 1 to 4"),
        ("joint: 0, level: 1.0", "joint: found 0"),
        ("joint: 1, level: .nan", "level: found nan"),
    ],
)
def test_an_end_of_no_joint_s_torque_is_one_line(store, end, wrong):
    with pytest.raises(UserError, match=r"yaml:\d+: notes\.torque_ends\.1\." + wrong):
        _with_notes(store, f"  torque_ends: [{{{end}, largest: true}}]\n").load("m0")


def test_shapes_well_beyond_what_a_search_looks_at_come_back(store):
    """Another release's bounds were others, and an arm may be of another size."""
    for kind in all_effects().values():
        for shape in kind.shapes:
            low, high = shape.reach
            assert low <= shape.lower <= shape.upper <= high
            assert shape.scale != "log" or 0.0 < low < 0.01 * shape.lower
    far = replace(examples.some_term("stribeck"), shape={"vs": 1e-4, "delta": 3.0})
    store.save(examples.textbook(terms=(far,)))
    assert store.load("m0").terms[-1].shape == far.shape


def test_a_broken_file_does_not_hide_the_others(store):
    bad = store.path(store.save(examples.textbook("bad")))
    store.save(examples.textbook("good"))
    bad.write_bytes(b"\xff\xfe broken")
    fresh = ModelStore(store.folder.parent)
    assert [info.name for info in fresh.all()] == ["good"]
    assert [str(bad)] == [str(model.path) for model in fresh.set_aside()]
    assert fresh.load("good").name == "good"


@pytest.mark.parametrize("left", ["", "- 1\n- 2\n"])
def test_a_file_that_lost_its_name_is_spoken_of_when_a_model_is_missed(store, left):
    path = store.path(store.save(examples.textbook()))
    path.write_text(left)
    with pytest.raises(UserError, match="none of this name") as missed:
        ModelStore(store.folder.parent).find(examples.textbook().name)
    assert str(path) in str(missed.value)
    assert "\n" not in str(missed.value)


def test_what_could_not_be_read_back_is_not_written(store):
    model = replace(examples.textbook(), noise=np.array([0.1, np.nan, 0.1, 0.1]))
    with pytest.raises(UserError, match=r"fit\.rms"):
        store.save(model)
    assert store.all() == []
    assert list(store.folder.glob("*.yaml")) == []
