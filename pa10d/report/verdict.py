"""A diagnosis in a sentence or two, for somebody who has not asked for figures yet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pa10d.common.words import joint_words, listed, percent, rounded, times
from pa10d.diagnose.outcome.diagnosis import Diagnosis, Finding
from pa10d.diagnose.outcome.words import none_found, unexplained
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.claims import Unexplained, Unnamed
from pa10d.diagnose.unknown.geometry import OtherGeometry
from pa10d.diagnose.unknown.rubbing import OtherFriction
from pa10d.effects import Effect
from pa10d.figures.of_diagnosis import shown_joint
from pa10d.figures.structure_map import variable_words

NEAR = 1.15  # times the noise floor: as good as its own error


def headline(found: Diagnosis) -> str:
    """The verdict, how far the error falls with what was found, and what doubt is left."""
    parts = [answer(found)]
    if found.findings:
        parts += [gain_words(found), doubt_words(found)]
    return " ".join(part for part in parts if part)


def doubt_words(found: Diagnosis) -> str:
    """Whether this data can tell what was found from everything else; empty where it can."""
    doubtful = [finding for finding in found.findings if finding.confounded_with]
    if not doubtful:
        return ""
    settled = sum(finding.next_experiment is not None for finding in doubtful)
    which = "it" if len(found.findings) == 1 else "them"
    if len(doubtful) < len(found.findings):
        which = f"{len(doubtful)} of them"
    text = f"This data alone cannot tell {which} from every other explanation"
    if not settled:
        return f"{text}."
    where = f"for {settled} of these " if settled < len(doubtful) else ""
    return f"{text}; {where}there is an experiment that would."


def answer(found: Diagnosis, sizes: str = "") -> str:
    """The verdict alone. sizes: what is said of them behind the names of what was found."""
    if found.verdict == "none":
        return none_found(found)
    if found.verdict == "unknown":
        return f"{unexplained(found)}: {listed(_places(found.unexplained))}."
    came, missing = (
        listed([finding_words(f, found.frozen) for f in found.findings if bool(f.was_there) is it])
        for it in (False, True)
    )
    verb = "What changed" if found.frozen else "Missing in the model"
    told = [f"{verb}: {came}"] if came else []
    told += [f"Missing, and not changed: {missing}"] if missing else []
    text = f"{'. '.join(told)}.{sizes}"
    if found.unexplained:
        text += " Something besides is left that no effect of the library explains."
    return text


def _places(all_of_it: Sequence[Unexplained]) -> list[str]:
    """``structure_words`` of each; joints that say the same between runs say it once."""
    if all(isinstance(s, Apart) for s in all_of_it):
        same: dict[str, list[int]] = {}
        for s in all_of_it:
            same.setdefault(s.words if isinstance(s, Apart) else "", []).append(s.joint)
        return [f"{joint_words(joints)} {words}" for words, joints in same.items()]
    return [structure_words(s) for s in all_of_it]


def finding_words(finding: Finding, frozen: bool) -> str:
    """``Stribeck friction in joint 4``; frozen: ``less Coulomb friction in joint 4``."""
    kind = finding.term.effect
    return f"{more_or_less(kind, finding.term.coefficients[0], frozen)}{place(finding)}"


def more_or_less(kind: Effect, change: float, frozen: bool) -> str:
    """The title; of what every model has, a frozen one lacks some or has some too much."""
    if not (frozen and kind.question == "textbook"):
        return kind.title
    return f"{'more' if change > 0 else 'less'} {kind.named}"


def place(finding: Finding) -> str:
    """`` in joint 4``, `` between joints 5 and 6``, or nothing where it is of the whole arm."""
    return place_words([j + 1 for j in finding.term.joints])


def place_words(joints: Sequence[int]) -> str:
    """The same of joints numbered from 1."""
    if not joints:
        return ""
    named = " and ".join(map(str, joints))
    return f" in joint {named}" if len(joints) == 1 else f" between joints {named}"


def gain_words(found: Diagnosis) -> str:
    """How far the error falls on data not fitted, at the joint where it falls most."""
    first, last = found.findings[0].rms_before, found.findings[-1].rms_after
    j = shown_joint(found, 0)
    floor, unit = float(found.noise_floor[j]), found.model.robot.torque_unit(j)
    text = f"With {'it' if len(found.findings) == 1 else 'them'} the error of joint {j + 1} falls "
    text += f"from {rounded(first[j], 3)} to {rounded(last[j], 3)} {unit} "
    text += "on data that the fit has not seen"
    if np.isfinite(floor) and floor > 0:
        ratio = last[j] / floor
        text += ", down to the noise" if ratio < NEAR else f", {times(ratio)} the noise"
    return text + "."


def removed(finding: Finding, joint: int) -> float:
    """Share of the joint's squared error (0-based) that the effect takes away."""
    before, after = float(finding.rms_before[joint]), float(finding.rms_after[joint])
    return 1.0 - (after / max(before, 1e-300)) ** 2


def structure_words(s: Unexplained) -> str:
    """``38 % of joint 2's squared error depends on position of joint 2 and …``."""
    if isinstance(s, Apart):
        return f"joint {s.joint + 1} {s.words}"
    if isinstance(s, OtherGeometry):
        return f"{percent(s.share)} of joint {s.joint + 1}'s squared error"
    if isinstance(s, Unnamed) and s.witness == "step":
        return f"{percent(s.share)} of joint {s.joint + 1}'s squared error is {s.step_words}"
    if isinstance(s, OtherFriction):
        return f"{percent(s.share)} of joint {s.joint + 1}'s squared error is {s.words}"
    if not s.variables:
        share = percent(min(s.share, 1.0))
        return f"{share} of joint {s.joint + 1}'s squared error is more than the noise seen here"
    named = " and the ".join(variable_words(name) for name in s.variables)
    return f"{percent(s.share)} of joint {s.joint + 1}'s squared error depends on the {named}"
