"""Rooms that are also questions: ``pa10d.compare`` is a package, and ``pa10d.compare(…)`` works.

Importing a subpackage sets its name in ``pa10d``, whatever stood there. So that the public face
does not depend on who imported what before, the package itself answers when it is called.
"""

from __future__ import annotations

import importlib
import inspect
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any


class CallableRoom(ModuleType):
    # A package that passes calls on to the function of the public face, and is helped by its words:
    # whoever asks for help with ``pa10d.compare`` wants to know what it takes.

    _called: str

    def __call__(self, *given: Any, **named: Any) -> Any:
        return self._function(*given, **named)

    @property
    def __doc__(self) -> str:  # type: ignore[override]
        name = self._function.__name__
        said = inspect.getdoc(self._function)
        return f"{vars(self)['__doc__']}\n\npa10d.{name}{self.__signature__}\n\n{said}"

    @property
    def __signature__(self) -> inspect.Signature:
        return inspect.signature(self._function)

    @property
    def _function(self) -> Callable[..., Any]:
        module, _, name = self._called.partition(":")
        found: Callable[..., Any] = getattr(importlib.import_module(module), name)
        return found


def answer_calls(room: str, function: str) -> None:
    """Make the package ``room`` callable; ``function``: ``module:name``, loaded when called."""
    module = sys.modules[room]
    module.__class__ = CallableRoom
    module._called = function  # type: ignore[attr-defined]
