"""What commands are tried with."""

from __future__ import annotations

import json

import pytest

from pa10d.cli import main


@pytest.fixture
def run(data, capsys):
    """Run a command with --json: (exit status, document or None, stderr)."""
    capsys.readouterr()

    def call(*arguments):
        status = main(["--data", data, *arguments, "--json"])
        said = capsys.readouterr()
        return status, json.loads(said.out) if status == 0 else None, said.err

    return call
