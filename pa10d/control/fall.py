"""What a joint weighs that was not held as its brake opened, from how it fell.

The servo pushes back meanwhile, so that torque changes and tells inertia and weight apart:
J·v' = u - w, so v = b + a·t + c·∫(u - u0)dt with c = 1/J and w = u0 - a/c. Dry friction acts
against the fall: w is what is lacking beside it, and holds the joint. Viscous friction lets w look
smaller. Of joints that another one takes along it says nothing.

A joint that is gone within a few cycles leaves inertia open. It may be ``ROUGH`` times off to
either side, and so may be what was lacking; of all that may have been, the harmonic mean of the
ends comes nearer whatever it was.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.control.joint_figures import ROUGH

Array = NDArray[np.float64]

LEFT = 1e-3  # rad from its place, before which a gear's play may be all that moves
STIRS = 0.1 * LEFT  # rad, that no encoder's noise is
CREEPS, HARDLY = 0.02, 0.1  # rad/s, slower than which it stands, and of how fast it is
SLOWED = 0.5  # of the fastest that it was
FEWEST, FEW = 5, 3  # periods: three numbers are fitted, or two
WIDEST = 12.0  # times as much may have been lacking as the least: then a sixth is gained at worst
SURE = 3.0  # standard errors
MOST = ROUGH**2  # times its described weight, with a payload that nobody described
ALIKE = 0.05  # of how fast a joint gathered speed: falls that differ by less tell no inertia
EDGE = 0.25  # of what is left between both, nearer than which to one that was tried nothing is
GIVEN = 0.5  # of what a fall told to be lacking, that was given when its joint fell again
LACKING = 0.5  # of what was lacking, that may be lacking or too much next time
KEPT = 1024  # cycles: falls are shorter


@dataclass(frozen=True)
class Weighed:
    """torque, error: N·m that hold a joint where it fell, and their standard error. between: N·m,
    where all that is known is what it may be; again: that is by all falls until now."""

    torque: float
    error: float
    between: tuple[float, float] | None = None
    again: bool = False

    def at_least(self, other: Weighed, begun: float) -> Weighed:
        """The other, or the least of what may have been lacking to ``begun`` N·m where that is more
        than the other says was: it has the joint look lighter than any may be, as viscous friction
        does."""
        if self.between is None:
            return other
        least, more = self.between[0] - begun, other.torque - begun
        if least * more <= 0.0 or abs(least) <= abs(more):
            return other
        return replace(self, torque=self.between[0])

    @property
    def phrase(self) -> str:
        """For a person."""
        if self.between is None:
            fell = "by how it fell until now" if self.again else "by the way it fell"
            return (
                f"{fell} about {self.torque:.2g} N·m would have held it: the next enabling begins "
                "with that"
            )
        low, high = self.between
        return (
            f"by the way it fell {low:.2g} to {high:.2g} N·m would have held it: the next "
            f"enabling begins with {self.torque:.2g} N·m"
        )


@dataclass(frozen=True)
class Driven:
    """By what a joint fell: torque: N·m that it was given in the mean over its way; rise: rad/s²,
    in the mean as well, from rest; swings: its rotor did meanwhile, so that this is rough."""

    torque: float
    rise: float
    swings: bool = False


class FallWatch:
    """The last cycles of an arm that is powered up and has not been moved yet."""

    def __init__(self, n: int) -> None:
        self._rows, self._count = np.zeros((KEPT, 1 + 2 * n)), 0
        self._n = n

    def restart(self) -> None:
        """The brakes are about to open."""
        self._count = 0

    def see(self, time: float, q: Array, sent: Array) -> None:
        """s and (n,) rad as read in this cycle; N·m sent in the one before, which act from now on,
        for drives take them over with this cycle's SYNC."""
        row = self._rows[self._count % KEPT]
        row[0], row[1 : 1 + self._n], row[1 + self._n :] = time, q, sent
        self._count += 1

    def weighed(
        self, axis: int, thought: float, most: float, inertia: float | None = None
    ) -> Weighed | None:
        """Of a joint that fell under ``thought`` N·m; None where that is not known well enough to
        come nearer, or more than the ``most`` that it may weigh. inertia: kg·m² as presumed, where
        an answer that is rough is better than none."""
        seen = self._falling(axis)
        found = weight_of(*seen)
        if found is not None and SURE * found.error > LACKING * abs(found.torque - thought):
            found = None
        rough = None if inertia is None else roughly(*seen, inertia)
        if found is None:
            found = rough
        elif rough is not None:
            found = rough.at_least(found, float(seen[2][0]))
        return None if found is None or abs(found.torque) > most else found

    def driven(self, axis: int) -> Driven | None:
        """By what this joint fell."""
        return driven(*self._falling(axis))

    def swinging(
        self,
        axis: int,
        now: tuple[float, float, float],
        place: float,
        most: float,
        inertia: float | None,
    ) -> tuple[Driven | None, Weighed | None]:
        """The same of a joint that goes away from its place in turns, and what would have held it:
        see ``swinging``. now: s, rad, N·m of this cycle, which it has not ``seen`` yet; place: rad;
        most, inertia: see ``weighed``."""
        seen = self._rows[np.arange(max(0, self._count - KEPT), self._count) % KEPT]
        rows = np.vstack([seen[:, [0, 1 + axis, 1 + self._n + axis]], now])
        time, q, sent = rows.T
        there = np.flatnonzero(np.abs(q - place) <= LEFT)
        away = slice(int(there[-1]) if len(there) else 0, None)
        fell = swinging(time[away], q[away], sent[away])
        if fell is None or inertia is None:
            return fell, None
        begin = float(sent[away][0])
        found = _lacked(begin, *_by_way(fell, begin, inertia))
        return fell, None if found is None or abs(found.torque) > most else found

    def under(self, axis: int, thought: float) -> tuple[float, float]:
        """N·m, least and most, under which it went since it stood last; ``thought`` for one that
        was not seen moving."""
        sent = self._falling(axis)[2][:-1]  # the last acts from now on
        return (float(sent.min()), float(sent.max())) if len(sent) else (thought, thought)

    def way(self, axis: int) -> float:
        """rad that it went since it stood last."""
        q = self._falling(axis)[1]
        return float(q[-1] - q[0]) if len(q) else 0.0

    def _falling(self, axis: int) -> tuple[Array, Array, Array]:
        """s, rad and N·m of the rows since it stood last."""
        rows = self._rows[np.arange(max(0, self._count - KEPT), self._count) % KEPT]
        rows = rows[_still(rows[:, 0], rows[:, 1 + axis]) :]
        return rows[:, 0], rows[:, 1 + axis], rows[:, 1 + self._n + axis]


