"""What is known before the data, where somebody knows: it decides what the motion leaves open.

Of the bodies: every parameter of a link (mass, first moments, inertias) is taken as the URDF's,
give or take a share of what is usual for a link of its mass and size, independently of all others.
Of single parameters: a value and its standard error (see ``given``). Both are rows that join the
weighted squares; what bodies' rows say of the base parameters is what is left of them when all
that torque does not show is free. Where rotors are one with their links nothing is known of the
sum: a URDF has no rotors.

Least squares takes all samples for independent, and trusts them more than their stated errors do.
A row counts more by as much (σ stated over σ counted), so that a value that was measured and a
value that was given are weighed as their errors say.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics.pseudo_inertia import scales
from pa10d.dynamics.rotors import rotors_within
from pa10d.identify.fit import Fit
from pa10d.identify.given import Given, placed
from pa10d.model.notes import GivenNote, PriorNote
from pa10d.regression.bodies import free_of, of_base
from pa10d.regression.layout import Layout
from pa10d.regression.problem import Knowledge

Array = NDArray[np.float64]

WIDEST = 1000.0  # % of a link's own figures; beyond that nobody knows anything
FIRM = 1e-4  # of what the data leave in doubt (bodies: of a link's own figures): a row that is
# firmer fixes the value no better, and costs digits
ALONE = 1e-3  # of the value: the same where the data say nothing of it
TINY = 1e-12  # the same where the value is 0
CONTRADICTED = 3.0  # standard errors of both together


@dataclass(frozen=True)
class Beside:
    """What is known, as it counts beside data.

    unknowns: of the layout's, each by itself; bodies: of the standard parameters (10n,)
    """

    layout: Layout
    unknowns: Knowledge
    bodies: Knowledge

    def whole(self) -> Knowledge:
        """All that it says of the layout's unknowns."""
        of_bodies = of_base(self.bodies, self.layout.robot, self.layout.base)
        return Knowledge(
            np.concatenate([of_bodies.wide(self.layout.size), self.unknowns.rows]),
            np.concatenate([of_bodies.target, self.unknowns.target]),
            np.concatenate([of_bodies.spread, self.unknowns.spread]),
        )

    def of_bodies(self) -> Knowledge:
        """The bodies' rows; a rotor that is one with its link may be any."""
        base, rows = self.layout.base, self.bodies.rows
        rotors = rows[:, base.kept] @ rotors_within(self.layout.robot, base).share
        rest = free_of(rotors, np.column_stack([rows, self.bodies.target]))
        return Knowledge(rest[:, :-1], rest[:, -1], self.bodies.spread)


@dataclass(frozen=True)
class Prior:
    """percent: of what is usual for a link, by which bodies differ from the URDF's; given: single
    parameters."""

    layout: Layout
    percent: float | None
    given: tuple[Given, ...]

    @classmethod
    def of(
        cls,
        layout: Layout,
        percent: float | None = None,
        statements: Sequence[tuple[str, float, float]] = (),
    ) -> Prior | None:
        """None where nothing is known; statements: name, value, standard error."""
        if percent is not None and not 0 < percent <= WIDEST:
            raise UserError(
                f"prior: found {percent:g} %, expected more than 0 and at most {WIDEST:g}"
            )
        given = placed(layout, statements)
        return cls(layout, percent, given) if percent is not None or given else None

    def beside(self, data: Fit | None = None) -> Beside:
        """As it counts beside what the data say alone."""
        counted, stated, open_ = self._of_data(data)
        heed = np.maximum(stated / counted, 1.0)
        rows, target, spread = [], [], []
        for one in self.given:
            if (i := one.unknown) is None:
                continue
            floor = ALONE * abs(one.value) if open_[i] else FIRM * stated[i]
            weight = heed[i] / max(one.std_error, floor, TINY)
            rows.append(weight * (np.arange(self.layout.size) == i))
            target.append(weight * one.value)
            spread.append(weight * one.std_error)
        known = heed[: len(self.layout.base)][~open_[: len(self.layout.base)]]
        unknowns = Knowledge(
            np.reshape(rows, (-1, self.layout.size)).astype(float),
            np.array(target),
            np.array(spread),
        )
        return Beside(
            self.layout, unknowns, self._of_bodies(float(np.median(known)) if len(known) else 1.0)
        )

    def _of_data(self, data: Fit | None) -> tuple[Array, Array, NDArray[np.bool_]]:
        """(p,) standard errors as least squares counts them and as they are stated, and True where
        data say nothing."""
        size = self.layout.size
        if data is None:
            return np.ones(size), np.ones(size), np.ones(size, dtype=bool)
        counted = np.sqrt(np.diag(data.solution.covariance()))
        stated = np.sqrt(np.maximum(np.diag(data.uncertainty.covariance), 0.0))
        none = ~((counted > 0) & (stated > 0))
        none[data.solution.open] = True
        return np.where(none, 1.0, counted), np.where(none, 1.0, stated), none

    def _of_bodies(self, heed: float) -> Knowledge:
        urdf = self.layout.robot.parameters.reshape(-1)
        size = np.concatenate([scales(link) for link in self.layout.robot.parameters])
        mean, error = urdf.copy(), np.full(len(urdf), np.inf)
        if self.percent is not None:
            error = 0.01 * self.percent * size
        for one in self.given:
            if one.body is not None:  # instead of the URDF's
                mean[one.body], error[one.body] = one.value, one.std_error
        known = np.flatnonzero(np.isfinite(error))
        weight = heed / np.maximum(error, FIRM * size)[known]
        rows = np.eye(len(urdf))[known] * weight[:, None]
        return Knowledge(rows, weight * mean[known], weight * error[known])

    @cached_property
    def std_errors(self) -> Array:
        """(p,) of the unknowns before any data, endless where nothing is known."""
        told = self.beside().whole()
        rows = told.rows / np.maximum(told.spread, 1e-6)[:, None]  # as firm as it was given
        scale = np.linalg.norm(rows, axis=0)
        scale[scale == 0] = 1.0
        _, values, right = np.linalg.svd(rows / scale)
        values = np.append(values, np.zeros(len(right) - len(values)))
        known = values > 1e-9 * values.max(initial=1e-300)
        found = np.linalg.norm(right[known] / values[known, None], axis=0) / scale
        return np.where(np.linalg.norm(right[~known], axis=0) > 1e-6, np.inf, found)

    def note(self) -> PriorNote:
        """Kept with the model."""
        known = tuple(float(s) if np.isfinite(s) else None for s in self.std_errors)
        given = tuple(GivenNote(one.name, one.value, one.std_error) for one in self.given)
        return PriorNote(self.percent, given, known)

    def contradicted(self, data: Fit) -> Iterator[str]:
        """A sentence for every given value that the data alone do not bear out."""
        _, stated, open_ = self._of_data(data)
        places = zip(self.layout.terms, self.layout.places, strict=True)
        joints = {i: t.joints for t, place in places for i in range(place.start, place.stop)}
        for one in self.given:
            if (i := one.unknown) is None or open_[i]:
                continue
            value = float(data.solution.beta[i])
            gain = self.layout.robot.gain_share(joints.get(i, ())) * value  # torque's own scale
            error = float(np.hypot(stated[i], gain))
            far = abs(value - one.value) / max(float(np.hypot(error, one.std_error)), 1e-300)
            if far > CONTRADICTED:
                yield (
                    f"{one.name} was given as {one.value:.4g} ± {one.std_error:.2g}, the data "
                    f"alone say {value:.4g} ± {error:.2g}: they contradict each other ({far:.1f} "
                    "standard errors of both); check the figure and its unit, or leave it out"
                )
