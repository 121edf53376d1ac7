"""Chapter 3 of Vuong & Ang (2009) on the virtual arm, joints 1-4, over the daemon."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from pa10d.paper.results import CaseStudy


def carry_out(
    data: Path,
    report: Path,
    *,
    seed: int,
    quick: bool,
    tell: Callable[[str], None],
    progress: Callable[[float, str], None],
) -> CaseStudy:
    """The whole study with a laboratory of its own; runs and models go to ``data``, the HTML report
    to ``report``. tell: a line of the story; progress: within a step."""
    from pa10d.case_study.arm import hidden_friction, with_secret, write_profile
    from pa10d.case_study.laboratory import laboratory
    from pa10d.case_study.scope import QUICK, WHOLE
    from pa10d.case_study.study import case_study
    from pa10d.report.case_study_page import case_study_page
    from pa10d.services.library import open_library
    from pa10d.services.models import write_file

    scope = QUICK if quick else WHOLE
    profile = write_profile(data / "profiles")
    hidden = hidden_friction(seed, profile, scope.hidden)
    with laboratory(profile, with_secret(profile, seed, hidden), data) as lab:
        found = case_study(
            open_library(data), profile, lab, scope=scope, seed=seed, hidden=hidden,
            tell=tell, progress=progress,
        )  # fmt: skip
    write_file(report, case_study_page(found))
    return found