class Tried:
    """Under how many times its described weight each joint went down, and under how many up: it
    weighs something between, wherever it fell to meanwhile, for that is a share of its bodies."""

    def __init__(self, n: int) -> None:
        self._low, self._high = np.full(n, -np.inf), np.full(n, np.inf)
        self._driven: list[list[tuple[float, float, float]]] = [[] for _ in range(n)]
        self._alone = np.zeros(n, dtype=bool)
        # N·m beyond the description that was thought, and lacked, of falls one way in a row
        self._lacked: list[list[tuple[float, float]]] = [[] for _ in range(n)]

    def again(
        self,
        axis: int,
        described: float,
        fell: Driven | None,
        found: Weighed | None,
        alone: bool = False,
        inertia: float | None = None,
    ) -> Weighed | None:
        """What was found, or more of it where the joint fell the same way before, and is more inert
        than presumed: as with a payload that nobody described. Two falls under different torques
        tell inertia and weight apart as one does in which torque changes; where they are too much
        alike, twice as much counts as lacking. Of one fall viscous friction spoils that, for the
        servo's damping changes along with it: both make the joint look as light. It does so in two
        falls alike, which differ by what was given. described: N·m, here. alone: while others were
        in their brakes, where it is more inert than where they give way, by ``ROUGH`` times the
        presumed inertia, kg·m², at most."""
        before = self._driven[axis]
        if fell is None:
            return found
        if alone != self._alone[axis]:
            before.clear()
            self._alone[axis] = alone
        if before and (before[-1][2] * fell.rise <= 0.0 or before[-1][0] * described < 0.0):
            before.clear()
        before.append((described, fell.torque, fell.rise))
        rough = found is not None and found.between is not None
        if len(before) < 2 or not (rough or alone):
            return found
        (first, pushed, rise), more = before[0], before[-1][1]
        if abs(fell.rise) < (1.0 - ALIKE) * abs(rise):
            there = described / first if first != 0.0 else 1.0
            body = (more - there * pushed) / (fell.rise - there * rise)
            if not rough and inertia is not None:
                body = min(body, ROUGH * inertia)
            weight = more - body * fell.rise
            if body > 0.0 and (found is None or abs(weight - more) > abs(found.torque - more)):
                return Weighed(weight, abs(weight - more) / (2.0 * SURE), again=True)
        if found is None or not rough or abs(fell.rise) > (1.0 + ALIKE) * abs(rise):
            return found  # something else drives it, too
        far = 2.0 * found.torque - more
        return Weighed(far, abs(far - more) / (2.0 * SURE), found.between)

    def same_way(
        self, axis: int, thought: float, described: float, found: Weighed | None
    ) -> Weighed | None:
        """What was found, or more where the joint fell the same way before, though it was given
        what that fall told: dry friction is taken off whatever a fall tells, and the brake has the
        joint where it weighs otherwise already, so that the next fall tells as little. As many
        times as much is lacking as all those falls found of what the first one did, and no more
        times than it fell. N·m under which it did, and that its description says there."""
        if found is None or found.torque == thought:
            return found
        lacked, more, besides = self._lacked[axis], found.torque - thought, thought - described
        if lacked:
            before, told = lacked[-1]
            given = (besides - before) / told
            if told * more < 0.0 or given < GIVEN:
                lacked.clear()
        lacked.append((besides, more))
        times = min(float(len(lacked)), sum(one for _, one in lacked) / lacked[0][1])
        if len(lacked) < 2 or found.again:
            return found
        weight = thought + times * more
        return Weighed(weight, max(found.error, abs(weight - found.torque) / SURE), again=True)

    def between(
        self,
        axis: int,
        under: tuple[float, float],
        described: float,
        way: float,
        found: Weighed | None,
    ) -> Weighed | None:
        """What was found, or the middle of what is left where it was tried before that it is not,
        or hardly: what takes a joint along, or slows it, spoils each fall alike.
        way: rad that it went ``under`` so many N·m, at least and at most, since it stood last,
        described: N·m. A joint that its servo throws up may weigh more than was thought, if no more
        than what threw it."""
        if described == 0.0:
            return found
        if found is not None and not 1.0 / MOST <= found.torque / described <= MOST:
            self._low[axis], self._high[axis] = -np.inf, np.inf  # bodies are not all that is wrong
            return found
        heavier = way * described < 0.0
        share = (min if heavier else max)(one / described for one in under)
        if not 1.0 / MOST <= share <= MOST:
            return found
        bounds = (self._low, self._high) if heavier else (self._high, self._low)
        nearest = max if heavier else min
        bounds[0][axis] = nearest(share, float(bounds[0][axis]))
        if self._low[axis] >= self._high[axis]:  # it weighs otherwise by now
            bounds[0][axis], bounds[1][axis] = share, np.inf if heavier else -np.inf
        low, high = float(self._low[axis]), float(self._high[axis])
        if not np.isfinite([low, high]).all():
            return found
        edge = EDGE * (high - low)
        if found is not None and low + edge < found.torque / described < high - edge:
            return found
        middle = 0.5 * (low + high) * described
        return Weighed(middle, 0.5 * (high - low) * abs(described) / SURE, again=True)


