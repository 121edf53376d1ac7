"""Stamps that are written as dates or times of day, as seconds since the first of them."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Sequence

import numpy as np

from pa10d.store.channels import Array

_MOMENT = re.compile(
    r"(?:(?:(?P<y>\d{4})[-/](?P<mo>\d\d?)[-/](?P<d>\d\d?)|"
    r"(?P<d2>\d\d?)\.(?P<mo2>\d\d?)\.(?P<y2>\d{4})|"
    r"(?P<a3>\d\d?)/(?P<b3>\d\d?)/(?P<y3>\d{4}))[T ]\s*)?"
    r"(?:(?P<run>\d{1,4}) days?,? )?"
    r"(?P<h>\d\d?):(?P<m>\d\d)(?::(?P<s>\d\d)(?:[.,](?P<f>\d{1,9}))?)?"
    r"\s*(?P<half>[AaPp][Mm])?\s*(?P<zone>Z|[+-]\d\d:?\d\d)?"
)
DAY = 86_400 * 10**9  # ns
LONGEST = 10_000  # days between two stamps, as many as 63 bits of ns hold safely


def seconds_since_first(cells: Sequence[str]) -> Array | None:
    """(N,) from ISO 8601, from 31.12.2026 12:00:00,5, from 12/31/2026 or 31/12/2026 with AM and PM
    or without, from the time of day, which may pass midnight, or from ``0 days 00:00:01.5``; None
    where a cell is none of them."""
    british = _seconds(cells, day_first=True)
    if not cells or "/" not in cells[0]:
        return british
    american = _seconds(cells, day_first=False)
    if british is None or american is None:
        return american if british is None else british
    spans = [float(np.abs(one[-1:]).sum()) for one in (british, american)]
    return british if spans[0] < spans[1] else american  # next to midnight a month is a day


def _seconds(cells: Sequence[str], *, day_first: bool) -> Array | None:
    """day_first: what 1/2/2026 means."""
    stamps = np.empty(len(cells), dtype=np.int64)
    days: dict[tuple[str, ...], int] = {}
    bare = set()
    first: int | None = None
    for k, cell in enumerate(cells):
        match = _MOMENT.fullmatch(cell.strip())
        if match is None:
            return None
        date = tuple(match[one] or match[f"{one}2"] or "" for one in ("y", "mo", "d"))
        if match["y3"]:
            pair = (match["b3"], match["a3"]) if day_first else (match["a3"], match["b3"])
            date = (match["y3"], *pair)
        bare.add(not date[0])
        if date not in days:
            try:
                day = dt.date(*map(int, date)).toordinal() if date[0] else 0
            except ValueError:
                return None
            first = day if first is None else first
            if abs(day - first) > LONGEST:
                return None
            days[date] = (day - first) * DAY
        hour = 24 * int(match["run"] or 0) + _hour(int(match["h"]), match["half"])
        clock = 3600 * hour + 60 * int(match["m"]) + int(match["s"] or 0)
        fine = int((match["f"] or "0").ljust(9, "0"))
        stamps[k] = days[date] + clock * 10**9 + fine - _east(match["zone"] or "Z")
    if len(bare) != 1:
        return None
    stamps -= stamps[0]
    if bare == {True}:
        stamps += DAY * np.concatenate([[0], np.cumsum(np.diff(stamps) < -DAY // 2)])
    return np.asarray(stamps * 1e-9)


def _hour(hour: int, half: str | None) -> int:
    """Of 24, from one of 12 in a half of the day."""
    return hour if half is None else hour % 12 + 12 * (half.lower() == "pm")


def _east(zone: str) -> int:
    """ns that a zone is ahead."""
    if zone == "Z":
        return 0
    minutes = 60 * int(zone[1:3]) + int(zone[-2:])
    return (1 if zone[0] == "+" else -1) * minutes * 60 * 10**9
