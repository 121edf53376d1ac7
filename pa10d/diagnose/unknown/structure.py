"""Structure that no effect of the library explains: does motion predict what is left over?

A generic smooth map of one or two motion variables is fitted to the residual of the fit side,
beside the model (what the model can absorb is projected out), and asked to predict the held-out
residual. Noise, however coloured, is not predicted by motion; structure is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from pa10d.common.parallel import shared_map
from pa10d.diagnose.constants import (
    CLAIMED_SHARE,
    CLUSTERS,
    FEW_VISITS,
    KNOWN_GROUND,
    LEAST_SLOPE,
    MAP_FINE_KNOTS,
    MAP_FLAT_KNOTS,
    MAP_KNOTS,
    MAP_LEVEL,
    MAP_MEMORIES,
    MAP_THIN,
    MAPS_PER_JOINT,
    RUNAWAY,
    UNHEARD,
    UNKNOWN_GROUND,
)
from pa10d.diagnose.evidence.errors_of import Noises, doubt_under, held_noise
from pa10d.diagnose.evidence.held_out import Evidence, ModelUncertainty, judge
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.effects.variables import remembered, since_it_stood
from pa10d.regression.equation import RunEquation
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]
Kind = Literal["motion", "gain", "reading"]
"""Over the motion; of a gain, by which a torque reads differently from place to place, or from
speed to speed; over the torques themselves, and of a gain over time."""


@dataclass(frozen=True)
class Structure:
    """A joint's residual depends on the named variables: share of all its squared error that the
    map removes, RMS N·m.

    grid: the knots of each variable; values: the map on them, N·m (2-D where two variables)
    there: share that it removes where the fit side has been, which is all that the map knows;
    beyond: share of all the squared error that lies elsewhere
    inside: held-out rows where the fit side has been; left: (N·m)², mean squared error there with
    the map
    """

    joint: int
    variables: tuple[str, ...]
    share: float
    rms: float
    p_value: float
    grid: tuple[Array, ...]
    values: Array
    evidence: Evidence
    inside: NDArray[np.bool_]
    left: float
    there: float
    beyond: float

    def outdoes(self, residual: PerJoint, factor: float) -> bool:
        """Does another model leave more than ``factor`` times this map's squared error, on the
        held-out samples that the map knows about?"""
        other = float(np.mean(residual[self.joint][self.inside] ** 2))
        return other > factor * self.left


def find_structure(state: SearchState) -> list[Structure]:
    """The best significant map of every joint, strongest first.

    What one joint leaves unexplained draws the bodies that all joints share towards itself, and
    that colours the others. So these are asked again with the equation of the stronger one left
    out of the fit.
    """
    heard = [j for j in range(state.train.n) if j not in state.held.silent]
    found = _best_maps(state, heard)
    certain = found[:1]
    while suspected := {s.joint for s in found} - {s.joint for s in certain}:
        more = _best_maps(without(state, [s.joint for s in certain]), sorted(suspected))
        if not more:
            break
        certain.append(more[0])
    return certain


def swaying_gains(state: SearchState, shares: Mapping[int, float]) -> dict[int, Structure]:
    """Joints of which a gain that sways explains more than the share that was found: by joint."""
    tried = all_maps(state, sorted(shares), "gain")
    best = [max(gains, key=lambda m: m.share) for gains in tried]
    return {m.joint: m for m in best if m.share > shares[m.joint]}


def _best_maps(state: SearchState, joints: Iterable[int]) -> list[Structure]:
    found = [max(maps, key=lambda m: m.there) for maps in all_maps(state, joints)]
    return sorted(found, key=lambda m: -m.there)


def without(state: SearchState, joints: Sequence[int]) -> SearchState:
    """Fitted to the other joints: these have next to no weight."""
    rest = state.copy()
    sigma = rest.fit.rms()
    sigma[list(joints)] *= UNHEARD
    rest.weigh(sigma)
    rest.refit()
    return rest


def find_readings(state: SearchState, joints: Iterable[int]) -> list[Structure]:
    """Of joints that have no map of the motion, the best of what a torque's reading may depend on:
    a step where it changes its sign, a share of another joint's, a gain that drifts with time."""
    return [max(maps, key=lambda m: m.there) for maps in all_maps(state, joints, "reading")]