def _still(time: Array, q: Array) -> int:
    """The last row in which a joint stood, or hardly moved beside how fast it is: in its brake,
    which may slip and drag before it opens. Torque had come up by then."""
    speed = np.abs(np.diff(q)) / np.diff(time)
    stands = speed < max(CREEPS, HARDLY * float(speed[-1])) if len(speed) else speed > 0.0
    return int(np.flatnonzero(stands)[-1]) + 1 if stands.any() else 0


def weight_of(time: Array, q: Array, sent: Array) -> Weighed | None:
    """time: (N,) s; q: (N,) rad; sent: (N,) N·m that act from then on. None where it cannot be
    told, or where torque does not push the way it should."""
    rows = _falling(time, q, sent)
    if rows is None or len(rows[0]) < FEWEST:
        return None
    speed, middle, pushed = rows
    found, covariance = _fitted(speed, np.stack([np.ones_like(middle), middle, pushed], axis=1))
    _, a, c = found
    if not c > SURE * np.sqrt(covariance[2, 2]):
        return None
    slope = np.array([0.0, -1.0 / c, a / c**2])
    return Weighed(float(sent[0] - a / c), float(np.sqrt(slope @ covariance @ slope)))


def roughly(time: Array, q: Array, sent: Array, inertia: float) -> Weighed | None:
    """The same of a joint that is presumed to have this inertia, kg·m². None where its own torque
    does not push the way it should, or nothing is surely lacking."""
    rows = _falling(time, q, sent)
    if rows is None:
        return None
    speed, middle, pushed = rows
    sloped = _by_slope(speed, middle, pushed, inertia) if len(speed) >= FEW else None
    least, most = sloped or _by_way(driven(time, q, sent), float(sent[0]), inertia)
    if least * most <= 0.0 or abs(most) > WIDEST * abs(least):
        return None
    if len(speed) >= FEWEST:
        columns = np.stack([np.ones_like(middle), middle, pushed], axis=1)
        found, covariance = _fitted(speed, columns)
        if found[2] < -SURE * np.sqrt(covariance[2, 2]):
            return None
    return _lacked(float(sent[0]), least, most)


