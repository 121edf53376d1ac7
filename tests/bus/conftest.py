from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # plants that profiles name

from bus_helpers import make_profile
from drive_bench import Bench


@pytest.fixture
def make_bench(tmp_path: Path) -> Callable[..., Bench]:
    def make(**changes: Any) -> Bench:
        settings: dict[str, Any] = {"control": {"rate": 500.0}} | changes
        return Bench(make_profile(tmp_path, 1, **settings))

    return make


@pytest.fixture
def bench(make_bench: Callable[..., Bench]) -> Bench:
    return make_bench()