def all_maps(
    state: SearchState, joints: Iterable[int], kind: Kind = "motion"
) -> Iterator[list[Structure]]:
    """The significant maps of each of the joints that have any, of one kind."""
    motions = variables_of(state.train, kind), variables_of(state.held, kind)
    residual = state.held_residual()
    n = state.train.n
    asked = list(joints)
    maps_of = shared_map(lambda j: _strongest(state, motions[0], motions[1], j, kind), asked)
    tried = dict(zip(asked, maps_of, strict=True))
    noise = noise_beside(state, residual, [p for maps in tried.values() for p in maps])
    for maps in tried.values():
        judged = (_judge(state, residual, p, n * MAPS_PER_JOINT, noise) for p in maps)
        results = [r for r in judged if r is not None]
        if results:
            yield results


def strongest_maps(state: SearchState, joint: int) -> list[Prediction]:
    """What the maps of a joint's motion that help the fit side most foretell of the held-out side,
    whether or not that holds."""
    motions = variables_of(state.train, "motion"), variables_of(state.held, "motion")
    return _strongest(state, *motions, joint, "motion")


def questions(joint: int, n: int) -> list[tuple[str, ...]]:
    """Which variables a map of this joint's residual may use (names with joints from 1)."""
    q = [f"q{j + 1}" for j in range(n)]
    dq = [f"dq{j + 1}" for j in range(n)]
    ddq = [f"ddq{j + 1}" for j in range(n)]
    own_q, own_dq = q[joint], dq[joint]
    single: list[tuple[str, ...]] = [(x,) for x in (*q, *dq, *ddq)]
    pairs = set(combinations(q, 2))
    pairs |= {(own_dq, x) for x in q} | {(own_q, x) for x in dq}
    pairs |= set(combinations(dq, 2))
    pairs |= {(own, f"{own_q} {s:g} s ago") for own in (own_q, own_dq) for s in MAP_MEMORIES}
    pairs.add((own_dq, moving_of(joint)))
    return single + sorted(pairs)


def moving_of(joint: int) -> str:
    """The name of the time since a joint (0-based) last stood."""
    return f"moving{joint + 1}"


def _gains(joint: int) -> list[tuple[str, ...]]:
    """Where a joint's torque may read differently."""
    return [(f"q{joint + 1}",), (f"dq{joint + 1}",)]


def _readings(joint: int, n: int) -> list[tuple[str, ...]]:
    """What a joint's torque as it is read may depend on, besides; with time: of a gain."""
    own = f"tau{joint + 1}"
    return [(own,), ("time", own), *((f"tau{k + 1}",) for k in range(n) if k != joint)]


def variables_of(side: Side, kind: Kind) -> list[dict[str, Array]]:
    """Per run: name -> (M,) what maps of a kind are made over."""
    if kind != "reading":
        return motion_variables(side.runs)
    out = []
    for run, context in zip(side.runs, side.contexts, strict=True):
        torque = run.lowpass(context.total)
        out.append({"time": run.t, **{f"tau{j + 1}": x for j, x in enumerate(torque.T)}})
    return out


def motion_variables(runs: Sequence[RunEquation]) -> list[dict[str, Array]]:
    """Per run: name -> (M,) filtered motion variable at the equation's rate."""
    out = []
    for run in runs:
        context, names = run.context, {}
        joints = range(context.q.shape[1])
        step = run.lowpass.factor
        for kind, values in (("q", context.q), ("dq", context.dq)):
            for j in joints:
                names[f"{kind}{j + 1}"] = values[::step, j]
                if kind == "dq":
                    names[moving_of(j)] = since_it_stood(values[:, j], context.dt)[::step]
                for seconds in MAP_MEMORIES if kind == "q" else ():
                    slow = remembered(values[:, j], seconds, context.dt)
                    names[f"q{j + 1} {seconds:g} s ago"] = slow[::step]
        smooth = run.lowpass(context.ddq)
        for j in joints:
            names[f"ddq{j + 1}"] = smooth[:, j]
        out.append(names)
    return out


