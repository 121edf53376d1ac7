"""Killed at any moment while a run replaces another: one of both has the name, whole."""

from __future__ import annotations

import os
import sys

import pytest
from store_data import channels, samples

from pa10d.store import RunStore

TOUCHES = ("open", "os.rename", "os.remove", "os.rmdir", "os.mkdir", "os.truncate", "os.link")


def recorded(folder, name, replace=False):
    writer = RunStore(folder).start(name, channels(), replace=replace)
    writer.append(samples())
    return writer.close()


def killed_at(moment, work):
    """Whether it was: before the filesystem is touched for the ``moment``-th time."""
    if (child := os.fork()) == 0:
        left = [moment]

        def touched(event, _arguments):
            if event in TOUCHES:
                left[0] -= 1
                if left[0] == 0:
                    os._exit(9)

        sys.addaudithook(touched)
        try:
            work()
        finally:
            os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9


@pytest.mark.long
def test_the_name_is_always_that_of_a_whole_run(tmp_path):
    """Of the old one until the new one has ended well; where both have it for a moment, the new
    one keeps it. The old one goes only then."""
    moment, meant = 0, []
    while True:
        moment += 1
        folder = tmp_path / str(moment)
        folder.mkdir()
        old = recorded(folder, "a")
        killed = killed_at(moment, lambda there=folder: recorded(there, "a", replace=True))
        store = RunStore(folder)
        found = store.find("a")
        assert found.status == "success", moment
        assert len(store.read(found).samples) == 500
        assert not store.set_aside()
        for run in store.all():
            assert run.id in (old.id, found.id) or run.status != "success" or run.name == "a-2"
        names = [run.name for run in store.all()]
        assert len(set(names)) == len(names)
        meant.append(found.id == old.id)
        if not killed:
            break
    assert meant == sorted(meant, reverse=True), "once the new one has the name, it keeps it"
    assert set(meant) == {True, False}
