"""Recordings cut into pieces that fit into memory, each with its filtered columns.

Pieces overlap by what the filters need to settle and count each decimated sample once, so an
hour of data costs no more memory than a minute.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.identify.condition import (
    GRAM_LIMIT,
    by_triangle,
    condition_of_gram,
    textbook_gram,
)
from pa10d.identify.cuts import PIECE, cuts
from pa10d.identify.piece import Piece
from pa10d.measurement.motion import velocity_source
from pa10d.measurement.recording import Recording
from pa10d.measurement.signals import Lowpass
from pa10d.measurement.standstill import fast_speed
from pa10d.measurement.torque_filter import TorqueFilter
from pa10d.model import TorqueModel
from pa10d.regression.equation import RunEquation, decimation, prepare
from pa10d.regression.layout import Layout
from pa10d.regression.rests import counted

Array = NDArray[np.float64]

ENOUGH = 8  # pieces that answer a question about the whole
HOLDS = 0.05  # part of a filtered sample that stems from motion: with less there is no equation
REMEMBERED = 600_000_000  # bytes of filtered columns that are kept rather than computed again


@dataclass
class Pieces:
    """All stretches of all runs under one cut-off and shift; iterate as often as you like.

    faster_than: (n,) rad/s; rows of slower joints do not count, not even as joints at rest
    """

    recordings: Sequence[Recording]
    robot: Robot
    layout: Layout
    cutoff: float
    shift: float = 0.0
    tick: Callable[[], None] = lambda: None
    faster_than: Array | None = None
    channel: TorqueFilter | None = None
    stands: bool = True
    _kept: dict[int, Piece] = field(default_factory=dict)
    _bytes: int = 0
    _model: TorqueModel | None = None
    _counted: set[int] = field(default_factory=set)
    gram: Array = field(default_factory=lambda: np.zeros(()))

    def __post_init__(self) -> None:
        self._fast = [self._speed(r) for r in self.recordings]
        self._sources = [velocity_source(middle(r), self.cutoff) for r in self.recordings]
        self._cuts = [
            (number, *cut)
            for number, r in enumerate(self.recordings)
            for cut in cuts(len(r.t), r.rate, self.cutoff)
        ]

    def __len__(self) -> int:
        return len(self._cuts)

    def __iter__(self) -> Iterator[Piece]:
        return (self._piece(i) for i in range(len(self)))

    def _piece(self, i: int) -> Piece:
        self.tick()
        if i in self._kept:
            return self._kept[i]
        piece = self._make(i)
        size = sum(c.nbytes for c in piece.rigid) + 5 * piece.context.q.nbytes
        if self._bytes + size <= REMEMBERED:
            self._kept[i] = piece
            self._bytes += size
        return piece

    def forget_columns(self) -> None:
        """Free the memory of effects' columns that will not be asked for again."""
        for piece in self._kept.values():
            piece._columns.clear()

    def shift_by(self, seconds: float) -> None:
        """Take every torque ``seconds`` later from now on."""
        self.shift += seconds
        self._kept = {i: piece.shifted(seconds) for i, piece in self._kept.items()}

    def pass_through(self, channel: TorqueFilter) -> None:
        """Let columns pass what the torque has passed from now on."""
        self.channel, self._kept, self._bytes = channel, {}, 0

    def without_stands(self) -> None:
        """Fit each joint's equation without the moments at which it stands from now on."""
        self.stands = False
        self._kept = {i: self._moving(i, piece.equation) for i, piece in self._kept.items()}

    def look_through(self, model: TorqueModel) -> None:
        """Let loads and torques that effects depend on be those of this model from now on."""
        self._model = model
        self._kept = {i: piece.through(model) for i, piece in self._kept.items()}

    def condition_number(self) -> float:
        """Of the textbook columns of all raw samples (see ``condition``)."""
        for i in set(range(len(self))) - self._counted:
            self._make(i)
        found = condition_of_gram(self.layout, self.gram)
        if found < GRAM_LIMIT:
            return found
        contexts = (piece.context for piece in self)
        return by_triangle(self.layout, ((c.q, c.dq, c.ddq) for c in contexts))

    @property
    def fast(self) -> Array:
        """(n,) rad/s: the fast speed of each joint over all runs."""
        return np.asarray(np.max(self._fast, axis=0))

    @property
    def rate(self) -> float:
        """Decimated samples per second of the first run; all runs of a fit share one cut-off."""
        rate = self.recordings[0].rate
        return rate / decimation(rate, self.cutoff)

    @property
    def lowpass(self) -> Lowpass:
        """Of the first piece; all share one cut-off."""
        return self._piece(0).equation.lowpass

    def some(self) -> Iterator[Piece]:
        """An even selection, enough for questions that do not need all of an hour."""
        chosen = np.unique(
            np.linspace(0, len(self) - 1, min(len(self), ENOUGH)).round().astype(int)
        )
        return (self._piece(int(i)) for i in chosen)

    def _make(self, i: int) -> Piece:
        number, start, stop, _, _ = self._cuts[i]
        recording = self.recordings[number]
        run = prepare(
            recording.part(start, stop, ""),
            self.robot,
            self.cutoff,
            self.shift,
            fast=self._fast[number],
            source=self._sources[number],
            channel=self.channel,
        )
        return self._piece_of(i, run) if self.stands else self._moving(i, run)

    def _moving(self, i: int, run: RunEquation) -> Piece:
        """A piece without the moments at which its joints stand."""
        return self._piece_of(i, run.without_stands(self._fast[self._cuts[i][0]]))

    def _piece_of(self, i: int, run: RunEquation) -> Piece:
        number, _, _, first, last = self._cuts[i]
        own = np.zeros(len(run.tau), dtype=bool)
        own[first:last] = True
        counts = own[:, None] & ~self._slow(run)
        moving = run.moving
        if not run.stands and run.going is not None:
            moving = run.counts & counted(run.going, run.lowpass, HOLDS)
        seen = self.layout.seen
        raw = run.raw_rigid(self.layout.base.kept)
        if i not in self._counted:
            self._count(i, raw, run, first, last)
        rigid = run.rigid_rows(self.layout.base.kept, seen, raw)
        inside = run.inside[:, None] & counts
        piece = Piece(run, run.keep & counts, moving & counts, inside, rigid, self._fast[number])
        return piece if self._model is None else piece.through(self._model)

    def _slow(self, run: RunEquation) -> NDArray[np.bool_]:
        """(M, n) rows that the caller wants left out."""
        if self.faster_than is None:
            return np.zeros(run.tau.shape, dtype=bool)
        return np.abs(run.lowpass(run.context.dq)) <= self.faster_than

    def _count(self, i: int, raw: Array, run: RunEquation, first: int, last: int) -> None:
        """Add a piece's own raw samples to the Gram matrix behind the condition number."""
        factor = run.lowpass.factor
        own = slice(first * factor, min(last * factor, raw.shape[2]))
        c = run.context
        self.gram = self.gram + textbook_gram(self.layout, raw[:, :, own], c.dq[own], c.ddq[own])
        self._counted.add(i)

    def _speed(self, recording: Recording) -> Array:
        """Fast speeds of a whole run from a coarse look at it."""
        step = max(1, int(recording.rate / 50.0))
        q = recording.q[::step]
        return fast_speed(np.diff(q, axis=0) * (recording.rate / step))


def middle(recording: Recording) -> Recording:
    """No more of a recording than is needed to judge how it was sampled."""
    spare = max(0, len(recording.t) - PIECE) // 2
    return recording.part(spare, len(recording.t) - spare, "")
