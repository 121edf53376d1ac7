"""How the story goes on by what is found, told by a daemon of paper; and that it admits errors."""

from __future__ import annotations

import pytest

from pa10d.common.jsonable import parsed
from pa10d.demo.hidden import Hidden
from pa10d.demo.story import play
from pa10d.demo.truth import judged, verdict_on
from pa10d.investigation.results import NamedEffect, Structured

RIVAL = {"effect": "stribeck", "joints": [4], "why": "both at reversals"}


def finding(effect="stribeck", joints=(4,), rivals=()):
    return {
        "effect": effect, "joints": list(joints), "confounded_with": list(rivals),
        "next_experiment": None,
        "parameters": {"Fs": {"value": 2.0, "std_error": 0.01, "unit": "N·m"}},
    }  # fmt: skip


def answer(*findings, unexplained=()):
    return {"findings": list(findings), "unexplained": list(unexplained)}


class PaperDaemon:
    """Investigates as a Client does; ``answers`` come one after the other."""

    def __init__(self, *answers):
        self.answers, self.asked = list(answers), []

    def prepare_investigation(self, progress, **asked):
        self.asked.append(asked)
        steps = [
            {"id": "motion-1", "kind": "motion", "title": "Chirp: settles a doubt", "said": "ran",
             "status": "waiting", "purpose": "settle", "experiment": {"kind": "chirp"}},
            {"id": "report", "kind": "report", "title": "Write", "said": "", "status": "waiting",
             "purpose": None, "experiment": None},
        ]  # fmt: skip
        return {"id": f"i{len(self.asked)}", "steps": steps}

    def investigate(self, investigation, progress, news, recover):
        found = self.answers.pop(0)
        verdict = "missing" if found["findings"] else "unknown" if found["unexplained"] else "none"
        question = "changed" if self.asked[-1].get("since") else "missing"
        before, added = [0.5] * 7, bool(found["findings"])
        judged = {"before": before, "after": [0.25] * 7 if added else before}
        steps = self.prepare_investigation(None)["steps"]
        self.asked.pop()
        return {
            **found, "id": investigation, "verdict": verdict, "question": question,
            "model": "m1" if added else "m0", "models": ["m0", "m1"] if added else ["m0"],
            "judged": judged, "noise_floor": [0.1] * 7, "rms": before, "frozen": False,
            "steps": [{**step, "status": "done"} for step in steps],
        }  # fmt: skip


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


def test_what_is_missing_is_found_on_the_first_day():
    story, words, passed = told(PaperDaemon(answer(finding())), HIDDEN)
    found = story.document()
    assert (passed, found["right"], found["found"], found["joint"]) == (0, True, "stribeck", 4)
    assert found["models"] == ["m0", "m1"]
    assert found["rms_after"][3] == pytest.approx(0.5 * found["rms_before"][3])
    assert [step["experiment"]["kind"] for step in found["experiments"]] == ["chirp"]
    before, after = words.split("Now the simulator tells")
    assert "Chirp: settles a doubt. ran" in before
    assert "2.03" not in before
    assert "Fs = 2.03" in after


def test_where_nothing_is_missing_the_story_asks_what_changed():
    client = PaperDaemon(answer(), answer(finding("payload", ())))
    story, _, passed = told(client, PAYLOAD)
    assert passed == 1
    assert client.asked == [{}, {"since": "m0"}]
    assert story.document()["right"] is True
    assert story.document()["frozen"] is True


def test_a_clean_arm_is_asked_both_questions():
    story, words, _ = told(PaperDaemon(answer(), answer()), Hidden())
    found = story.document()
    assert (found["hidden"], found["found"], found["right"]) == (None, None, True)
    assert found["rms_before"] == found["rms_after"]
    assert "right to find nothing" in words


def test_nobody_changes_the_arm_that_somebody_else_simulates():
    story, words, passed = told(PaperDaemon(answer()), Hidden(foreign=True))
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
        (HIDDEN, [finding("presliding_hysteresis", rivals=[RIVAL])], [], False,
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
    findings = [parsed(NamedEffect, one) for one in findings]
    unexplained = [parsed(Structured, one) for one in unexplained]
    assert judged(hidden, findings, unexplained) is right
    assert says in verdict_on(hidden, findings, unexplained)
