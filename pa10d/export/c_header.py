"""A model as one C header: straight-line code, no allocation, no dependency but math.h."""

from __future__ import annotations

import re
from collections.abc import Sequence

from pa10d.export.straight_line import (
    Language,
    TracedModule,
    forgotten,
    predicted,
    statements,
    traceable,
)
from pa10d.model import TorqueModel

OPERATORS = {
    "add": "{} + {}", "subtract": "{} - {}", "multiply": "{} * {}", "divide": "{} / {}",
    "negative": "-{}", "absolute": "fabs({})", "power": "pow({}, {})", "sin": "sin({})",
    "cos": "cos({})", "tanh": "tanh({})", "exp": "exp({})", "sqrt": "sqrt({})", "log": "log({})",
    "arcsin": "asin({})", "sign": "(double)(({0} > 0.0) - ({0} < 0.0))",
    "maximum": "fmax({}, {})", "minimum": "fmin({}, {})",
    "greater": "(double)({} > {})", "greater_equal": "(double)({} >= {})",
    "less": "(double)({} < {})", "less_equal": "(double)({} <= {})",
    "where": "({} != 0.0 ? {} : {})",
}  # fmt: skip
C = Language(
    OPERATORS,
    "    const double {name} = {value};",
    "    tau[{joint}] = {value};",
    lambda name, joint: f"{name}[{joint}]",
)

HEADER = """\
/* Joint torques of {name}: {about}.
 *
 * Written by pa10d. One header, no allocation, no state: call it from any loop.
 *
 *     {id}_torque(q, dq, ddq, tau)     feed-forward torque of a wanted motion
 *     {id}_gravity(q, tau)             what holds the arm where it stands, friction not counted
 *
 * Joints, in this order: {joints}
 * Units: rad (m), rad/s, rad/s^2, N m (N) at the joint side.
{notes} */
#ifndef {guard}
#define {guard}

#include <math.h>

#define {guard}_JOINTS {n}

static inline void {id}_torque(const double q[{n}], const double dq[{n}], const double ddq[{n}],
                               double tau[{n}])
{{
{torque}
}}

static inline void {id}_gravity(const double q[{n}], double tau[{n}])
{{
{gravity}
}}

#endif
"""


def c_header(model: TorqueModel, about: str) -> tuple[str, list[str]]:
    """The header's text, and one line per effect that it cannot carry."""
    kept, lost = traceable(model)
    torque, gravity = predicted(TracedModule(kept))
    name = identifier(model.name)
    told = [*forgotten(kept), *(f"NOT CARRIED: {line}" for line in lost)]
    text = HEADER.format(
        name=_comment(model.name),
        about=_comment(about),
        id=name,
        guard=f"PA10D_{name.upper()}_H",
        joints=_comment(", ".join(model.robot.joint_names)),
        n=model.robot.n,
        notes="".join(f" * {_comment(line)}\n" for line in told),
        torque=_body(statements(torque, C), ("q", "dq", "ddq")),
        gravity=_body(statements(gravity, C), ("q",)),
    )
    return text, lost


def _body(code: str, arguments: Sequence[str]) -> str:
    """Compilers that warn of everything are told which arguments stay unused, as where the weight
    of an arm that slides is the same everywhere."""
    unused = [name for name in arguments if not re.search(rf"\b{name}\[", code)]
    return "\n".join([*(f"    (void){name};" for name in unused), code])


def identifier(name: str) -> str:
    """A model's name as programs allow it."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return plain if plain[0].isalpha() else f"model_{plain}"


def _comment(text: str) -> str:
    return text.replace("*/", "* /")
