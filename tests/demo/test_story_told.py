"""How the story goes on by what is found, told by a daemon of paper; and that it admits errors."""

from __future__ import annotations

import pytest

from pa10d.common.errors import UserError
from pa10d.demo.hidden import Hidden
from pa10d.demo.report import write_report
from pa10d.demo.story import play
from pa10d.demo.truth import judged, verdict_on
from pa10d.services.doubts import new_plan

PLAN = {"kind": "velocity_sweep", "parameters": {"joints": [4]}, "about": {"expected": 9.0}}
RIVAL = {"effect": "presliding_hysteresis", "joints": [4], "why": "both at reversals"}
SHEET = {"sections": [{"block": "section", "title": "Verdict", "blocks": []}], "findings": []}


def finding(effect="stribeck", joints=(4,), rivals=(), plan=None):
    return {
        "effect": effect, "joints": list(joints), "confounded_with": list(rivals),
        "next_experiment": plan,
        "parameters": {"Fs": {"value": 2.0, "std_error": 0.01, "unit": "N·m"}},
    }  # fmt: skip


def diagnosis(*findings, unexplained=(), frozen=False):
    verdict = "missing" if findings else "unknown" if unexplained else "none"
    return {
        "verdict": verdict, "findings": list(findings), "unexplained": list(unexplained),
        "frozen": frozen, "noise_floor": [0.1] * 7, "rms": [0.2] * 7,
    }  # fmt: skip


class PaperDaemon:
    """Answers as a Client does; ``diagnoses`` come one after the other."""

    def __init__(self, *diagnoses, refuses=()):
        self.diagnoses, self.refuses = list(diagnoses), refuses
        self.asked, self.plans, self.added, self.compared = [], [], [], []

    def experiment(self, plan, progress):
        if plan["kind"] in self.refuses:
            raise UserError("the pre-check refused the motion")
        self.plans.append(plan)
        return {"runs": [f"run{len(self.plans)}"], "recorded": [{"duration": 30.0}]}

    def identify(self, runs, name, progress, replace):
        self.identified = name, list(runs)

    def compare(self, model, runs, progress):
        self.compared.append((model, list(runs)))
        names = ["demo7-m0", *dict.fromkeys([*self.added, model])]
        history = [{"model": m, "rms": [0.5 / (k + 1)] * 7} for k, m in enumerate(names)]
        pooled = {"rms": [0.5] * 7, "noise_floor": [0.1] * 7, "where": []}
        return {"history": history, "pooled": pooled}

    def start(self, path, body):
        assert path == "diagnoses"
        self.asked.append({**body, "fit": list(body["fit"]), "validate": list(body["validate"])})
        return {"id": "j"}

    def wait(self, job, progress):
        return {"result": self.diagnoses.pop(0)}

    def sheet(self, job):
        return SHEET

    def add(self, model, effect, joints, fit, name, progress, replace):
        self.added.append(name)


class PaperBench:
    def __init__(self, client):
        self.client, self.passed = client, 0

    def time_passes(self):
        self.passed += 1


def told(client, hidden):
    bench, lines = PaperBench(client), []
    story = play(bench, hidden, 7, lines.append, lambda share, what: None)
    return story, " ".join(lines), bench.passed


HIDDEN = Hidden(({"effect": "stribeck", "joint": 4, "Fs": 2.03},))
PAYLOAD = Hidden(({"effect": "payload", "mass": 2.5},))


def test_what_is_missing_is_found_on_the_first_day(tmp_path):
    client = PaperDaemon(diagnosis(finding()))
    story, words, passed = told(client, HIDDEN)
    answer = story.document()
    assert (passed, answer["right"], answer["found"], answer["joint"]) == (0, True, "stribeck", 4)
    assert answer["models"] == ["demo7-m0", "demo7-m1"]
    assert answer["rms_after"][3] == pytest.approx(0.5 * answer["rms_before"][3])
    before, after = words.split("Now the simulator tells")
    assert "2.03" not in before
    assert "Fs = 2.03" in after
    text = write_report(story, "pa10-sim", tmp_path / "report.html").read_text()
    assert "Fs = 2.03" in text
    assert "The diagnosis was right." in text