def _lacked(begin: float, least: float, most: float) -> Weighed | None:
    """What holds a joint that lacked so many N·m, at least and at most, of what it began with."""
    if least * most <= 0.0 or abs(most) > WIDEST * abs(least):
        return None
    taken = 2.0 * least * most / (least + most)
    error = max(abs(taken - least), abs(most - taken)) / SURE
    return Weighed(begin + taken, error, (begin + least, begin + most))


def _by_slope(
    speed: Array, middle: Array, pushed: Array, inertia: float
) -> tuple[float, float] | None:
    """N·m that may have been lacking, least and most, by how it gathered speed; None: unsure."""
    columns = np.stack([np.ones_like(middle), middle], axis=1)
    lacking: list[float] = []
    for body in (inertia / ROUGH, inertia * ROUGH):
        found, covariance = _fitted(speed - pushed / body, columns)
        doubt = SURE * np.sqrt(covariance[1, 1])
        lacking += [float(-body * (found[1] + sign * doubt)) for sign in (-1.0, 1.0)]
    least, most = sorted([min(lacking), max(lacking)], key=abs)
    return None if least * most <= 0.0 or abs(most) > WIDEST * abs(least) else (least, most)


def _by_way(fell: Driven | None, begin: float, inertia: float) -> tuple[float, float]:
    """The same of what was lacking to ``begin`` N·m; zeros: nobody knows."""
    if fell is None:
        return 0.0, 0.0
    more = fell.torque - begin
    ends = [more - body * fell.rise for body in (inertia / ROUGH, inertia * ROUGH)]
    least, most = sorted(ends, key=abs)
    return least, most


def driven(time: Array, q: Array, sent: Array) -> Driven | None:
    """By what speed it has and how far it got: ½·J·v² = ∫(u - w)dx from rest, whenever that was. It
    needs no more than two periods, and a spring that unwinds, which spoils any slope, matters less.
    None where it got much slower, or turned round: something else has moved it."""
    way, speed = np.diff(q), np.diff(q) / np.diff(time)
    moves = np.flatnonzero(np.abs(q[1:] - q[0]) > STIRS)
    gains = np.abs(speed[moves])
    if len(moves) < 2 or (way[moves] * way[-1] <= 0.0).any():
        return None
    if gains[-1] < SLOWED * gains.max():
        return None
    half = np.append(np.ones(len(way) - 1), 0.5)  # up to where the last speed is that of
    far = float(half @ way)
    return Driven(float((half * way) @ sent[:-1]) / far, float(speed[-1]) ** 2 / (2.0 * far))


def swinging(time: Array, q: Array, sent: Array) -> Driven | None:
    """By how far it got since it was at its place last, and by when. A light rotor swings on its
    spring as its link falls: its speed tells nothing of that. None where it was farther before, or
    went one way only, which ``driven`` tells better."""
    way = q - q[0] if len(q) else q
    if len(way) < FEWEST or np.abs(way).argmax() != len(way) - 1:
        return None
    if (np.sign(way[-1]) * np.diff(way) > -STIRS).all():
        return None
    return Driven(float(sent[:-1].mean()), float(2.0 * way[-1] / (time[-1] - time[0]) ** 2), True)


def _falling(time: Array, q: Array, sent: Array) -> tuple[Array, Array, Array] | None:
    """(K,) each of the periods in which it falls: rad/s, s at their middles, and N·m·s by which it
    was pushed until then beyond what it began with."""
    away = np.flatnonzero(np.abs(q - q[0]) > LEFT) if len(q) else np.zeros(0, dtype=np.int64)
    if not len(away):
        return None
    gap, fall = np.diff(time), slice(int(away[0]), None)
    more = gap * (sent[:-1] - sent[0])
    middle = 0.5 * (time[1:] + time[:-1]) - time[0]
    return (np.diff(q) / gap)[fall], middle[fall], (np.cumsum(more) - 0.5 * more)[fall]


def _fitted(speed: Array, columns: Array) -> tuple[Array, Array]:
    """Least squares, and their covariance."""
    found = np.asarray(np.linalg.lstsq(columns, speed, rcond=None)[0], dtype=float)
    left = speed - columns @ found
    noise = float(left @ left) / (len(columns) - len(found))
    return found, np.asarray(noise * np.linalg.pinv(columns.T @ columns), dtype=float)
