"""Where the study agrees with the paper, where not, and why: in sentences that follow the data."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import joint_words, listed
from pa10d.paper import published
from pa10d.paper.results import MODEL, PID, WITH_EFFECTS, CaseStudy

Array = NDArray[np.float64]

SLOW_SINE = 2 * np.pi / 40.0  # rad/s
ALIKE = 0.8  # of the PID's error, above which a controller is no clear gain


def agreements(found: CaseStudy) -> list[tuple[str, str]]:
    """(tag, sentence): tag is "agrees", "differs" or "adds"."""
    return [
        _boundaries(found),
        _condition(found),
        _parameters(found),
        _sets(found),
        _feasible(found),
        _fast_sines(found),
        _slow_sines(found),
        _completed(found),
    ]


def _boundaries(found: CaseStudy) -> tuple[str, str]:
    seen = [v for v in found.boundaries.values if v > 0]
    if not seen:
        return ("differs", "No joint has a boundary velocity: its friction is linear throughout.")
    by_inertia = sum(one.decided_by == "inertia" for one in found.boundaries.found)
    text = (
        f"Every joint has a speed below which friction is not linear: {min(seen):.2f} to "
        f"{max(seen):.2f} rad/s here, {min(published.BOUNDARY_VELOCITY):g} to "
        f"{max(published.BOUNDARY_VELOCITY):g} on the paper's arm."
        if len(seen) == len(found.joints)
        else f"{len(seen)} of {len(found.joints)} joints have a boundary velocity."
    )
    text += (
        " The paper reads it off the convergence of the inertia; here that decided "
        f"{by_inertia or 'no'} joint{'s' if by_inertia > 1 else ''}, the friction map "
        f"{len(seen) - by_inertia}: an estimate of inertia is blind to friction that depends on "
        "speed alone."
    )
    return ("agrees" if by_inertia == len(seen) else "differs", text)


def _condition(found: CaseStudy) -> tuple[str, str]:
    value = found.excitation.condition_number
    tag = "agrees" if value <= published.CONDITION_NUMBER else "differs"
    return (
        tag,
        f"The trajectory's condition number is {value:.1f}, the paper's was around "
        f"{published.CONDITION_NUMBER:g}. Its columns, units and limits are not stated, so only "
        "the order of magnitude can be compared.",
    )


def _parameters(found: CaseStudy) -> tuple[str, str]:
    count = found.identified.inertial_base_parameters
    return (
        "differs",
        f"The first four links have {count} inertial base parameters by the rank of the regressor, "
        f"all seven 43. The paper's {published.LUMPED_PARAMETERS} lumped parameters for the whole "
        "arm are fewer than the rank allows: those of a simplified model.",
    )


def _sets(found: CaseStudy) -> tuple[str, str]:
    a, b = np.array(found.rms_set_a), np.array(found.rms_set_b)
    better = np.flatnonzero(a <= b)
    paper = [
        j
        for j, (x, y) in enumerate(zip(published.RMS_SET_A, published.RMS_SET_B, strict=True))
        if x <= y
    ]
    share = np.array(found.variants.share_of_samples)
    where = joint_words(better) if len(better) else "no joint"
    return (
        "agrees" if len(better) >= len(paper) else "differs",
        f"Fast samples alone (set A) give the better or an equal model of another trajectory on "
        f"{where}, in the paper on {joint_words(paper)}. The sets hardly differ in size here: "
        "the trajectory was designed with the boundary in its criterion, so that "
        f"{100 * share.min():.0f} to {100 * share.max():.0f} % of its samples are fast (paper: "
        f"about {100 * published.SHARE_OF_SET_A:.0f} %). {_slow_torque(found)}",
    )


def _slow_torque(found: CaseStudy) -> str:
    a, b = (np.array(found.slow_rms[name]) for name in "AB")
    worse = np.flatnonzero(b < a)
    text = "On the sines of 40 s, where no sample is fast, "
    if not len(worse):
        return text + "A is the better one on every joint, too."
    return text + (
        f"B is the better one on {joint_words(worse)}: least squares bends its Coulomb level "
        "towards the friction that neither model has a term for."
    )


def _feasible(found: CaseStudy) -> tuple[str, str]:
    paper, ours = found.variants.sets["A"].ways["penalty"], found.variants.ours("A")
    assert paper.smallest_pseudo_inertia is not None, "the penalty has bodies"
    worst = paper.smallest_pseudo_inertia.min()
    text = (
        "m > 0 and I > 0, the paper's condition, "
        + ("were enough here" if paper.feasible else "do not make a body possible")
        + f" (smallest eigenvalue of a pseudo-inertia: {worst:.2g}). Our condition, a definite "
        "pseudo-inertia of every link, is exact and costs "
        f"{1e3 * ours.seconds:.0f} ms; both problems are convex, so the genetic algorithm and "
        "its initial guess are not needed."
    )
    return ("agrees" if paper.feasible else "differs", text)


def _fast_sines(found: CaseStudy) -> tuple[str, str]:
    share = _ratio(found, "4s", MODEL, PID)
    good = bool(np.all(share < ALIKE))
    return (
        "agrees" if good else "differs",
        f"At 4 s computed torque leaves {_percents(share)} % of the PID's tracking error on "
        f"joints 1 to {len(share)}, with the same feedback. In the paper joint 3 gained least, and "
        "it asks for motions that excite the joints evenly; here the standard errors of the "
        f"joints' own parameters differ by a factor of {found.excitation.evenness:.1f}.",
    )


def _slow_sines(found: CaseStudy) -> tuple[str, str]:
    fast, slow = _ratio(found, "4s", MODEL, PID), _ratio(found, "40s", MODEL, PID)
    no_gain = np.flatnonzero(slow > ALIKE)
    faded = bool(np.all(slow > fast))
    where = f"; no clear gain is left on {joint_words(no_gain)}" if len(no_gain) else ""
    return (
        "agrees" if faded else "differs",
        f"At 40 s the gain fades: computed torque leaves {_percents(slow)} % of the PID's error"
        f"{where}. {_how_slow(found)}",
    )


def _how_slow(found: CaseStudy) -> str:
    top = SLOW_SINE * np.pi / 6
    below = [j for j, v in enumerate(found.boundaries.values) if v > top]
    text = f"Its speed is then {top:.3f} rad/s at most"
    if not below:
        return f"{text}."
    return (
        f"{text}, below the boundary of {joint_words(below)} all the time, where the friction of "
        "the model, learnt from fast samples, does not hold."
    )


def _completed(found: CaseStudy) -> tuple[str, str]:
    share = _ratio(found, "40s", WITH_EFFECTS, MODEL)
    return (
        "adds",
        f"The paper ends with: “a different model should be used to describe the dynamic behavior "
        f"of the manipulator in this region”. {found.answer} With it in the controller the same "
        f"40 s experiment leaves {_percents(share)} % of the error that the model without it left.",
    )


def _ratio(found: CaseStudy, pace: str, how: str, over: str) -> Array:
    runs = found.following[pace]
    return np.asarray(runs[how].rms / np.maximum(runs[over].rms, 1e-12))


def _percents(share: Array) -> str:
    return listed([f"{100 * v:.0f}" for v in share])
