"""Weights as they are written on the command line: MASS,X,Y,Z."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pa10d.cli.commands import WrongUsage
from pa10d.common.errors import UserError

if TYPE_CHECKING:
    from pa10d.identify.scale import Body


def body_of(text: str, option: str) -> Body:
    """What is written there; WrongUsage where it is no weight, whatever the data are."""
    from pa10d.identify.scale import Body

    try:
        return Body.of(text)
    except UserError as error:
        raise WrongUsage(f"{option}: {error}") from error
