"""A new backend is one file: the one of the docs is written down, named in a profile, and holds an
arm; the kit that tries backends finds each broken promise."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from bus_helpers import make_profile, virtual_arm
from still_arm import StillArm

from backends.canopen_cia402.backend import CanopenBackend
from backends.device import PLAIN
from backends.faults import fault
from backends.kit import broken_promises
from backends.protocol import BackendFault
from backends.registry import device, open_backend
from pa10d.measurement.recording import Recording
from pa10d.replay import ReplayBackend

PAGE = Path(__file__).parents[2] / "docs" / "add-a-backend.md"


@pytest.fixture
def written(tmp_path, monkeypatch):
    """The profile that names the docs' example, and nothing else that knows of it."""
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    lines = blocks[0].splitlines()
    (tmp_path / "my_arm.py").write_text("\n".join(line[3:] for line in lines))
    monkeypatch.syspath_prepend(str(tmp_path))
    yield make_profile(tmp_path, backend="my_arm:open_backend")
    sys.modules.pop("my_arm", None)


def test_the_docs_backend_keeps_its_promises(written):
    assert broken_promises(lambda: open_backend(written)) == []
    assert device(written) is PLAIN


def test_so_do_those_that_are_here(tmp_path):
    still = make_profile(tmp_path, backend="still_arm:open_backend")
    assert broken_promises(lambda: open_backend(still)) == []
    t = np.arange(400) * 0.01
    run = Recording("r", t, np.zeros((400, 2)), np.zeros((400, 2)))
    assert broken_promises(lambda: ReplayBackend(run)) == []


class _Late(StillArm):
    time = 0.0

    def read(self):
        seen = super().read()
        seen.time = 1.0
        return seen


class _Loops(StillArm):
    def begin_enable(self):
        for _ in range(3):
            self.read()


class _Never(StillArm):
    switching = False

    def begin_disable(self):
        self.switching = True


class _Short(StillArm):
    def read(self):
        seen = super().read()
        seen.q = seen.q[:-1]
        return seen


class _NoNumber(StillArm):
    def read(self):
        seen = super().read()
        seen.tau = seen.tau * np.nan
        return seen


class _Raises(StillArm):
    def quick_stop(self):
        raise OSError("bus")


class _Faulty(StillArm):
    def begin_reset(self):
        raise BackendFault("odd", kind="odd")


class _Refuses(StillArm):
    def open(self):
        raise fault("no_answer", "silence", 1)


BROKEN = {
    _Late: "time does not go on",
    _Loops: "begin_enable reads 3 times by itself",
    _Never: "begin_disable: still switching after 60 s",
    _Short: "q has the shape",
    _NoNumber: "tau is not finite",
    _Raises: "OSError where only BackendFault may come: bus",
    _Faulty: "kind 'odd': not in backends/faults.py",
    _Refuses: "a fault in an ordinary life: joint 2: silence",
}


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_promise_is_named(tmp_path, kind):
    profile = make_profile(tmp_path)
    found = broken_promises(lambda: kind(profile))
    assert any(BROKEN[kind] in sentence for sentence in found), found


@pytest.mark.long
def test_the_canopen_drives_keep_them_too(tmp_path):
    profile = make_profile(tmp_path, 3, simulation={}, control={"rate": 200.0})
    with virtual_arm(profile):
        found = broken_promises(lambda: CanopenBackend(profile))
    assert found == []
