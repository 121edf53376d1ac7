"""A stretch of one run that fits into memory, with its filtered columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.effects import Context
from pa10d.model import Term, TorqueModel
from pa10d.regression.equation import RunEquation
from pa10d.regression.rests import rung_by

Array = NDArray[np.float64]


@dataclass
class Piece:
    """A stretch of one run: filtered torque (M, n), which samples count (M, n) without reversals,
    with them, and with rests, rigid columns per joint (M, b_j), and the motion behind them for
    further columns."""

    equation: RunEquation
    keep: NDArray[np.bool_]
    moving: NDArray[np.bool_]
    inside: NDArray[np.bool_]
    rigid: list[Array]
    fast: Array  # (n,) rad/s
    _columns: dict[tuple[object, ...], Array] = field(default_factory=dict)

    @property
    def tau(self) -> Array:
        """(M, n) N·m."""
        return self.equation.driven

    @property
    def resting(self) -> NDArray[np.bool_]:
        """(M, n) samples at rest, where equations hold there at all."""
        if not self.equation.stands:
            return np.zeros_like(self.moving)
        going = self.equation.going
        still = self.inside & ~self.moving
        return still if going is None else still & ~rung_by(going, self.equation.lowpass)

    @property
    def context(self) -> Context:
        """Motion at the raw rate."""
        return self.equation.context

    def shifted(self, seconds: float) -> Piece:
        """The same stretch with its torque taken ``seconds`` later than it is now."""
        if seconds == 0.0:
            return self
        return replace(self, equation=self.equation.later(seconds))

    def through(self, model: TorqueModel) -> Piece:
        """The same stretch with the loads and torques of a model."""
        seen = replace(self.equation, context=model.contextualise(self.context))
        return replace(self, equation=seen, _columns={})

    def filtered(self, terms: Sequence[Term], joint: int) -> Array:
        """(M, Σk) filtered columns of effects in one joint's equation; they are remembered."""
        if not terms:
            return np.empty((len(self.tau), 0))
        keys = [(t.effect_id, t.joints, joint, *t.shape.items()) for t in terms]
        new = {k: t for k, t in zip(keys, terms, strict=True) if k not in self._columns}
        if new:
            raw = [t.rows(self.context, joint).T for t in new.values()]
            found = self.equation.filtered(np.concatenate(raw).T, joint)
            ends = np.cumsum([len(r) for r in raw])[:-1]
            self._columns.update(zip(new, np.split(found, ends, axis=1), strict=True))
        return np.concatenate([self._columns[k] for k in keys], axis=1)
