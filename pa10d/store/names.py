"""Names and ids of stored things: how they are made, and which one a person means."""

from __future__ import annotations

import contextlib
import re
import secrets
from collections.abc import Collection, Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Protocol, TypeVar

from pa10d.common.errors import UserError
from pa10d.common.words import did_you_mean

_FORBIDDEN = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff/\\]")
_STAMPED = re.compile(r"([0-9]{8}-[0-9]{6}(?:[0-9]{3})?)-")
STAMP = len("20260131-134500123")
MOMENT = timedelta(milliseconds=1)  # as far as an id tells times apart
LONGEST = 100
LISTED, SHOWN = ("run", "model"), 5  # kinds that have a command to list them; names shown of others


class Named(Protocol):
    """Something stored under an id of ours and a name of the user's."""

    @property
    def id(self) -> str: ...
    @property
    def name(self) -> str: ...


Item = TypeVar("Item", bound=Named)


def new_id(taken: Iterable[str] = ()) -> str:
    """Unique, and sorts after all that are taken: 20260131-134500123-9f3a07."""
    return f"{stamp_after(taken)}-{secrets.token_hex(3)}"


def stamp_after(taken: Iterable[str]) -> str:
    """The time, with which names begin that are to sort after all that are taken: a clock that was
    set back would make what is new the oldest, so it is passed over."""
    now = datetime.now(UTC).replace(tzinfo=None)
    stamps = [found[1] for name in taken if (found := _STAMPED.match(name))]
    with contextlib.suppress(ValueError, OverflowError):  # of no calendar, or of its last day
        if stamps:
            last = datetime.strptime(max(stamps).ljust(STAMP, "0"), "%Y%m%d-%H%M%S%f")
            now = max(now, last + MOMENT)
    return f"{now:%Y%m%d-%H%M%S}{now.microsecond // 1000:03d}"


def checked_name(name: str) -> str:
    """The name itself, or UserError where it cannot be one."""
    if not name or name != name.strip() or len(name) > LONGEST or _FORBIDDEN.search(name):
        raise UserError(
            f"name {name!r}: expected 1 to {LONGEST} characters without slashes, control "
            "characters and blanks at either end"
        )
    if name.startswith((".", "-")):
        raise UserError(f"name {name!r}: expected a first character other than '{name[0]}'")
    return name


def free_name(wanted: str, taken: Collection[str]) -> str:
    """``wanted``, or ``wanted-2``, ``wanted-3`` … whichever is not taken."""
    name, k = wanted, 1
    while name in taken:
        k += 1
        name = f"{wanted}-{k}"
    return name


def resolve(wanted: str, items: Sequence[Item], kind: str) -> Item:
    """The item with this id, else this exact name, else this unique start of an id. The id first:
    who writes a whole one, as the page does, means no other item that somebody named so."""
    for key in ("id", "name"):
        same = [item for item in items if getattr(item, key) == wanted]
        if same:
            return max(same, key=lambda item: item.id)
    starts = [item for item in items if wanted and item.id.startswith(wanted)]
    if len(starts) == 1:
        return starts[0]
    if starts:
        some = ", ".join(f"{item.id} ({item.name})" for item in starts[:3])
        more = " …" if len(starts) > 3 else ""
        raise UserError(f"{kind} {wanted!r}: {len(starts)} ids begin so: {some}{more}")
    meant = did_you_mean(wanted, [item.name for item in items])
    raise UserError(f"{kind} {wanted!r}: none of this name or id; {_there(items, kind)}{meant}")


def _there(items: Sequence[Item], kind: str) -> str:
    """What there is, or the command that shows it."""
    if kind in LISTED:
        return f"'pa10d {kind} list' shows what there is"
    names = [item.name for item in sorted(items, key=lambda item: item.id)]
    if not names:
        return "there is none"
    return f"there are {', '.join(names[-SHOWN:])}{' and older ones' if names[SHOWN:] else ''}"
