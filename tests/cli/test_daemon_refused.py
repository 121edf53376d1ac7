"""A daemon of one's own that is refused says why, not a traceback."""

from __future__ import annotations

import os

import pytest

from pa10d.client import local_daemon
from pa10d.common.errors import UserError
from pa10d.daemon.presence import LOCK, Presence, announced
from pa10d.daemon.processes.runtime import own


def test_a_data_folder_that_is_taken_is_said_to_be(tmp_path):
    with (
        own(tmp_path / LOCK, 0.0, "taken"),
        announced(tmp_path, Presence("http://127.0.0.1:1", os.getpid(), "pa10-sim")),
        pytest.raises(UserError, match=f"a daemon runs here already .*process {os.getpid()}"),
        local_daemon(tmp_path),
    ):
        raise AssertionError("it began")
