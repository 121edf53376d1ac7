"""What is installed is locked, what is vendored is listed, and the bill of materials has it all."""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
import tomllib

from documents import ROOT

OTHER_PLATFORMS = {"colorama", "tzdata", "pywin32"}
SILENT = {"cmeel-qhull"}  # its metadata names no licence (Qhull's own, free)


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _locked(name: str) -> set[tuple[str, str]]:
    """Name and version; one name has several where Pythons differ."""
    text = (ROOT / "scripts" / name).read_text(encoding="utf-8")
    found = re.findall(r"^([\w.-]+)==([\w.]+)", text, re.MULTILINE)
    return {(_plain(name), version) for name, version in found}


def _asked() -> tuple[set[str], set[str]]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = [re.match(r"[\w-]+", line)[0].lower() for line in project["dependencies"]]
    developing = project["optional-dependencies"]["dev"]
    more = [re.match(r"[\w-]+", line)[0].lower() for line in developing]
    return set(named), set(named) | set(more)


def test_every_package_that_is_asked_for_is_locked():
    needed, developed = _asked()
    assert needed <= {name for name, _ in _locked("locked.txt")}
    assert developed <= {name for name, _ in _locked("locked-dev.txt")}


def test_both_locks_agree_and_every_package_has_hashes():
    assert _locked("locked.txt") <= _locked("locked-dev.txt")
    for name in ("locked.txt", "locked-dev.txt", "locked-uv.txt"):
        text = (ROOT / "scripts" / name).read_text(encoding="utf-8")
        entries = re.split(r"^(?=[\w.-]+==)", text, flags=re.MULTILINE)[1:]
        assert all("--hash=sha256:" in entry for entry in entries)
        assert "://" not in text


def test_what_is_vendored_is_listed_with_its_licence():
    for folder in ROOT.glob("pa10d/**/vendor"):
        listed = {one["file"] for one in json.loads((folder / "vendored.json").read_text())}
        there = {p.name for p in folder.iterdir() if p.suffix in {".js", ".gz", ".css"}}
        assert there == listed
        assert any(p.name.startswith("LICENCE") for p in folder.iterdir())


def test_the_bill_of_materials_is_that_of_the_lock_and_of_the_files():
    bill = json.loads((ROOT / "docs/sbom.json").read_text(encoding="utf-8"))
    packages = {
        (_plain(c["name"]), c["version"])
        for c in bill["components"]
        if c["purl"].startswith("pkg:pypi/")
    }
    locked = _locked("locked.txt")
    assert packages <= locked
    assert {name for name, _ in locked - packages} <= OTHER_PLATFORMS | {n for n, _ in packages}
    hashes = {h["content"] for c in bill["components"] for h in c.get("hashes", ())}
    for folder in ROOT.glob("pa10d/**/vendor"):
        for one in json.loads((folder / "vendored.json").read_text()):
            content = (folder / one["file"]).read_bytes()
            assert hashlib.sha256(content).hexdigest() in hashes, one
    assert {c["name"] for c in bill["components"] if not c.get("licenses")} <= SILENT


def test_the_scripts_can_be_read_by_bash():
    for script in ("lock", "test-wheel", "environment"):
        subprocess.run(["bash", "-n", str(ROOT / "scripts" / script)], check=True)
