"""The wall's time is wrong, by as much as a test says."""

from __future__ import annotations

from datetime import datetime, timedelta

import pytest

from pa10d.store import names

HOUR = timedelta(hours=1)


@pytest.fixture
def clock(monkeypatch):
    """``clock.shift``: by how much."""

    class Wrong(datetime):
        shift = timedelta(0)

        @classmethod
        def now(cls, tz=None):
            return datetime.now(tz) + cls.shift

    monkeypatch.setattr(names, "datetime", Wrong)
    return Wrong