@dataclass
class _Map:
    joint: int
    names: tuple[str, ...]
    grid: tuple[Array, ...]
    values: Array
    gain: float
    absorbed: Array
    visited: NDArray[np.bool_]
    swaying: bool


def _over(names: Sequence[str]) -> tuple[str, ...]:
    """What a map is made over: of a gain that drifts with time, the time alone."""
    return ("time",) if names[0] == "time" else tuple(names)


def rows_of(side: Side, motion: list[dict[str, Array]], name: str, joint: int) -> Array:
    """(m_j,) a quantity in the rows of a joint's equation."""
    return side.gathered([m[name] for m in motion], joint)


def _fit_map(
    state: SearchState,
    motion: list[dict[str, Array]],
    joint: int,
    names: Sequence[str],
    swaying: bool = False,
    flat: bool = False,
) -> _Map:
    """swaying: the map is that of a gain on the joint's torque, its values N·m at the torque's
    RMS; flat: straight along each variable, so that it goes on where the fit side has not been."""
    fit = state.fit
    over = _over(names)
    x = [rows_of(state.train, motion, name, joint)[::MAP_THIN] for name in over]
    count = MAP_FLAT_KNOTS if flat else MAP_FINE_KNOTS if len(over) == 1 else MAP_KNOTS
    grid = tuple(knots(v, count) for v in x)
    basis = basis_of(x, grid)
    acts = _share_of_torque(state, 0, joint)[::MAP_THIN] if swaying else np.ones(len(x[0]))
    columns = (basis * (acts / fit.sigma[joint])[:, None]).tocsr()
    across = columns.T.tocsr()
    seen = MAP_THIN * (across @ fit.basis[joint][::MAP_THIN]).T
    gram = MAP_THIN * (across @ columns).toarray()
    # pseudo-observations per cell: one that was hardly visited says nothing
    ridge = FEW_VISITS * np.diag(gram).mean() / max(MAP_THIN * len(x[0]) / columns.shape[1], 1.0)
    left = gram - seen.T @ seen + ridge * np.eye(len(gram))
    rhs = MAP_THIN * (across @ fit.residual[joint][::MAP_THIN])
    theta = np.linalg.solve(left, rhs)
    gain = float(theta @ rhs)
    effective = float(np.trace(np.linalg.solve(left, gram - seen.T @ seen)))
    shape = tuple(len(g) for g in grid)
    return _Map(
        joint, tuple(names), grid, theta.reshape(shape), gain - 2 * effective,
        fit.to_beta @ (seen @ theta), MAP_THIN * basis.power(2).sum(axis=0) > FEW_VISITS, swaying,
    )  # fmt: skip


def _share_of_torque(state: SearchState, side: int, joint: int) -> Array:
    """(m_j,) what the model has of the joint's torque, over its RMS on the training side."""
    train = state.matrix(0)[joint] @ state.fit.beta
    there = train if side == 0 else state.held_matrix[joint] @ state.fit.beta
    return np.asarray(there / max(float(np.sqrt(np.mean(train**2))), 1e-12))


@dataclass
class Prediction:
    """What is foretold of a joint's held-out side: values (m_j,) N·m, zero where nothing is known;
    inside: where something is; map: that says so, where it is one."""

    joint: int
    names: tuple[str, ...]
    values: Array
    inside: NDArray[np.bool_]
    map: _Map | None = None


