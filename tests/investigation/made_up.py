"""Investigations whose motions and answers are made up: nothing moves, nothing is computed."""

from __future__ import annotations

from pa10d.investigation import course
from pa10d.investigation.results import StepOutcome
from pa10d.investigation.state import ArmMotion, Investigation

NONE = {
    "verdict": "none", "rms": [0.1], "noise_floor": [0.1], "cutoff_hz": 10.0, "mask": "all",
    "findings": [], "unexplained": [], "remaining": [], "frozen": False,
}  # fmt: skip


def motion(purpose: str, seconds: float, kind: str = "excitation", seed: int = 1) -> ArmMotion:
    return ArmMotion(purpose=purpose, kind=kind, parameters={"seed": seed}, seconds=seconds)


SET = [
    motion("joints", 60.0, "first_motion"),
    motion("fit", 30.0, seed=1),
    motion("fit", 40.0, seed=2),
    motion("judge", 45.0, "point_to_point", 7),
    motion("judge", 30.0, seed=9),
    motion("fresh", 45.0, "point_to_point", 17),
]


def finding(plan=None, seconds=50.0):
    found = {
        "effect": "stribeck", "joints": [4], "p_value": 1e-9, "sentence": "s",
        "parameters": {"Fs": {"value": 2.0, "std_error": 0.01, "unit": "N·m"}},
        "rms_before": [0.3], "rms_after": [0.1], "next_experiment": plan,
        "confounded_with": [{"effect": "coulomb", "joints": [4], "why": "alike"}] if plan else [],
    }  # fmt: skip
    if plan:
        names = {"plan": "1-x.yaml", "motion": "1-x.csv", "problem": ""}
        found["settling"] = {"seconds": seconds, "says": "it could be another", **names}
    return found


def answer(*findings):
    return {**NONE, "verdict": "missing" if findings else "none", "findings": list(findings)}


def investigation(minutes=None, motions=SET, question="missing", **more) -> Investigation:
    steps = course.first_steps([(m, "") for m in motions], question, minutes)
    given = {"id": "20260101-000000000-abcdef", "name": "look", "created": "2026-01-01"}
    given |= {"profile": "arm.yaml", "robot": "arm", "question": question, "moves": bool(motions)}
    return Investigation(**(given | {"minutes": minutes, "steps": steps} | more))


def walk(state: Investigation, *answers: dict) -> list[str]:
    """Carry out all steps; the searches answer one after the other. Ids in their order."""
    left, made = list(answers), []
    while (step := course.next_step(state)) is not None:
        course.begun(state, step)
        outcome: dict = {"said": f"{step.id} is done"}
        if step.kind == "motion":
            outcome |= {"runs": [f"run-of-{step.id}"], "moved": step.motion.seconds}
        if step.kind == "identify":
            outcome |= {"models": ["look-m0"]}
        if step.kind == "add":
            outcome |= {"models": ["look-m1"]}
        if step.kind == "diagnose":
            outcome |= {"result": left.pop(0)}
        course.done(state, step, StepOutcome(**outcome))
        made.append(step.id)
    return made
