"""``pa10d check``: go or no-go before power, with what to do about it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time

import pytest
import yaml

from backends.eds import OWN_EDS
from pa10d.daemon import check as checks
from pa10d.profile import find_profile, load_profile

pytestmark = pytest.mark.realtime


CALM = {"rate": 100.0}
"""A rate whose deadlines a busy machine keeps: what is looked at here is not its speed."""


def patient_eds(folder):
    """The virtual drive, but one that does without SYNC for longer."""
    text = OWN_EDS.read_text(encoding="utf-8")
    at = text.index("[2F01]")
    path = folder / "patient.eds"
    path.write_text(text[:at] + text[at:].replace("DefaultValue=200", "DefaultValue=1000", 1))
    return path


def profile_with(folder, **sections):
    """The simulated arm on a bus of its own, some sections changed."""
    base = find_profile("pa10-sim")
    profile = yaml.safe_load(base.read_text())
    profile["urdf"] = str(base.parent / profile["urdf"])
    profile["can"]["channel"] = f"c{os.getpid()}-{time.time_ns() % 10**6}"
    profile["safety"]["stale_cycles"] = 30  # at any rate less than the longest silence allowed
    for key, value in sections.items():
        profile[key] = value if value is None else {**profile[key], **value}
    for drive in profile["drives"]:
        drive["eds"] = str(patient_eds(folder))
    path = folder / "arm.yaml"
    path.write_text(yaml.safe_dump(profile))
    return path


def check(path, data):
    """→ exit status, whether it says go, checks by subject."""
    command = [sys.executable, "-m", "pa10d", "--data", str(data), "check", "--json"]
    done = subprocess.run(
        [*command, "--profile", str(path), "--seconds", "0.3"],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.stdout, done.stderr
    document = json.loads(done.stdout)
    found = {}
    for entry in document["checks"]:
        found.setdefault(entry["subject"], []).append((entry["level"], entry["sentence"]))
    return done.returncode, document["go"], found


def test_a_healthy_arm_is_go(tmp_path):
    status, go, found = check(profile_with(tmp_path, control=CALM), tmp_path)
    assert (status, go) == (0, True)
    assert set(found) >= {"bus", "limits", "disk", "clock", "timing", "drives", "safety"}
    assert [level for level, _ in found["drives"]] == ["ok"] * 7
    assert "node 7: pa10d virtual drive" in found["drives"][6][1]
    assert "bare loop" in found["timing"][-2][1]
    assert "loop with the drives" in found["timing"][-1][1]


@pytest.mark.long
def test_too_fast_for_the_wire_is_no_go_and_says_what_fits(tmp_path):
    path = profile_with(tmp_path, control={"rate": 1000.0})
    status, go, found = check(path, tmp_path)
    assert (status, go) == (1, False)
    level, sentence = found["bus"][0]
    assert level == "error"
    assert "at most 585 Hz" in sentence


def test_nobody_on_the_bus_is_no_go(tmp_path):
    status, go, found = check(profile_with(tmp_path, simulation=None), tmp_path)
    assert (status, go) == (1, False)
    level, sentence = found["drives"][0]
    assert level == "error"
    assert sentence.startswith("joints 1 to 7: ")


def lacking(folder, index, **drive):
    """A profile whose third drive has no such object; ``drive`` changes that drive."""
    eds = folder / "poor.eds"
    path = profile_with(folder, control=CALM)
    text = patient_eds(folder).read_text(encoding="utf-8")
    at = text.index(f"[{index:X}]")
    end = text.index("[", at + 1)
    while text[end:].startswith(f"[{index:X}sub"):
        end = text.index("[", end + 1)
    lines = (text[:at] + text[end:]).splitlines()
    kept = [line for line in lines if not line.endswith(f"=0x{index:X}")]
    eds.write_text("\n".join(kept), encoding="utf-8")
    profile = yaml.safe_load(path.read_text())
    profile["drives"][2] |= {"eds": str(eds), **drive}
    path.write_text(yaml.safe_dump(profile))
    return path


@pytest.mark.long
def test_what_a_drive_lacks_is_a_warning_by_name(tmp_path):
    status, go, found = check(lacking(tmp_path, 0x605E), tmp_path)
    assert (status, go) == (0, True), "a warning is for a person to weigh"
    warned = [sentence for level, sentence in found["safety"] if level == "warning"]
    assert len(warned) == 1
    assert "joint 3" in warned[0]
    assert "0x605E" in warned[0]
    assert len([1 for level, _ in found["safety"] if level == "ok"]) == 6


def test_a_drive_that_may_keep_its_torque_is_no_go_until_the_profile_accepts_that(tmp_path):
    status, go, found = check(lacking(tmp_path, 0x6007), tmp_path)
    assert (status, go) == (1, False)
    [sentence] = [text for level, text in found["safety"] if level == "error"]
    assert sentence.startswith("joint 3: no Abort connection option code (0x6007)")
    assert sentence.endswith("accepted_risks: [unknown_reaction]")
    assert not [text for level, text in found["safety"] if level == "warning"], "said once"
    path = lacking(tmp_path, 0x6007, accepted_risks=["unknown_reaction"])
    status, go, found = check(path, tmp_path)
    assert (status, go) == (0, True)
    assert [level for level, text in found["safety"] if "0x6007" in text] == ["warning"]


@pytest.mark.long
def test_every_refused_drive_has_a_line(tmp_path):
    path = profile_with(tmp_path, control=CALM)
    profile = yaml.safe_load(path.read_text())
    for k in (1, 4):
        profile["drives"][k]["vendor_id"] = 0xFB
    path.write_text(yaml.safe_dump(profile))
    status, go, found = check(path, tmp_path)
    assert (status, go) == (1, False)
    assert [(level, text[:17]) for level, text in found["drives"]] == [
        ("error", "joint 2: node 2: "),
        ("error", "joint 5: node 5: "),
    ]


def test_a_full_disk_is_a_warning(tmp_path, monkeypatch):
    monkeypatch.setattr(checks, "SMALL_DISK", 1e9)
    (found,) = checks._disk(tmp_path)
    assert found.level == "warning"
    assert "GB free" in found.sentence


@pytest.mark.parametrize(("late", "level"), [(1e-5, "ok"), (1e-3, "warning")])
def test_lateness_is_judged_against_the_period(late, level):
    profile = load_profile("pa10-sim")
    assert checks._judged("bare loop", (checks.np.full(100, late), 0), profile).level == level
