#!/usr/bin/env python3
"""Make docs/screenshots anew: scripts/make_screenshots.py [--data DIR] [--out DIR]

A simulated arm hides an effect; the story is played over HTTP, then every section of the page is
opened in Chromium, light and dark, on a desk and on a tablet. With --data a story that was played
before is only looked at.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

DESK = {"viewport": {"width": 1280, "height": 860}, "color_scheme": "light"}
TABLET = {"viewport": {"width": 1024, "height": 768}, "color_scheme": "dark", "has_touch": True}
HIDDEN, SEED = "stribeck:4", 5
COLOURS = 200  # of a picture's palette; more make it larger and no better
SECTIONS = ("robot", "experiments", "runs", "compare", "diagnose", "models")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "screenshots")
    given = parser.parse_args()
    data = given.data or Path(tempfile.mkdtemp())
    data.mkdir(exist_ok=True)
    given.out.mkdir(parents=True, exist_ok=True)
    with bench(data) as arm:
        if not arm.models():
            play(arm)
        moving = arm.start("experiments", {"kind": "tracking", "parameters": {"cycles": 400}})
        arm.wait_for_robot("running", timeout=120)
        shoot(arm.url, given.out, ("robot",))
        arm.cancel(moving["id"])
        arm.delete_run(arm.runs()[0]["id"])
        shoot(arm.url, given.out, SECTIONS[1:])
    return 0


@contextmanager
def bench(data: Path) -> Iterator:
    """A daemon whose virtual arm has a secret, at a private profile."""
    import yaml

    from pa10d.client import local_daemon
    from pa10d.demo.hidden import hide, with_secret
    from pa10d.profile import load_profile

    profile = load_profile("pa10-sim")
    secret = with_secret(profile, hide(HIDDEN, SEED, profile), SEED)
    document = yaml.safe_load(profile.path.read_text())
    document["urdf"] = str(profile.path.parent / document["urdf"])
    document["simulation"] = secret.simulation.model_dump(mode="json")
    path = data / "arm.yaml"
    path.write_text(yaml.safe_dump(document))
    with local_daemon(data, str(path), clock="simulated") as arm:
        yield arm


def play(arm) -> None:
    """Record, fit, compare, diagnose, add."""
    if not tagged(arm, "fit"):
        arm.series(arm.starting_set())
    fit, judge = tagged(arm, "fit"), tagged(arm, "judge")
    arm.identify(fit, "m0")
    arm.compare("m0", judge)
    first = arm.diagnose("m0", fit, judge)["findings"][0]
    arm.add("m0", first["effect"], first["joints"], fit, "m1")


def tagged(arm, tag: str) -> list[str]:
    """Runs that are marked so; the starting set has others, which measure the joints."""
    return [run["id"] for run in arm.runs() if tag in run["tags"]]


def shoot(url: str, out: Path, sections: tuple[str, ...]) -> None:
    """Every section, on the desk and on the tablet."""
    from playwright.sync_api import sync_playwright

    browser_path = shutil.which("chromium") or shutil.which("google-chrome")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=browser_path, args=["--no-sandbox"])
        for ending, options in (("", DESK), ("-tablet-dark", TABLET)):
            page = browser.new_context(**options).new_page()
            page.set_default_timeout(60_000)
            for section in sections:
                page.goto(f"{url}/#/{address(url, section)}")
                page.wait_for_timeout(500)
                prepare(page, section)
                page.mouse.move(4, 400)
                page.wait_for_timeout(2500)
                path = out / f"{section}{ending}.png"
                page.screenshot(path=path)
                shrink(path)
                print(path.relative_to(ROOT) if path.is_relative_to(ROOT) else path)
        browser.close()


def address(url: str, section: str) -> str:
    """Comparisons and models by name, so that something is shown."""
    import httpx

    if section == "compare":
        made = httpx.get(f"{url}/api/v1/comparisons").json()["items"]
        return f"compare/{made[0]['id']}"  # the newest
    return {"models": "models/m1"}.get(section, section)


def prepare(page, section: str) -> None:
    """What a person would have clicked."""
    if section == "runs":
        page.locator("#runs tbody button").nth(1).click()
        page.locator("#run-detail .main-svg").first.wait_for()
    elif section == "compare":
        page.locator(".sentence").first.wait_for()
        page.evaluate("scrollTo(0, 0)")
    elif section == "diagnose":
        page.locator(".finding").first.wait_for()
        page.evaluate("document.querySelector('.finding').scrollIntoView()")  # drawn when seen
        page.locator(".finding .main-svg").first.wait_for()
    elif section == "models":
        page.locator(".stairs .main-svg").first.wait_for()
    elif section == "robot":
        page.wait_for_timeout(3000)


def shrink(path: Path) -> None:
    """Fewer colours: a third of the size, and nobody sees it."""
    from PIL import Image

    image = Image.open(path).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    image.save(path, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