def _strongest(
    state: SearchState,
    motion: list[dict[str, Array]],
    held: list[dict[str, Array]],
    joint: int,
    kind: Kind,
) -> list[Prediction]:
    """The maps of one joint that help the fit side most, among those that know enough ground."""
    n = state.train.n
    asked = {"motion": questions(joint, n), "gain": _gains(joint), "reading": _readings(joint, n)}
    varies = [names for names in asked[kind] if _vary(motion, names) and _vary(held, names)]
    maps = (
        _fit_map(state, motion, joint, names, kind == "gain" or names != _over(names))
        for names in varies
    )
    strongest = sorted(maps, key=lambda m: -m.gain)[:MAPS_PER_JOINT]
    if kind == "motion":
        strongest = [_or_flat(state, motion, m) for m in strongest]
    predictions = (_predict(state, held, m) for m in strongest)
    most = RUNAWAY * float(np.max(np.abs(state.held.tau[joint]), initial=0.0))
    told = [p for p in predictions if p.inside.mean() >= KNOWN_GROUND]
    return [p for p in told if np.max(np.abs(p.values), initial=0.0) <= most]


def _vary(motion: list[dict[str, Array]], names: Sequence[str]) -> bool:
    """Is no quantity the same throughout? A joint that never stands has none since it stood."""
    return all(max(m[x].max() for m in motion) > min(m[x].min() for m in motion) for x in names)


def _or_flat(state: SearchState, motion: list[dict[str, Array]], curved: _Map) -> _Map:
    """A map that is straight along each of the variables where that is as good by Akaike's measure:
    it goes on where the fit side has not been, which a curve does not."""
    flat = _fit_map(state, motion, curved.joint, curved.names, flat=True)
    return flat if flat.gain >= curved.gain else curved


def _predict(state: SearchState, motion: list[dict[str, Array]], m: _Map) -> Prediction:
    x = [rows_of(state.held, motion, name, m.joint) for name in _over(m.names)]
    basis = basis_of(x, m.grid)
    inside = np.ones(len(x[0]), dtype=bool)
    if len(m.grid[0]) > MAP_FLAT_KNOTS:
        inside &= np.all([(v >= g[0]) & (v <= g[-1]) for v, g in zip(x, m.grid, strict=True)], 0)
        inside &= basis @ ~m.visited < UNKNOWN_GROUND
    acts = _share_of_torque(state, 1, m.joint) if m.swaying else 1.0
    values = acts * (basis @ m.values.ravel()) - state.held_matrix[m.joint] @ m.absorbed
    return Prediction(m.joint, m.names, np.where(inside, values, 0.0), inside, m)


@dataclass
class Noise:
    """How uncertain the model is, each joint's noise being the least that any prediction of it
    leaves."""

    state: SearchState
    noises: Noises
    own: Noises

    def beside(self, prediction: Prediction) -> ModelUncertainty:
        """With this one added: the noise of its joint is what it leaves."""
        own = {prediction.joint: self.own[id(prediction)]}
        return doubt_under(self.state, {**self.noises, **own})


def noise_beside(state: SearchState, residual: PerJoint, predictions: list[Prediction]) -> Noise:
    """residual: joint -> (m_j,) N·m held out."""
    residual = {j: r for j, r in residual.items() if len(r)}
    power = {j: float(np.mean(r**2)) for j, r in residual.items()}
    noises = {j: held_noise(state, j, r, np.ones(len(r), dtype=bool)) for j, r in residual.items()}
    own = {}
    for p in predictions:
        left = residual[p.joint] - p.values
        own[id(p)] = held_noise(state, p.joint, left, p.inside)
        if (now := float(np.mean(left[p.inside] ** 2))) < power[p.joint]:
            power[p.joint], noises[p.joint] = now, own[id(p)]
    return Noise(state, noises, own)


@dataclass(frozen=True)
class Claim:
    """A prediction that holds: share of the squared error that it removes where it speaks, what it
    leaves there, (N·m)², and p, corrected for all that were tried."""

    share: float
    left: float
    p_value: float
    evidence: Evidence


