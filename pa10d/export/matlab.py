"""A model as a MATLAB function: straight-line code that Octave reads, too."""

from __future__ import annotations

from pa10d.export.c_header import identifier
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
    "negative": "-{}", "absolute": "abs({})", "power": "{} ^ {}", "sin": "sin({})",
    "cos": "cos({})", "tanh": "tanh({})", "exp": "exp({})", "sqrt": "sqrt({})", "log": "log({})",
    "arcsin": "asin({})", "sign": "sign({})", "maximum": "max({}, {})", "minimum": "min({}, {})",
    "greater": "double({} > {})", "greater_equal": "double({} >= {})",
    "less": "double({} < {})", "less_equal": "double({} <= {})",
    "where": "({0} ~= 0) * {1} + ({0} == 0) * {2}",
}  # fmt: skip
MATLAB = Language(
    OPERATORS,
    "  {name} = {value};",
    "  tau(end + 1) = {value};",
    lambda name, joint: f"{name}({joint + 1})",
)

FUNCTION = """\
function [tau, gravity] = {id}(q, dq, ddq)
% Joint torques of {name}: {about}.
%
% Written by pa10d.
%
%   tau = {id}(q, dq, ddq)                1 x {n}, feed-forward torque of a wanted motion
%   [tau, gravity] = {id}(q, dq, ddq)     and what holds the arm where it stands
%
% Joints, in this order: {joints}
% Units: rad (m), rad/s, rad/s^2, N m (N) at the joint side.
{notes}
  tau = [];
{torque}
  feed_forward = tau;
  tau = [];
{gravity}
  gravity = tau;
  tau = feed_forward;
end
"""


def matlab_function(model: TorqueModel, about: str) -> tuple[str, list[str]]:
    """The function's text, and one line per effect that it cannot carry."""
    kept, lost = traceable(model)
    torque, gravity = predicted(TracedModule(kept))
    told = [*forgotten(kept), *(f"NOT CARRIED: {line}" for line in lost)]
    text = FUNCTION.format(
        name=model.name,
        about=about,
        id=identifier(model.name),
        joints=", ".join(model.robot.joint_names),
        n=model.robot.n,
        notes="".join(f"% {line}\n" for line in told),
        torque=statements(torque, MATLAB),
        gravity=statements(gravity, MATLAB),
    )
    return text, lost
