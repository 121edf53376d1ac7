"""What somebody knows of single parameters, from a data sheet or a scale: ``Fc3 = 12 ± 2``.

A name is a row of the table of parameters (``coulomb J3: Fc``, or ``Fc3`` for short), or a body's
own figure (``link J7: m``; ``m7`` where the table has no row of that name). A row of the table
is what torque shows: where it stands for a sum of several bodies' figures, so does what is given.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pa10d.common.errors import UserError
from pa10d.common.words import did_you_mean, listed
from pa10d.dynamics.base import parameter_name
from pa10d.dynamics.robot import PARAMETER_NAMES
from pa10d.regression.layout import Layout

UNSIGNED = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
NUMBER = rf"[-+]?{UNSIGNED}"
STATEMENT = re.compile(
    rf"\s*(?P<name>[^=]*[^=\s])\s*=\s*(?P<value>{NUMBER})\s*(?:±|\+/?-)\s*"
    rf"(?P<error>{UNSIGNED}|inf)\s*(?P<percent>%)?\s*"
)


@dataclass(frozen=True)
class Given:
    """value ± std_error (one standard deviation, SI) of an unknown or of a body's own figure.

    unknown: where it stands among the layout's; body: which standard parameter it is (link-major);
    one of them is None
    """

    name: str
    value: float
    std_error: float
    unknown: int | None = None
    body: int | None = None


def read_given(text: str) -> tuple[str, float, float]:
    """``Fc3=12±2``, ``Fc3 = 12 +- 10 %`` → name, value, standard error."""
    found = STATEMENT.fullmatch(text)
    if found is None:
        raise UserError(f"prior {text!r}: expected NAME=VALUE±ERROR, such as Fc3=12±2 or Fc3=12+-2")
    value, error = float(found["value"]), float(found["error"])
    return found["name"], value, error * abs(value) / 100 if found["percent"] else error


def placed(layout: Layout, statements: Iterable[tuple[str, float, float]]) -> tuple[Given, ...]:
    """The statements, each at its place; one without an end to its doubt says nothing."""
    told, out = list(statements), list[Given]()
    if not told:
        return ()
    names = _Names(layout)
    for name, value, error in told:
        if not np.isfinite(value) or np.isnan(error) or error < 0:
            raise UserError(
                f"prior {name}={value:g}±{error:g}: expected a value and an error of at least 0"
            )
        given = names.find(name, float(value), float(error))
        if any(given.name == other.name for other in out):
            raise UserError(f"prior: {given.name} is given twice, expected once")
        out.append(given)
    return tuple(one for one in out if np.isfinite(one.std_error))


class _Names:
    """What the parameters of a layout may be called."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.full = layout.names()
        self.links = {
            f"link J{j + 1}: {name}": 10 * j + k
            for j in range(layout.robot.n)
            for k, name in enumerate(PARAMETER_NAMES)
        }
        self.short = self._short()
        self.unknowns = {_plain(name): i for i, name in enumerate(self.full)}
        self.unknowns |= {_plain(s): p[0] for s, p in self.short.items() if len(p) == 1}
        self.bodies = {_plain(name): k for name, k in self.links.items()}
        self.bodies |= {_plain(parameter_name(int(k))): int(k) for k in layout.base.dropped}

    def _short(self) -> dict[str, list[int]]:
        """``Fc3``: places of the coefficients of that name on joint 3."""
        out: dict[str, list[int]] = {}
        for term, place in zip(self.layout.terms, self.layout.places, strict=True):
            joint = "".join(str(j + 1) for j in term.joints) if len(term.joints) < 2 else None
            for k, coefficient in enumerate(term.effect.coefficients):
                if joint is not None:
                    out.setdefault(f"{coefficient.name}{joint}", []).append(place.start + k)
        return out

    def find(self, name: str, value: float, error: float) -> Given:
        wanted = _plain(name)
        if wanted in self.unknowns:
            i = self.unknowns[wanted]
            return Given(self.full[i], value, error, unknown=i)
        if wanted in self.bodies:
            k = self.bodies[wanted]
            own = next(long for long, place in self.links.items() if place == k)
            return Given(own, value, error, body=k)
        raise UserError(f"prior {name}: {self._why_not(name, wanted)}")

    def _why_not(self, name: str, wanted: str) -> str:
        for short, places in self.short.items():
            if _plain(short) == wanted:
                return f"expected one of {listed([self.full[i] for i in places], 'or')}"
        for term in self.layout.terms:
            for shape in term.effect.shapes:
                one = f"{shape.name}{''.join(str(j + 1) for j in term.joints)}"
                if wanted in (_plain(one), _plain(term.named(shape.name))):
                    return (
                        f"a shape, which is searched for before the least squares, expected one of "
                        f"{self._known()}"
                    )
        rotor = re.fullmatch(r"(?:rotor_inertiaj(\d+):)?ia(\d*)", wanted)
        joint = int(next(filter(None, rotor.groups()), "0")) if rotor else 0
        if 0 < joint <= self.layout.robot.n:
            return (
                f"joint {joint}'s rotor is one with its link, torque shows their sum; "
                f"expected one of {self._known()}"
            )
        links = [parameter_name(k) for k in range(10 * self.layout.robot.n)]
        close = did_you_mean(name, [*self.short, *links, *self.full, *self.links])
        return f"no parameter of this model{close or ''}; expected one of {self._known()}"

    def _known(self) -> str:
        """``Fc1–7, Fv1–7, Izz1, mx2 3 …``: all rows of the table in one line."""
        where: dict[str, list[int]] = {}
        rest: list[str] = []
        short = {p[0]: s for s, p in self.short.items() if len(p) == 1}
        for i, full in enumerate(self.full):
            stem = re.fullmatch(r"([A-Za-z_]+?)(\d+)", short.get(i, full))
            if stem is None:
                rest.append(full)
            else:
                where.setdefault(stem[1], []).append(int(stem[2]))
        said = [f"{stem}{_ranges(sorted(joints))}" for stem, joints in where.items()]
        return f"{', '.join([*said, *rest])}, or a link's own (link J1: m)"


def _plain(name: str) -> str:
    return re.sub(r"[\s]+", "", name).lower()


def _ranges(numbers: Sequence[int]) -> str:
    """``1–3 7``."""
    cuts = [0, *(k + 1 for k, (a, b) in enumerate(pairwise(numbers)) if b > a + 1), len(numbers)]
    parts = [numbers[a:b] for a, b in pairwise(cuts)]
    return " ".join(str(p[0]) if len(p) == 1 else f"{p[0]}–{p[-1]}" for p in parts)