def evidence_of(
    state: SearchState,
    residual: PerJoint,
    prediction: Prediction,
    among: int,
    noise: Noise,
    level: float = MAP_LEVEL,
) -> Claim | None:
    """None where noise alone does as well, or too little is foretold to matter."""
    joint, values, inside = prediction.joint, prediction.values, prediction.inside
    doubt = noise.beside(prediction)
    evidence = judge(state.held, residual, {joint: values}, doubt, {joint: inside})
    r = residual[joint]
    left = float(np.mean((r - values)[inside] ** 2))
    share = 1.0 - left / float(np.mean(r[inside] ** 2))
    p = min(1.0, evidence.p_value * among)
    if p > level or not holds(evidence, share):
        return None
    return Claim(share, left, p, evidence)


def holds(evidence: Evidence, share: float) -> bool:
    """Is enough foretold to matter, of about the size that is there, and in all of the time?"""
    well = evidence.slope >= LEAST_SLOPE and evidence.cluster_t >= CLUSTERS
    return well and share >= CLAIMED_SHARE


def _judge(
    state: SearchState, residual: PerJoint, prediction: Prediction, among: int, noise: Noise
) -> Structure | None:
    claim, m = evidence_of(state, residual, prediction, among, noise), prediction.map
    if claim is None or m is None:
        return None
    r, inside = residual[m.joint], prediction.inside
    rms = float(np.sqrt(np.mean(prediction.values**2)))
    beyond = float(np.sum(r[~inside] ** 2) / np.sum(r**2))
    return Structure(
        m.joint, m.names, of_all(residual, prediction), rms, claim.p_value, m.grid, m.values,
        claim.evidence, inside, claim.left, claim.share, beyond,
    )  # fmt: skip


def of_all(residual: PerJoint, prediction: Prediction) -> float:
    """Share of all the squared error of its joint that a prediction removes, which is zero where
    the fit side has not been."""
    r = residual[prediction.joint]
    return 1.0 - float(np.sum((r - prediction.values) ** 2) / np.sum(r**2))


def knots(values: Array, count: int) -> Array:
    """Knots between the extremes, half by range and half by where the data are."""
    low, high = float(values.min()), float(values.max())
    even = np.linspace(low, high, count)
    dense = np.quantile(values, np.linspace(0, 1, count))
    middle = 0.5 * (even + dense)
    return middle + np.arange(count) * 1e-9 * max(high - low, 1e-9)


def basis_of(x: list[Array], grid: tuple[Array, ...]) -> scipy.sparse.csr_array:
    """Products of hat functions on the knots, (rows, product of knot counts): four or two of them
    at a place, the others zero."""
    where, share = _two_hats(x[0], grid[0])
    for values, g in zip(x[1:], grid[1:], strict=True):
        beside, part = _two_hats(values, g)
        where = (where[:, :, None] * len(g) + beside[:, None, :]).reshape(len(values), -1)
        share = (share[:, :, None] * part[:, None, :]).reshape(len(values), -1)
    rows, each = where.shape
    starts = np.arange(0, rows * each + 1, each)
    size = int(np.prod([len(g) for g in grid]))
    return scipy.sparse.csr_array((share.ravel(), where.ravel(), starts), shape=(rows, size))


def _two_hats(values: Array, grid: Array) -> tuple[NDArray[np.int64], Array]:
    """(rows, 2): the knots beside each value and their share in a piecewise linear function that is
    constant beyond the ends; between two knots alone it is a line that goes on."""
    place = np.clip(np.searchsorted(grid, values) - 1, 0, len(grid) - 2)
    width = np.maximum(grid[place + 1] - grid[place], 1e-300)  # none where nothing moved
    share = (values - grid[place]) / width
    if len(grid) > MAP_FLAT_KNOTS:
        share = np.clip(share, 0.0, 1.0)
    return np.column_stack([place, place + 1]), np.column_stack([1.0 - share, share])
