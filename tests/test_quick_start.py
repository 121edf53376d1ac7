"""Processes begin in about a second: they load a library when they need it, not because they may.

``import scipy`` loads its packages when they are first named, and some take longer to load than
everything else together.
"""

from __future__ import annotations

import gc
import subprocess
import sys

import pytest

from pa10d.common.loading import loading

SLOW = (
    "scipy.stats",
    "scipy.signal",
    "scipy.optimize",
    "scipy.interpolate",
    "matplotlib",
)


@pytest.mark.by_default("pa10d.api.app", "pa10d.client")
@pytest.mark.parametrize(
    "module",
    ["pa10d.control.__main__", "pa10d.recorder.__main__", "pa10d.api.app", "pa10d.client",
     "backends.virtual.arm", "backends.virtual.plant.plant", "pa10d.services.diagnoses"],
)  # fmt: skip
def test_nothing_slow_is_loaded_before_it_is_needed(module):
    code = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.split()
    assert not set(loaded) & set(SLOW)


def test_what_is_loaded_late_can_be_told_from_what_is_not():
    code = "import sys, scipy; scipy.stats.norm; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.split()
    assert "scipy.stats" in loaded


def test_while_modules_are_loaded_nobody_looks_for_garbage():
    assert gc.isenabled()
    with loading():
        assert not gc.isenabled()
        with loading():
            pass
        assert not gc.isenabled(), "whoever had it off keeps it off"
    assert gc.isenabled()