def test_where_nothing_is_missing_the_story_asks_what_changed():
    client = PaperDaemon(diagnosis(), diagnosis(finding("payload", ()), frozen=True))
    story, words, passed = told(client, PAYLOAD)
    assert passed == 1
    assert [ask["frozen"] for ask in client.asked] == [False, True]
    assert client.asked[1]["model"] == client.identified[0]
    assert not set(client.asked[1]["fit"]) & set(client.asked[0]["fit"])
    assert story.document()["right"] is True
    assert "What changed: " in words


def test_a_clean_arm_is_asked_both_questions():
    story, words, _ = told(PaperDaemon(diagnosis(), diagnosis(frozen=True)), Hidden())
    answer = story.document()
    assert (answer["hidden"], answer["found"], answer["right"]) == (None, None, True)
    assert answer["rms_before"] == answer["rms_after"]
    assert "right to find nothing" in words


def test_a_doubt_is_settled_by_the_experiment_that_the_diagnosis_asks_for():
    doubtful = diagnosis(finding(rivals=[RIVAL], plan=PLAN))
    client = PaperDaemon(doubtful, diagnosis(finding()))
    story, words, _ = told(client, HIDDEN)
    assert client.plans[-1] == PLAN, "as it stands"
    new = f"run{len(client.plans)}"
    assert new in client.asked[1]["fit"]
    assert new in client.asked[1]["validate"]
    assert new not in client.compared[-1][1], "the last word is with runs that no fit has seen"
    assert [e["plan"] for e in story.document()["experiments"]] == [PLAN]
    assert "could also be" in words


def test_the_same_experiment_is_not_run_twice():
    doubtful = diagnosis(finding(rivals=[RIVAL], plan=PLAN))
    client = PaperDaemon(doubtful, doubtful)
    told(client, HIDDEN)
    assert client.plans.count(PLAN) == 1
    assert not client.diagnoses


def test_an_experiment_that_the_arm_cannot_run_ends_the_doubt_not_the_story():
    client = PaperDaemon(diagnosis(finding(rivals=[RIVAL], plan=PLAN)), refuses=("velocity_sweep",))
    story, words, _ = told(client, HIDDEN)
    assert "could not be run: the pre-check refused" in words
    assert story.document()["found"] == "stribeck"


def test_nobody_changes_the_arm_that_somebody_else_simulates():
    story, words, passed = told(PaperDaemon(diagnosis()), Hidden(foreign=True))
    assert passed == 0
    assert story.document()["hidden"] is None
    assert story.document()["right"] is None
    assert "known to whoever wrote it" in words


LEFT = {"joint": 2, "depends_on": ["q2"], "share": 0.4}


@pytest.mark.parametrize(
    ("hidden", "findings", "unexplained", "right", "says"),
    [
        (HIDDEN, [finding()], [], True, "was right."),
        (HIDDEN, [finding(), finding("spring", (2,))], [], True, "1 more, which are not there"),
        (HIDDEN, [finding(), finding()], [], True, "was right."),
        (HIDDEN, [finding(joints=(3,))], [], False, "wrong: it named"),
        (HIDDEN, [finding("spring"), finding()], [], False, "half right"),
        (HIDDEN, [], [], False, "nothing that it has a name for"),
        (HIDDEN, [finding("presliding_hysteresis", rivals=[finding()])], [], False,
         "cannot tell the two apart"),
        (Hidden(), [], [], True, "right to find nothing"),
        (Hidden(), [finding()], [], False, "wrong"),
        (Hidden(), [], [LEFT], False, "wrong"),
        (Hidden(({"effect": "windage", "joint": 2},)), [], [LEFT], True, "named the joint"),
        (Hidden(({"effect": "windage", "joint": 3},)), [], [LEFT], False, "wrong"),
        (Hidden(foreign=True), [finding()], [], None, "whoever wrote it"),
    ],
)  # fmt: skip
def test_the_answer_is_held_against_the_truth(hidden, findings, unexplained, right, says):
    assert judged(hidden, findings, unexplained) is right
    assert says in verdict_on(hidden, findings, unexplained)


def test_a_plan_is_known_by_what_it_does_not_by_what_is_said_about_it():
    again = {**PLAN, "about": {"expected": 3.0}}
    doubt = finding(plan=again)
    assert new_plan([finding(), doubt], []) is doubt
    assert new_plan([finding(), doubt], [PLAN]) is None
