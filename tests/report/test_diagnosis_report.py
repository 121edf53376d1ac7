"""The report of a diagnosis: its figures are those of the diagnosis, and a person can follow it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import figure_reader as reader
import numpy as np
import pytest

from backends.virtual.datasets import make_runs
from pa10d.api.schemas.sheets import Sheet as SheetSchema
from pa10d.cli.diagnose import in_words
from pa10d.common.errors import UserError
from pa10d.diagnose.outcome.diagnosis import Confusion, Diagnosis
from pa10d.diagnose.outcome.settling import NextExperiment
from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import robot_from_profile
from pa10d.effects import all_effects
from pa10d.figures.held_out import HeldOut, held_out
from pa10d.figures.of_diagnosis import diagnosis_figures, steps_of
from pa10d.figures.structure_map import variable_label
from pa10d.figures.views import QUANTITIES
from pa10d.identify.procedure import identify
from pa10d.model import ModelNotes
from pa10d.model.notes import CutoffNote
from pa10d.profile import load_profile
from pa10d.report.blocks import Cards, Numbers, Section, Text
from pa10d.report.diagnosis_page import diagnosis_page, diagnosis_sections
from pa10d.report.finding_section import Asked
from pa10d.report.notebook import improvement_page
from pa10d.report.sheet import Sheet, diagnosis_sheet, without_commands
from pa10d.report.verdict import doubt_words, headline

STRIBECK = {"effect": "stribeck", "joint": 4, "Fs": 3.5, "vs": 0.08, "delta": 1.0}
CROSSED = {"effect": "cross_friction", "joints": [5, 6], "amplitude": 0.43, "cycles": 0.8}
ASKED = Asked("arm", ["train_a"], ["valid_a"], "arm.yaml")
PLAN = NextExperiment("velocity_sweep", {"joints": [4]}, apart=41.0)


def diagnosed(hidden, seconds=16.0, **options):
    robot = robot_from_profile(load_profile("pa10-sim"))
    runs = make_runs(3, [hidden], kinds=("train_a", "valid_a"), seconds=seconds)[0]
    fit, validate = [runs["train_a"]], [runs["valid_a"]]
    model = identify(fit, robot, name="arm", cutoff=10.0)
    found = diagnose(model, fit, validate, **options)
    return found, held_out(found), runs


@pytest.fixture(scope="module")
def stribeck():
    return diagnosed(STRIBECK, only=("stribeck", [3]))


@pytest.fixture(scope="module")
def crossed():
    return diagnosed(CROSSED, seconds=40.0, steps=0)


def page_of(found: Diagnosis, seen: HeldOut) -> reader.Report:
    return reader.Report(diagnosis_page(found, seen, ASKED))


def with_floor(found: Diagnosis, values: np.ndarray) -> Diagnosis:
    floor = replace(found.left.floor, values=values)
    return replace(found, left=replace(found.left, floor=floor))


def doubtful(found: Diagnosis) -> Diagnosis:
    why = "both act after a <reversal>"
    finding = replace(
        found.findings[0],
        confounded_with=(Confusion("presliding_hysteresis", (3,), why),),
        next_experiment=PLAN,
    )
    return replace(found, findings=(finding,))


@pytest.mark.long
def test_predictions_of_the_versions_leave_what_the_diagnosis_says(stribeck):
    """Two routes: full prediction of every version here, projected columns there."""
    found, seen, _ = stribeck
    finding = found.findings[0]
    np.testing.assert_allclose(seen.rms(0), finding.rms_before, rtol=1e-6)
    np.testing.assert_allclose(seen.rms(1), finding.rms_after, rtol=1e-6)


@pytest.mark.long
def test_blocks_of_one_run_are_judged_on_the_held_out_ones(stribeck):
    found, _, runs = stribeck
    alone = diagnose(
        replace(found.versions[0], notes=ModelNotes(cutoff=CutoffNote(8.0, "user"))),
        [runs["train_a"]], only=("stribeck", [3]),
    )  # fmt: skip
    seen = held_out(alone)
    np.testing.assert_allclose(seen.rms(0), alone.versions[0].held_out["held out"], rtol=1e-6)
    counted = np.mean([run.counts.mean() for run in seen.seen[0]])
    assert counted < 0.5, "the other blocks were fitted"


def test_what_is_above_the_noise_is_not_called_nothing(stribeck):
    """6 times its noise, which motion does not predict, stood there as "nothing"."""
    found, seen, _ = stribeck
    found = replace(found, unexplained=())

    def said(**first):
        lines = [replace(line, material=False) for line in found.remaining]
        lines[0] = replace(lines[0], **first)
        glance = diagnosis_sections(replace(found, remaining=tuple(lines)), seen, ASKED).verdict
        (cards,) = (block for block in glance.blocks if isinstance(block, Cards))
        return next(card[1:] for card in cards.items if card[0] == "left unexplained")

    assert said(material=False) == ("nothing", "above the noise floor")
    assert said(material=True) == (
        "1 joint",
        "above the noise floor; motion does not predict it",
    )


def test_nothing_is_loaded_from_elsewhere(stribeck):
    page = page_of(*stribeck[:2])
    assert all(link.startswith("#") for link in page.links)
    assert page.open == []
    assert len(set(page.ids)) == len(page.ids)
    assert set(page.canvases) <= set(page.stored)
    for key in page.stored:
        assert page.figure(key)["data"]


def test_a_reader_is_led_from_the_plot_to_the_decision(stribeck):
    found, seen, _ = stribeck
    page = page_of(doubtful(found), seen)
    words = " ".join(page.words)
    kind = all_effects()["stribeck"]
    for text in (kind.meaning, kind.signature, kind.experiment, kind.remedy, kind.equation):
        assert text in words
    assert words.count("How to read this") == len(page.canvases) == 3
    assert "Missing in the model: Stribeck friction in joint 4." in words
    assert "pa10d add arm stribeck --joint 4 --fit train_a --name arm.1" in words
    assert "Pre-sliding hysteresis in joint 4: both act after a <reversal>." in words
    assert PLAN.command in words
    assert "41 standard errors apart" in words
    assert found.judged_on in words


def test_parameters_stand_with_error_and_unit(stribeck):
    found, seen, _ = stribeck
    words = page_of(found, seen).words
    for name, value in found.findings[0].parameters.items():
        at = words.index(name)
        assert words[at + 1] == f"{value.value:.4g}"
        assert words[at + 2] == f"± {value.std_error:.2g}"


def test_the_evidence_shows_the_bump_and_what_is_left(stribeck):
    found, seen, _ = stribeck
    drawn = diagnosis_figures(found, seen)["findings"][0]["evidence"]["residual and effect"]
    cloud, _, curve, rest = drawn["data"][:4]
    assert curve["name"] == "the effect"
    speed, effect = reader.numbers(curve["x"]), reader.numbers(curve["y"])
    # what the textbook friction leaves of a bump: high just above zero speed, low just below
    assert effect[(speed > 0) & (speed < 0.1)].mean() > 0.5
    assert effect[(speed < 0) & (speed > -0.1)].mean() < -0.5
    assert np.all(np.abs(effect[np.abs(speed) > 0.2]) < 0.3)
    nearest = np.argmin(np.abs(reader.numbers(cloud["x"])[:, None] - speed), axis=1)
    away = reader.numbers(cloud["y"]) - effect[nearest]
    assert np.std(away) < 0.4 * np.std(reader.numbers(cloud["y"]))
    assert np.std(reader.numbers(rest["y"])) < 2 * found.noise_floor[3]


def test_the_staircase_falls_beside_the_noise(stribeck):
    found, seen, _ = stribeck
    steps = diagnosis_figures(found, seen)["staircase"]["data"][3]
    given, finding = found.as_given.rms[3], found.findings[0]
    expected = [given, finding.rms_before[3], finding.rms_after[3]]
    np.testing.assert_allclose(steps["y"], np.array(expected) / found.noise_floor[3])


def test_an_unknown_noise_floor_is_called_unknown(stribeck):
    found, seen, _ = stribeck
    unknown = found.left.rms.copy()
    unknown[1] = np.nan
    page = page_of(with_floor(found, unknown), seen)
    assert page.words.count("unknown") == 1
    assert len(page.canvases) == 3


def test_what_changed_is_not_added_but_undone(stribeck):
    found, seen, _ = stribeck
    words = " ".join(page_of(replace(found, frozen=True), seen).words)
    assert "What changed: Stribeck friction in joint 4." in words
    assert "pa10d add" not in words
    assert "pa10d identify train_a --profile arm.yaml" in words


@pytest.mark.parametrize("frozen", [False, True])
def test_every_view_begins_with_the_error_that_the_model_had_as_it_was_given(stribeck, frozen):
    """The terminal said 1.42 N·m, and the page's "as given" 0.14, of the model as it had moved;
    "Promised and achieved" began with 0.432, the verdict with 0.442 of the model refitted."""
    found, seen, _ = stribeck
    given = 3.0 * found.rms
    first = given if frozen else found.rms
    kept = replace(found, frozen=frozen, rms=first, as_given=replace(found.as_given, rms=given))
    told = f"{given[3]:.4g}"
    views = [page_of(kept, seen).words, in_words(kept).split()]
    if not frozen:
        improved = improvement_page(kept, ["m0", "m1"], found.left.rms, seen, ASKED)
        views.append(reader.Report(improved).words)
    for words in views:
        assert told in words
        assert frozen or words.index(told) < words.index(f"{found.rms[3]:.4g}")
    assert [stair.rms[3] for stair in steps_of(kept)][:2] == [
        given[3],
        found.findings[0].rms_after[3] if frozen else found.rms[3],
    ]


def test_what_was_there_before_is_called_missing(stribeck):
    found, seen, _ = stribeck
    there = tuple(replace(f, was_there=True) for f in found.findings)
    kept = replace(found, frozen=True, findings=there)
    words = " ".join(page_of(kept, seen).words)
    assert "Missing, and not changed: Stribeck friction in joint 4." in words
    assert "pa10d add" in words
    assert in_words(kept).startswith("Missing, not changed:")


def test_nothing_missing_is_said_plainly(stribeck):
    found, seen, _ = stribeck
    bare = replace(found, verdict="none", findings=(), versions=found.versions[:1], only="")
    clean = with_floor(replace(bare, left=replace(found.left, rms=found.rms)), found.rms)
    page = page_of(clean, seen)
    assert headline(clean) in page.words
    assert "measurement noise" in headline(clean)
    assert page.canvases == []


@pytest.mark.long
def test_unexplained_structure_is_a_map_of_the_residual(crossed):
    found, seen, _ = crossed
    at = [k for k, s in enumerate(found.unexplained) if s.joint == 4]
    assert at, "friction of joint 5 that follows joint 6 leaves a map"
    s = found.unexplained[at[0]]
    figure = diagnosis_figures(found, seen)["unexplained"][at[0]]
    learnt, shown = (np.array(t["z"], dtype=float) for t in figure["data"])
    np.testing.assert_allclose(learnt, s.values.T, atol=1e-6)
    # the held-out residual has the sign of the map where both say something
    x, y = (reader.numbers(figure["data"][1][k]) for k in "xy")
    cells = np.array([[np.interp(v, s.grid[0], np.arange(len(s.grid[0]))) for v in x]]).T.round()
    rows = np.interp(y, s.grid[1], np.arange(len(s.grid[1]))).round()
    expected = s.values[cells.astype(int), rows.astype(int)].T
    strong = np.isfinite(shown) & (np.abs(expected) > 0.5 * np.abs(s.values).max())
    assert np.mean(np.sign(shown[strong]) == np.sign(expected[strong])) > 0.9
    words = " ".join(page_of(found, seen).words)
    assert "no effect of the library explains" in words
    assert "of joint 5's squared error depends on the" in words


def test_variables_are_named_in_words():
    prismatic = np.array([False, True])
    assert variable_label("dq1", prismatic) == "velocity of joint 1, rad/s"
    assert variable_label("q2 0.4 s ago", prismatic) == "position of joint 2 about 0.4 s ago, m"
    assert variable_label("ddq2", prismatic) == "acceleration of joint 2, m/s²"
    assert variable_label("moving2", prismatic) == "time since the last rest of joint 2, s"


def test_clients_are_told_every_field_of_a_sheet(stribeck):
    made = json.loads(json.dumps(diagnosis_sheet(*stribeck[:2], ASKED).document()))
    told = SheetSchema.model_validate(made)
    assert told.model_dump(mode="json", exclude_unset=True) == made


def test_a_sheet_of_another_version_is_read():
    """What it has beyond ours is passed over, what ours has beyond it is as usual."""
    block = {"block": "text", "text": "as it was", "since": 3}
    section = {"block": "section", "title": "Then", "blocks": [block]}
    (read,) = Sheet.read({"sections": [section], "later": 1}).in_order
    assert read == Section("Then", [Text("as it was")])


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ([], "no 'sections'"),
        ({"sections": {"block": "text", "text": ""}}, "sections: found no list"),
        ({"sections": [{"block": "poem"}]}, "block: found 'poem', expected one of"),
        ({"sections": [{"block": ["text"]}]}, "block: found"),
        ({"sections": [{"block": "section", "blocks": []}]}, "block section: no title"),
    ],
)
def test_what_is_no_sheet_is_said(document, said):
    with pytest.raises(UserError, match=re.escape(said)):
        Sheet.read(document)


def test_every_effect_has_a_view():
    for kind in all_effects().values():
        assert kind.drawn.against in {"", *QUANTITIES}, kind.id


def test_a_sheet_becomes_the_same_report_again(stribeck):
    """What travels by HTTP is all there is to the report."""
    parts = diagnosis_sections(*stribeck[:2], ASKED)
    made = diagnosis_sheet(*stribeck[:2], ASKED).document()
    sheet = Sheet.read(json.loads(json.dumps(made)))
    there, back = Numbers(), Numbers()
    own = [section.render(there) for section in (parts.verdict, *parts.findings, *parts.rest)]
    assert [section.render(back) for section in sheet.in_order] == own
    done = "".join(without_commands(section).render(back) for section in sheet.in_order)
    assert "pa10d add" in "".join(own)
    assert "pa10d" not in done
    assert done.count("<figure") == "".join(own).count("<figure")


@pytest.mark.parametrize(
    ("doubts", "said"),
    [
        ("-", ""),
        ("?", "cannot tell it from every other explanation."),
        ("!", "cannot tell it from every other explanation; there is an experiment that would."),
        ("??", "cannot tell them from every other explanation."),
        ("-!", "cannot tell 1 of them from every other explanation; there is an experiment"),
        ("-?!", "cannot tell 2 of them from every other explanation; for 1 of these there is"),
    ],
)
def test_a_doubt_says_of_how_many_findings_it_is(doubts, said):
    """-: told from everything; ?: not; !: not, and an experiment would."""
    findings = [
        SimpleNamespace(confounded_with=one != "-", next_experiment="chirp" if one == "!" else None)
        for one in doubts
    ]
    words = doubt_words(SimpleNamespace(findings=findings))
    assert said in words
    assert bool(words) == bool(said)
