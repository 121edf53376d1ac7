"""How soon the page can be used on a slow link: first light, STOP, first plot, zoom.

    python scripts/bench_page.py [--kbit 400] [--latency 150] [--points 10000000] [--json]

A real Chromium on a link that is throttled by the browser itself, against a daemon of its own with
recordings of a simulated arm. Times are from the request of the page, or from the click.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(HERE), str(HERE / "tests/web")]

from benches import served  # noqa: E402
from browsers import Visitor, chromium, until  # noqa: E402

from pa10d.profile import load_profile  # noqa: E402
from pa10d.store import Channels, RunStore, Samples  # noqa: E402

JOINTS, RATE = 7, 500.0
# asked for every 30 ms: a locator looks again after as much as half a second
SECTION = "document.querySelector('#explore h1')?.checkVisibility()"


def main() -> None:
    """Print one line per figure."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kbit", type=float, default=400.0, help="of the link, kbit/s")
    parser.add_argument("--latency", type=float, default=150.0, help="ms there and back")
    parser.add_argument("--points", type=int, default=10_000_000, help="values of the recording")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder)
        record(data, given.points)
        with served(data, f"void-{data.name}") as url, chromium() as browser:
            found = measure(browser, url, given.kbit, given.latency)
    if given.json:
        print(json.dumps(found))
        return
    for what, value in found.items():
        print(f"{what:45} {value:8.2f}")


def record(data: Path, points: int) -> None:
    """A run of seven joints with positions and torques, ``points`` values in all."""
    samples = points // (2 * JOINTS)
    t = np.arange(samples) / RATE
    rng = np.random.default_rng(1)
    q = 0.5 * np.sin(2 * np.pi * 0.1 * t)[:, None] * np.linspace(0.5, 1.5, JOINTS)
    tau = 5 * np.cos(2 * np.pi * 0.1 * t)[:, None] + 0.1 * rng.standard_normal((samples, JOINTS))
    profile = load_profile("pa10-sim")
    channels = Channels(joints=tuple(profile.joints or ()))
    stamps = (t * 1e9).round().astype("int64")
    with RunStore(data).building("long", "long", channels, profile) as writer:
        writer.append(Samples(stamps, q, tau))


def measure(browser, url: str, kbit: float, latency: float) -> dict[str, float]:
    """Seconds, kB and values, by what they are of."""
    visitor = Visitor(browser, url)
    page = visitor.page
    network = visitor.context.new_cdp_session(page)
    network.send("Network.enable")
    rate = kbit * 1000 / 8
    network.send("Network.emulateNetworkConditions", {
        "offline": False, "latency": latency, "downloadThroughput": rate, "uploadThroughput": rate,
    })  # fmt: skip
    came = {"kB": 0.0}

    def arrived(event) -> None:
        came["kB"] += event["encodedDataLength"] / 1000

    network.on("Network.loadingFinished", arrived)
    out: dict[str, float] = {}
    began = time.monotonic()
    page.goto(f"{url}/#/explore", wait_until="commit")
    until(page, "document.querySelector('#stop')")
    out["STOP can be pressed, s"] = time.monotonic() - began
    until(page, SECTION)
    out["first light: the section stands, s"] = time.monotonic() - began
    out["carried until then, kB"] = came["kB"]
    until(page, "document.querySelector('#arm-state')?.textContent.length > 1")
    out["the arm's state is shown, s"] = time.monotonic() - began
    page.locator("#explore summary").first.click()
    page.get_by_label("long").wait_for()
    before, began = came["kB"], time.monotonic()
    page.get_by_label("long").check()
    drawn(page)
    out["first plots of the recording, s"] = time.monotonic() - began
    out["carried for them, kB"] = came["kB"] - before
    page.keyboard.press("Escape")
    page.wait_for_timeout(12_000)  # the arm has come, too
    for what in ("zoom", "second zoom"):
        before, began = came["kB"], time.monotonic()
        page.get_by_role("button", name="Zoom in").click()
        drawn(page, "Seen")
        out[f"{what}, s"] = time.monotonic() - began
        out[f"carried for the {what}, kB"] = came["kB"] - before
    page.reload(wait_until="commit")
    began = time.monotonic()
    until(page, SECTION)
    out["first light of a reload, s"] = time.monotonic() - began
    assert not visitor.errors, visitor.errors
    return out


DRAWN = """(said) => document.querySelectorAll("#explore .chart canvas").length >= 2
  && document.querySelector("#explore [role=status]:not(.guide)").textContent.includes(said)
  && [...document.querySelectorAll("#explore .chart")].every((one) => !one.dataset.waiting)"""


def drawn(page, said: str = "samples") -> None:
    """Until both plots show what was asked for."""
    end = time.monotonic() + 120
    while not page.evaluate(DRAWN, said):
        assert time.monotonic() < end, "the plots never came"
        page.wait_for_timeout(10)


if __name__ == "__main__":
    main()
