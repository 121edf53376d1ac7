"""Backends and plants by name: what a profile names in one line is found here."""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from pa10d.common.errors import UserError

if TYPE_CHECKING:
    from backends.device import Device
    from backends.protocol import Backend
    from pa10d.profile import Profile

BUILT_IN = {
    "canopen_cia402": "backends.canopen_cia402:open_backend",
    "replay": "pa10d.replay:open_backend",
}


def load_object(reference: str, where: str) -> Any:
    """The object behind ``package.module:name``; ``where`` names file and key for the error."""
    module, _, name = reference.partition(":")
    if not module or not name:
        raise UserError(f"{where}: found '{reference}', expected 'package.module:name'")
    try:
        return getattr(import_module(module), name)
    except ModuleNotFoundError as error:
        raise UserError(f"{where}: '{reference}': no module named '{error.name}'") from error
    except AttributeError as error:
        raise UserError(f"{where}: '{reference}': {module} has no '{name}'") from error


def open_backend(profile: Profile) -> Backend:
    """The backend that ``profile.backend`` names, made but not yet connected (see ``open``).

    A name is looked up among the built-in ones and the entry points of ``pa10d.backends``;
    ``package.module:factory`` names any other. The factory takes the profile.
    """
    return load_object(*_reference(profile))(profile)


def device(profile: Profile) -> Device:
    """What is known of the profile's kind of device without opening it."""
    from backends.device import PLAIN

    reference, where = _reference(profile)
    load_object(reference, where)
    return getattr(sys.modules[reference.partition(":")[0]], "DEVICE", PLAIN)


def _reference(profile: Profile) -> tuple[str, str]:
    """``module:factory`` of the profile's backend, and where it is named."""
    where, name = f"{profile.path}: backend", profile.backend
    if ":" in name:
        return name, where
    found = {e.name: e.value for e in entry_points(group="pa10d.backends")} | BUILT_IN
    if name not in found:
        known = ", ".join(sorted(found))
        raise UserError(f"{where}: found '{name}', expected one of {known} or 'module:factory'")
    return found[name], where
