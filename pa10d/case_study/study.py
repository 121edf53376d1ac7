"""The study itself: every step by the same functions that commands and API call."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from pa10d.case_study.boundary import RUN, find_boundaries
from pa10d.case_study.estimation import estimate, rms_of_sets
from pa10d.case_study.laboratory import Laboratory
from pa10d.case_study.measured import followed, steady
from pa10d.case_study.other import other_motion
from pa10d.case_study.scope import Scope
from pa10d.identify import FitOptions
from pa10d.identify.summary import summary
from pa10d.paper.results import (
    MODEL,
    PID,
    SETS,
    WITH_EFFECTS,
    CaseStudy,
    Following,
    HiddenFriction,
    NamedLack,
)
from pa10d.profile import Profile
from pa10d.report.verdict import answer
from pa10d.services.diagnoses import diagnose_runs, store_versions
from pa10d.services.excitation import excite
from pa10d.services.library import Library
from pa10d.services.models import identify_runs
from pa10d.services.robots import load_robot

Tell = Callable[[str], None]
Progress = Callable[[float, str], None]

EXCITING, OTHER = "exciting", "other"
PACES = {"4s": 4.0, "40s": 40.0}
LONGEST = 120.0  # s for the search, where the machine is busy with something else
BOTH = 0.5  # of the search's criterion is about samples above the boundary, the rest about all


def case_study(
    library: Library,
    profile: Profile,
    lab: Laboratory,
    *,
    scope: Scope,
    seed: int,
    hidden: tuple[HiddenFriction, ...],
    tell: Tell,
    progress: Progress,
) -> CaseStudy:
    """Everything on the arm of ``profile``; hidden: what its simulator knows, told at the end."""
    robot = load_robot(profile.path)[1]
    seconds: dict[str, float] = {}

    @contextmanager
    def step(name: str, words: str) -> Iterator[None]:
        tell(words)
        began = time.monotonic()
        yield
        seconds[name] = round(time.monotonic() - began, 1)

    with step("boundary velocity", "1. From which speed on is friction linear? Each joint swings."):
        limits = find_boundaries(lab, robot.n, scope)
    for one in limits.found:
        tell(f"   {one.sentence}")

    with step("exciting trajectory", "2. Search for a trajectory that excites all parameters."):
        design = excite(
            profile.path, generations=scope.generations, seconds=LONGEST, seed=seed,
            cycles=scope.periods,
            boundary=limits.limit.tolist(), above=BOTH, progress=progress,
        )  # fmt: skip
    tell(f"   Condition number {design.figures.condition_number:.1f}.")

    with step("run it", f"3. Run it for {scope.periods} periods, and another one to judge by."):
        lab.run("excitation", design.request.request()["parameters"], EXCITING)
        other = other_motion(design.problem, scope.other, seed)
        lab.run("excitation", other.request()["parameters"], OTHER)

    with step("estimate", "4. Average, filter and estimate: fast samples (A) and all (B)."):
        found = estimate(
            steady(library, EXCITING), steady(library, OTHER), design.request, robot, limits.limit
        )
        made = identify_runs(
            library, [EXCITING], profile.path, name="set-a",
            options=FitOptions(faster_than=tuple(limits.limit.tolist())),
            replace=True, progress=progress,
        )  # fmt: skip
    for name in SETS:
        rms = " ".join(f"{v:.2f}" for v in found.variants.ours(name).rms)
        tell(f"   set {name}: {rms} N·m on the other trajectory.")

    def sine(pace: str, how: str, model: str | None) -> Following:
        cycles = scope.cycles if pace == "4s" else scope.slow_cycles
        run = f"{pace}-{how}"
        law = PID if model is None else MODEL
        lab.run("tracking", {"period": PACES[pace], "cycles": cycles}, run, law, model)
        return followed(library, run)

    with step("sines", "5. Sines of 4 s and 40 s, PID against computed torque."):
        following = {
            pace: {how: sine(pace, how, model) for how, model in ((PID, None), (MODEL, "set-a"))}
            for pace in PACES
        }

    with step("diagnose", "6. What is missing at low speed? Diagnose the model, and add it."):
        diagnosis = diagnose_runs(
            library, "set-a", [EXCITING, RUN], [OTHER, "40s-pid"], progress=progress
        )
        versions = store_versions(
            library, "set-a", diagnosis, name="with-effects", replace_model=True
        )
    tell(f"   {answer(diagnosis)}")
    last = versions[-1].name if versions else "set-a"

    with step("sines again", "7. The same sines with the completed model in the controller."):
        for pace in PACES:
            following[pace][WITH_EFFECTS] = sine(pace, WITH_EFFECTS, last)

    return CaseStudy(
        seed=seed,
        joints=robot.joint_names,
        hidden=hidden,
        boundaries=limits,
        excitation=design.figures,
        preparation=found.preparation,
        variants=found.variants,
        reconstruction=found.reconstruction,
        slow_rms=rms_of_sets(steady(library, "40s-pid"), found, robot),
        identified=summary(made.model),
        following=following,
        findings=tuple(
            NamedLack(
                one.term.effect_id,
                tuple(j + 1 for j in one.term.joints),
                one.parameters,
                one.rms_before,
                one.rms_after,
                one.p_value,
            )
            for one in diagnosis.findings
        ),
        answer=answer(diagnosis),
        models={"set_a": made.info.id, "with_effects": versions[-1].id if versions else ""},
        seconds=seconds,
    )
