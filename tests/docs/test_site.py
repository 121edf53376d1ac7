"""The docs as a site: every page has its place, what is generated says what the program says."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from types import ModuleType

import pytest
import yaml
from documents import ROOT


@pytest.fixture(scope="module")
def site_pages() -> ModuleType:
    spec = importlib.util.spec_from_file_location("site_pages", ROOT / "scripts/site_pages.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_page_stands_in_the_contents():
    nav = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))["nav"]
    listed = set(re.findall(r"[\w./-]+\.md", str(nav)))
    written = {path.name for path in (ROOT / "docs").glob("*.md")}
    assert written <= listed


def test_links_between_pages_lead_somewhere():
    for page in [*(ROOT / "docs").rglob("*.md"), ROOT / "README.md"]:
        for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_reference_has_every_command_function_and_document(site_pages):
    pages = site_pages.pages()
    for wanted in ("## pa10d diagnose", "## pa10d run import", "--validate", "| 130 |"):
        assert wanted in pages["reference/commands.md"]
    for wanted in ("pa10d.identify(robot:", "Model.torque(", "## load_run"):
        assert wanted in pages["reference/library.md"]
    assert "## diagnose" in pages["reference/documents.md"]
    assert "](docs/" not in pages["index.md"]


@pytest.mark.long
def test_the_site_builds_without_a_broken_link(tmp_path):
    pytest.importorskip("material", reason="the site's tools are not installed")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-d", str(tmp_path / "site")]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    subprocess.run(command, cwd=ROOT, check=True, env=environment, timeout=240)
    assert (tmp_path / "site/reference/commands.html").is_file()


@pytest.mark.long
@pytest.mark.alone
@pytest.mark.timeout(2000)
def test_the_first_paths_are_walked_by_their_text_alone(tmp_path):
    here = os.path.dirname(sys.executable)
    assert shutil.which("pa10d", path=here)
    environment = {**os.environ, "PATH": f"{here}{os.pathsep}{os.environ['PATH']}"}
    command = [sys.executable, str(ROOT / "scripts/walk_paths.py"), str(tmp_path / "walk")]
    subprocess.run(command, check=True, env=environment, timeout=1900)
