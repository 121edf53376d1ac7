"""A Fourier series that excites all parameters: optimal where coefficients are given."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from pa10d.common.errors import UserError
from pa10d.trajectory.excitation.in_the_open import narrower, open_pose
from pa10d.trajectory.excitation.polish import QUICK, polish
from pa10d.trajectory.excitation.problem import ExcitationProblem
from pa10d.trajectory.kinds.base import Angle, Array, Count, Kind, Positive
from pa10d.trajectory.limits import MotionLimits
from pa10d.trajectory.motions import Fourier
from pa10d.trajectory.plan import Plan, Segment, joined
from pa10d.trajectory.poses import Surroundings

DRAWS = 20  # random series
FEW = 2  # of the best that are improved
SMALLER = (1.0, 0.98, 0.95)  # of its size, for one that leaves no acceleration to enter it with


class Excitation(Kind):
    """q_i = centre_i + Σ_l a_li sin(ωlt) - b_li cos(ωlt), entered from rest, repeated, left.

    Without coefficients a random series is improved for a second: good, not optimal; `pa10d
    excite` finds better ones and writes them here.
    """

    kind: ClassVar[str] = "excitation"
    title: ClassVar[str] = "Fourier series of all joints that excites every parameter"

    fundamental: Positive = Field(default=0.1, description="Hz")
    harmonics: Annotated[int, Field(ge=1, le=30)] = Field(
        default=5, description="of a random series"
    )
    cycles: Count = Field(default=3, description="periods at full pace; their spread is the noise")
    centre: list[Angle] | None = Field(default=None, description="rad, one per joint of the arm")
    a: list[list[Angle]] | None = Field(default=None, description="rad, a row per harmonic")
    b: list[list[Angle]] | None = Field(default=None, description="rad, a row per harmonic")

    def build(self, around: Surroundings) -> Plan:
        """One segment; its window is a whole number of periods."""
        joints, limits = self.chosen(around), around.limits
        given = (self.centre, self.a, self.b)
        if any(part is None for part in given) and any(part is not None for part in given):
            raise UserError("excitation: centre, a and b belong together; expected all or none")
        if self.centre is None:
            series = _entered(self._random(around, joints), limits)
        else:
            series = self._given(around).gentle(limits)
        label = f"{self.cycles} periods of {series.period:g} s"
        return joined(self.kind, joints, [Segment(series, label)], around)

    @classmethod
    def of(cls, problem: ExcitationProblem, x: Array, cycles: int) -> Excitation:
        """The request for a motion that was found: coefficients of the moving joints, others 0."""
        h, moving = problem.harmonics, list(problem.joints)
        centre = np.array(problem.pose)
        a, b = np.zeros((2, h, problem.robot.n))
        centre[moving], a[:, moving], b[:, moving] = x[0], x[1 : 1 + h], x[1 + h :]
        return cls(
            joints=[j + 1 for j in problem.joints],
            fundamental=problem.fundamental,
            harmonics=h,
            cycles=cycles,
            centre=centre.tolist(),
            a=a.tolist(),
            b=b.tolist(),
        )

    def _series(self, centre: Array, a: Array, b: Array) -> Fourier:
        return Fourier(self.cycles / self.fundamental, 1.0, self.fundamental, centre, a, b)

    def _given(self, around: Surroundings) -> Fourier:
        n = around.robot.n
        rows = {"centre": [self.centre], "a": self.a, "b": self.b}
        for key, table in rows.items():
            for k, row in enumerate(table or []):
                if len(row or []) != n:
                    raise UserError(
                        f"excitation: {key}: row {k + 1} has {len(row or [])} values, "
                        f"expected {n}, one per joint"
                    )
        if len(self.a or []) != len(self.b or []) or not self.a:
            raise UserError(
                f"excitation: a has {len(self.a or [])} rows and b {len(self.b or [])}; "
                "expected as many, one per harmonic"
            )
        return self._series(np.array(self.centre), np.array(self.a), np.array(self.b))

    def _random(self, around: Surroundings, joints: list[int]) -> Fourier:
        problem = ExcitationProblem(
            around.robot, tuple(joints), tuple(self.home(around)), around.room,
            self.fundamental, self.harmonics,
        )  # fmt: skip
        rng = np.random.default_rng(self.seed)
        drawn = [problem.random(rng) for _ in range(DRAWS)]
        drawn.sort(key=lambda x: problem.excess(x) * 1e6 + problem.condition_number(x))
        found = Excitation.of(problem, _improved(problem, drawn[:FEW], rng), self.cycles)
        return self._series(np.array(found.centre), np.array(found.a), np.array(found.b))


def _improved(problem: ExcitationProblem, drawn: list[Array], rng: np.random.Generator) -> Array:
    """The best motion near the first few. Where those end in the floor, or too heavy, they are
    begun in the open; the last resort is as much of the best as can be run."""
    best = min((polish((problem, x, QUICK)) for x in drawn), key=lambda c: c.score)
    if problem.excess(best.x) <= 0.0:
        return best.x
    about = open_pose(problem, rng)
    begun = (polish((problem, narrower(problem, x, about), QUICK)) for x in drawn)
    best = min(best, *begun, key=lambda c: c.score)
    return narrower(problem, best.x, about)


def _entered(series: Fourier, limits: MotionLimits) -> Fourier:
    """A series that nobody has asked for as it is, a little smaller where it must be."""
    *first, least = SMALLER
    for share in first:
        try:
            return replace(series, a=share * series.a, b=share * series.b).gentle(limits)
        except UserError:
            continue
    return replace(series, a=least * series.a, b=least * series.b).gentle(limits)
