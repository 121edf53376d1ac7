"""What a diagnosis says, as objects and as JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.structure import Structure
from pa10d.effects import Value
from pa10d.model import Term, TorqueModel

Array = NDArray[np.float64]
Verdict = Literal["missing", "none", "unknown"]


@dataclass(frozen=True)
class Confusion:
    """Another explanation that this data cannot tell from the finding."""

    effect: str
    joints: tuple[int, ...]
    why: str


@dataclass(frozen=True)
class Finding:
    """One missing effect (or change), on top of the findings before it.

    rms_before, rms_after: (n,) N·m held out, refitted without and with it
    size: N·m RMS of its torque on the held-out side where it acts, and its standard error
    slope: of the held-out residual on the predicted change; 1 for a true effect
    """

    term: Term
    parameters: dict[str, Value]
    rms_before: Array
    rms_after: Array
    p_value: float
    slope: float
    size: Value
    confounded_with: tuple[Confusion, ...]
    next_experiment: dict[str, Any] | None
    sentence: str

    def document(self) -> dict[str, Any]:
        """As INTERFACES has it, and a little more."""
        return {
            "effect": self.term.effect_id,
            "joints": [j + 1 for j in self.term.joints],
            "parameters": {
                name: {"value": v.value, "std_error": v.std_error, "unit": v.unit}
                for name, v in self.parameters.items()
            },
            "rms_before": self.rms_before.tolist(),
            "rms_after": self.rms_after.tolist(),
            "p_value": self.p_value,
            "slope": self.slope,
            "size": {
                "value": self.size.value,
                "std_error": self.size.std_error,
                "unit": self.size.unit,
            },
            "confounded_with": [
                {"effect": c.effect, "joints": [j + 1 for j in c.joints], "why": c.why}
                for c in self.confounded_with
            ],
            "next_experiment": self.next_experiment,
            "sentence": self.sentence,
        }


@dataclass(frozen=True)
class Diagnosis:
    """The whole answer.

    rms, noise_floor: (n,) N·m of the given model (refitted, unless frozen) on the held-out side
    model: with all findings fitted in; versions: one model per step, the given one first
    to_store: the same fitted to all motion, as identification does, for use outside the search
    judged_on: in words, which data the fit has not seen
    """

    verdict: Verdict
    rms: Array
    noise_floor: Array
    cutoff: float
    findings: tuple[Finding, ...]
    unexplained: tuple[Structure, ...]
    model: TorqueModel
    versions: tuple[TorqueModel, ...]
    to_store: tuple[TorqueModel, ...]
    judged_on: str
    frozen: bool
    warnings: tuple[str, ...] = field(default=())

    def document(self) -> dict[str, Any]:
        """JSON of ``diagnose``."""
        return {
            "verdict": self.verdict,
            "rms": self.rms.tolist(),
            "noise_floor": self.noise_floor.tolist(),
            "cutoff_hz": self.cutoff,
            "findings": [f.document() for f in self.findings],
            "unexplained": [
                {
                    "joint": s.joint + 1,
                    "depends_on": list(s.variables),
                    "share": s.share,
                    "rms": s.rms,
                    "p_value": s.p_value,
                }
                for s in self.unexplained
            ],
            "judged_on": self.judged_on,
            "frozen": self.frozen,
            "warnings": list(self.warnings),
        }
