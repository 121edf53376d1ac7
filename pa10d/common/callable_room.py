"""Rooms that are also questions: ``pa10d.compare`` is a package, and ``pa10d.compare(…)`` works.

Importing a subpackage sets its name in ``pa10d``, whatever stood there. So that the public face
does not depend on who imported what before, the package itself answers when it is called.
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import Any


class CallableRoom(ModuleType):
    """A package that passes calls on to the function of the public face."""

    _called: str

    def __call__(self, *given: Any, **named: Any) -> Any:
        module, _, name = self._called.partition(":")
        return getattr(importlib.import_module(module), name)(*given, **named)


def answer_calls(room: str, function: str) -> None:
    """Make the package ``room`` callable; ``function``: ``module:name``, loaded when called."""
    module = sys.modules[room]
    module.__class__ = CallableRoom
    module._called = function  # type: ignore[attr-defined]
