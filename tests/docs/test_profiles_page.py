"""The commands of docs/profiles.md, in their order, for somebody who has a URDF and a recording."""

from __future__ import annotations

import shlex

from documents import ROOT
from test_commands_of_pages import BLOCK
from test_readme import URDF, recording

from pa10d.cli import main

PAGE = ROOT / "docs" / "profiles.md"
ELSEWHERE = ("pa10d check", "pa10d serve")  # test_readme has both; tests/daemon with virtual drives


def test_a_profile_is_made_used_tuned_and_undone(tmp_path, monkeypatch, capsys):
    lines = [
        line
        for block in BLOCK.findall(PAGE.read_text(encoding="utf-8"))
        for line in block.splitlines()
        if line.startswith("pa10d ") and not line.startswith(ELSEWHERE)
    ]
    assert len(lines) >= 7
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PA10D_DATA", str(tmp_path / "data"))
    (tmp_path / "robot.urdf").write_text(URDF.replace('robot name="two"', 'robot name="arm"'))
    recording(tmp_path / "recording.csv", 1)
    written = {}
    for line in lines:
        assert main(shlex.split(line)[1:]) == 0, f"{line}\n{capsys.readouterr().err}"
        written[line] = (tmp_path / "arm.yaml").read_bytes()
    tuned = next(text for line, text in written.items() if "tune" in line and "--check" not in line)
    assert tuned != written[lines[0]]
    assert written[lines[-1]] == written[lines[0]], "undo puts it back byte by byte"
    assert "undone" in capsys.readouterr().out
