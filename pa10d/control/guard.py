"""Calls into a backend: what breaks in there is said to have broken in there, and where."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from backends.protocol import Backend, BackendFault, Feedback
from pa10d.common.errors import UserError

P = ParamSpec("P")
T = TypeVar("T")


class BackendBroke(Exception):
    """Code behind the protocol threw what is no BackendFault; ``__cause__`` is what it threw."""

    def __init__(self, call: str, error: BaseException) -> None:
        text = " ".join(str(error).split())
        said = f"{type(error).__name__}: {text}" if text else type(error).__name__
        super().__init__(f"the backend broke in '{call}': {said}")


def asked(call: str, do: Callable[P, T], *arguments: P.args, **more: P.kwargs) -> T:
    """What ``do`` returns; BackendFault and UserError as they are, all else as BackendBroke.

    SystemExit too: a library that gives up must not take the loop with it that holds the arm.
    """
    try:
        return do(*arguments, **more)
    except (BackendFault, UserError):
        raise
    except (Exception, SystemExit) as error:
        raise BackendBroke(call, error) from error


def read(backend: Backend) -> Feedback:
    """One cycle's feedback, with an array of numbers for every joint."""
    feedback = backend.read()
    for name in ("q", "tau", "status", "age"):
        values = getattr(feedback, name)
        if values.shape != (backend.n,) or values.dtype.kind not in "fiu":
            raise ValueError(
                f"{name} has shape {values.shape} of {values.dtype}, expected {backend.n} numbers"
            )
    return feedback
