"""One side of the question: the runs a fit sees, or the runs it is judged on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.effects import Context, Effect, Shape
from pa10d.effects.together import columns_once
from pa10d.measurement.torque_filter import TorqueFilter
from pa10d.model import Term, TorqueModel
from pa10d.regression.equation import RunEquation
from pa10d.regression.per_joint import Mask, PerJoint, gathered
from pa10d.regression.shared_surfaces import where_shared_slips
from pa10d.regression.winding import seen_by

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Side:
    """Kept samples of several runs, joint by joint: standstill masks differ between joints.

    runs      the equations, in order
    contexts  their motion, with the loads and torques of the model that they are seen through
    silent    joints of which no sample counts, and why
    all_moments  the same before moments were left out in which what joints share sticks
    kept_by_evidence  of run and joint: what evidence works out of their motion alone
    """

    runs: tuple[RunEquation, ...]
    contexts: tuple[Context, ...]
    silent: Mapping[int, str] = field(default_factory=dict)
    all_moments: Side | None = None
    kept_by_evidence: dict[tuple[int, int], Any] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, runs: Sequence[RunEquation], silent: Mapping[int, str] | None = None) -> Side:
        """Seen through no model yet."""
        return cls(tuple(runs), tuple(run.context for run in runs), silent or {})

    @property
    def n(self) -> int:
        """Joints."""
        return self.runs[0].tau.shape[1]

    @cached_property
    def keep(self) -> list[Mask]:
        """Per run (M, n): which samples count."""
        if not self.silent:
            return [run.keep for run in self.runs]
        heard = ~np.isin(np.arange(self.n), list(self.silent))
        return [run.keep & heard for run in self.runs]

    def simple_motion(self, run: int, joint: int) -> Array:
        """(M, k) simple functions of a run's motion that a joint's error may go with."""
        equation, context = self.runs[run], self.contexts[run]
        q, dq = (x[:: equation.lowpass.factor] for x in (context.q, context.dq))
        own, way, torque = q[:, joint], np.sign(dq[:, joint]), equation.tau[:, joint]
        speed = dq[:, joint]
        return np.column_stack([
            np.sin(q), np.cos(q), np.sin(2.0 * own), np.cos(2.0 * own), speed, np.abs(speed),
            way, own * way, torque, np.abs(torque) * way,
        ])  # fmt: skip

    @cached_property
    def tau(self) -> list[Array]:
        """Joint -> (m_j,) filtered torque."""
        return [self.gathered([run.driven[:, j] for run in self.runs], j) for j in range(self.n)]

    def shifted(self, seconds: float) -> Side:
        """The same with the torque of all runs taken ``seconds`` later than it is now."""
        return self._of_runs(lambda run: run.later(seconds))

    def behind(self, channel: TorqueFilter | None) -> Side:
        """The same with columns that pass such a torque channel."""
        return self._of_runs(lambda r: replace(r, lowpass=replace(r.lowpass, channel=channel)))

    def where_shared_slips(self, terms: Sequence[Term]) -> Side:
        """The same without moments in which surfaces stick that any of these terms share."""
        whole = self.everywhere
        runs = tuple(where_shared_slips(run, terms) for run in whole.runs)
        if all(run is one for run, one in zip(runs, whole.runs, strict=True)):
            return replace(whole, contexts=self.contexts)
        return replace(self, runs=runs, all_moments=whole, kept_by_evidence={})

    @property
    def everywhere(self) -> Side:
        """The same with all moments in which joints move, whatever they share."""
        return self.all_moments or self

    def _of_runs(self, changed: Callable[[RunEquation], RunEquation]) -> Side:
        """The same of changed runs."""
        whole = None if self.all_moments is None else self.all_moments._of_runs(changed)
        runs = tuple(changed(run) for run in self.runs)
        return replace(self, runs=runs, all_moments=whole, kept_by_evidence={})

    def where(self, keep: Sequence[Mask]) -> Side:
        """The same with no samples but these (M, n) per run."""
        runs = [
            replace(run, keep=run.keep & own, moving=run.moving & own)
            for run, own in zip(self.runs, keep, strict=True)
        ]
        return replace(self, runs=tuple(runs), kept_by_evidence={})

    def rows_within(self, fewer: Side) -> list[Mask]:
        """Joint -> (m_j,): which of its rows another one of the same runs keeps, too."""
        pairs = list(zip(fewer.keep, self.keep, strict=True))
        return [
            np.concatenate([own[:, j][kept[:, j]] for own, kept in pairs]) for j in range(self.n)
        ]

    def through(self, model: TorqueModel) -> Side:
        """The same with the loads and torques of a model."""
        return replace(self, contexts=tuple(seen_by(model, run) for run in self.runs))

    def rigid(self, kept: NDArray[np.int64]) -> PerJoint:
        """Filtered regressor columns."""
        columns = [run.rigid_columns(kept) for run in self.runs]
        return {j: self.gathered([c[:, j] for c in columns], j) for j in range(self.n)}

    def columns_of_runs(self, effect: Effect, joints: Sequence[int], shape: Shape) -> list[Array]:
        """Per run (M, n, k) filtered columns of one effect, rows that do not count included."""
        out = []
        for run, context in zip(self.runs, self.contexts, strict=True):
            raw = effect.columns(context, joints, shape)
            if effect.reaches_other_joints:
                columns = run.filtered(raw)
            else:
                columns = np.zeros((len(run.tau), self.n, raw.shape[-1]))
                columns[:, joints[0]] = run.filtered(raw, joints[0])
            out.append(columns)
        return out

    def columns(
        self, effect: Effect, joints: Sequence[int], shapes: Sequence[Shape], own: bool = False
    ) -> PerJoint:
        """Filtered columns of one effect for several shapes, side by side (k per shape); own: in
        the equation of ``joints[0]`` alone."""
        raw = [effect.columns_of(c, joints, shapes, own) for c in self.contexts]
        return self._filtered(effect, joints, raw, own)

    def columns_of_term(self, term: Term) -> PerJoint:
        """Filtered columns of one term of a model, as exactly as the model predicts with it."""
        raw = [columns_once(term, context) for context in self.contexts]
        return self._filtered(term.effect, term.joints, raw, own=False)

    def _filtered(
        self, effect: Effect, joints: Sequence[int], raw: list[Array], own: bool
    ) -> PerJoint:
        if own or not effect.reaches_other_joints:
            filtered = [run.filtered(x, joints[0]) for run, x in zip(self.runs, raw, strict=True)]
            return {joints[0]: self.gathered(filtered, joints[0])}
        touched = [j for j in range(self.n) if any(np.any(x[:, j]) for x in raw)]
        touched = touched or [joints[0] if joints else 0]  # it has no torque at all: zeros
        out = {}
        for j in touched:
            rows = [run.filtered(x[:, j], j) for run, x in zip(self.runs, raw, strict=True)]
            out[j] = self.gathered(rows, j)
        return out

    def scatter(self, rows: PerJoint) -> list[Array]:
        """Per run (M, n), zeros where nothing is kept: the reverse of gathering one column."""
        out = [np.zeros(run.tau.shape) for run in self.runs]
        for j, values in rows.items():
            start = 0
            for run, keep in zip(out, self.keep, strict=True):
                count = int(keep[:, j].sum())
                run[keep[:, j], j] = values[start : start + count]
                start += count
        return out

    def stretches(self, joint: int, rows: Array) -> list[tuple[Array, Mask]]:
        """Per run (M,) rows (m_j,) of one joint, zeros where nothing is kept, and where it is."""
        scattered = self.scatter({joint: rows})
        return [(r[:, joint], k[:, joint]) for r, k in zip(scattered, self.keep, strict=True)]

    def spread(self, joint: int, rows: Array) -> list[Array]:
        """Per run (M, k) rows (m_j, k) of one joint, zeros where nothing is kept."""
        out, start = [], 0
        for keep in (k[:, joint] for k in self.keep):
            out.append(np.zeros((len(keep), rows.shape[1])))
            stop = start + int(keep.sum())
            out[-1][keep], start = rows[start:stop], stop
        return out

    def gathered(self, per_run: Sequence[Array], joint: int) -> Array:
        """(m_j, …): of the runs (M, …) the rows that count for a joint."""
        return gathered(per_run, self.keep, joint)
