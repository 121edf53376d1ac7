"""Forward selection of regions and curves within one joint, against what chance would show.

The error and its surrogates go through the same bins. Per quantity the error's figure is set
against the surrogates' mean and spread; the largest over all quantities is compared with the
surrogates' largest, so that looking in many places costs nothing (Westfall & Young). What is
found is taken away before looking on, so that one failure is not told twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.compare.curves import Curve, curve_values, find_constant, follows
from pa10d.compare.knocks import few_moments
from pa10d.compare.regions import Region, find_region, pile
from pa10d.compare.samples import Bins, JointSamples, bins
from pa10d.compare.surrogates import chance, surrogates

Array = NDArray[np.float64]
Found = tuple[Region | Curve, float]
Figure = Callable[[Bins, Array], Array]

REGIONS, CURVES = 3, 2  # at most, per joint
LEAST = 0.1  # of the squared error: less is not worth a sentence
FILLED = 0.5  # of an error of a few moments
DENSE = 1 / 3  # of how dense it is in them: of what grows with the square of how far the motion is
# in a region, four fifths lie in the last 27 % of it, which is 2.9 times as dense as all of it
NEIGHBOUR = 0.8  # a neighbour's motion must explain this much better to be named first


class PlaceSearch:
    """level: chance of a false claim per kind of place."""

    def __init__(self, samples: JointSamples, level: float, seed: int) -> None:
        self._samples = samples
        self._level = level
        self._seed = seed
        self._error = samples.error
        self._total = float(np.sum(self._error**2))
        self._moments = few_moments([(*part, samples.rate) for part in samples.parts])
        self._everything = np.ones(len(self._error), dtype=bool)

    def run(self) -> list[Found]:
        """Places and their p values."""
        if self._total <= 0:
            return []
        return [(what, p) for what, p in (*self._curves(), *self._regions()) if self._fills(what)]

    def _fills(self, what: Region | Curve) -> bool:
        """Of an error of a few moments, of which surrogates scatter what comes at once: is it there
        nearly whenever the motion is, and not just in moments at which the motion is somewhere?"""
        if self._moments is None:
            return True
        dense = what.share / what.samples if isinstance(what, Region) else np.inf
        return what.share > FILLED and dense > DENSE * self._moments.dense

    def _curves(self) -> Iterable[Found]:
        error, found = self._error, 0
        q = next(iter(self._samples.x.values()))
        constant, p = find_constant(self._samples, q)
        if p < self._level and constant.share > LEAST:
            yield constant, p
            found += 1
        error = error - error.mean()
        tables = self._tables(self._everything)
        while found < CURVES:
            seen, null = self._figures(tables, error, follows_error)
            best = self._best(tables, seen, null)
            if best is None:
                return
            k, p = best
            share = float(seen[k] - null[k].mean()) * float(np.sum(error**2)) / self._total
            if share < LEAST:
                return
            table = tables[k]
            edges = table.edges
            yield Curve(table.quantity, float(edges[0]), float(edges[-1]), share), p
            found += 1
            error = error - curve_values(table, error)

    def _regions(self) -> Iterable[Found]:
        left, found = self._everything, 0
        while found < REGIONS:
            tables = self._tables(left)
            seen, null = self._figures(tables, self._error, pile_size)
            best = self._best(tables, seen, null)
            if best is None:
                return
            k, p = best
            region = find_region(tables[k], tables[k].sums(self._error**2))
            if region is None:
                return
            region = self._over_all(region)
            if region.excess < LEAST:
                return
            yield region, p
            found += 1
            left = left & ~region.holds(self._samples.x[region.quantity])

    def _figures(self, tables: list[Bins], error: Array, figure: Figure) -> tuple[Array, Array]:
        """Per quantity: of the error (Q,), of the surrogates (Q, S)."""
        if not tables:
            return np.empty(0), np.empty((0, 0))
        rng = np.random.default_rng(self._seed)
        drawn = surrogates(self._as_parts(error), rng)
        seen = np.array([figure(table, error[:, None])[0] for table in tables])
        return seen, np.array([figure(table, drawn) for table in tables])

    def _best(self, tables: list[Bins], seen: Array, null: Array) -> tuple[int, float] | None:
        """The quantity whose figure exceeds chance most, if it does so significantly."""
        if not tables:
            return None
        middle = null.mean(axis=1)
        spread = np.maximum(null.std(axis=1, ddof=1), 1e-12)
        largest = np.max((null - middle[:, None]) / spread[:, None], axis=0)
        p = np.array([chance(z, largest) for z in (seen - middle) / spread])
        own = np.array([table.quantity.own for table in tables])
        rank = np.where(p < self._level, (seen - middle) * np.where(own, 1.0, NEIGHBOUR), -np.inf)
        k = int(np.argmax(rank))
        return (k, float(p[k])) if rank[k] > 0 else None

    def _as_parts(self, error: Array) -> list[tuple[Array, NDArray[np.bool_]]]:
        parts, start = [], 0
        for _, mask in self._samples.parts:
            stop = start + int(mask.sum())
            whole = np.zeros(len(mask))
            whole[mask] = error[start:stop]
            parts.append((whole, mask))
            start = stop
        return parts

    def _tables(self, use: NDArray[np.bool_]) -> list[Bins]:
        found = [bins(quantity, x, use) for quantity, x in self._samples.x.items()]
        return [table for table in found if table is not None]

    def _over_all(self, region: Region) -> Region:
        """The same range with its shares of all samples, those of earlier regions included."""
        inside = region.holds(self._samples.x[region.quantity])
        share = float(np.sum(self._error[inside] ** 2)) / self._total
        return replace(region, share=share, samples=float(np.mean(inside)))


def follows_error(table: Bins, error: Array) -> Array:
    """``follows`` of series (K, S)."""
    return follows(table, table.sums(error), np.sum(error**2, axis=0))


def pile_size(table: Bins, error: Array) -> Array:
    """``pile`` of series (K, S)."""
    return pile(table, table.sums(np.abs(error)))
