"""A finding that the data cannot tell from another: the experiment that settles it, clicked."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from small_arm import small_arm

from backends.virtual.datasets import make_runs
from pa10d.client import Client, local_daemon
from pa10d.services.library import open_library
from pa10d.services.robots import load_robot
from pa10d.store import Channels, Samples

BRAKE = {"effect": "nonlinear_viscous", "joint": 3, "Fp": 6.0, "p": 2.0}
DOUBT = "cannot yet tell it from"
SLOWLY = 16.0  # s of slow motion, in which position and speed go together
FOLLOWED = 900_000  # ms on a loaded machine


@pytest.fixture
def doubtful(browser, tmp_path) -> Iterator[Client]:
    """An arm that was seen moving slowly only, and a model fitted to that."""
    path = small_arm(tmp_path, BRAKE)
    profile, robot = load_robot(str(path))
    (run,) = make_runs(5, [BRAKE], "white", ("train_b",), profile, seconds=SLOWLY)[0].values()
    stamps = (run.t * 1e9).round().astype("int64")
    with open_library(tmp_path / "data").runs.building(
        "slow", "slow", Channels(joints=robot.joint_names), profile, tags=("fit", "judge")
    ) as writer:
        writer.append(Samples(stamps, run.q, run.tau))
    with local_daemon(tmp_path / "data", str(path), clock="simulated") as client:
        client.identify(["slow"], "m0")
        client.wait_for_robot("inactive")
        yield client


def ask(page):
    """Press the button; the first finding."""
    page.click("#diagnose-start")
    page.locator("#findings", has_text="is being tried").wait_for()
    finding = page.locator(".finding").first
    finding.wait_for(timeout=FOLLOWED)
    return finding


def newest_diagnoses(client: Client) -> list[dict]:
    """The last two with their results, the newest first."""
    found = client._ask("GET", "/api/v1/diagnoses")["items"][:2]
    return [client._ask("GET", f"/api/v1/diagnoses/{job['id']}") for job in found]


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_the_experiment_that_settles_a_doubt_is_one_click(doubtful, visit):
    visitor = visit(doubtful.url)
    page = visitor.page
    visitor.open("diagnose")
    finding = ask(page)  # by any of its names: slow motion does not tell them apart
    assert DOUBT in finding.inner_text()
    assert finding.get_attribute("data-effect") in (BRAKE["effect"], "stribeck")
    page.locator("#diagnose .guide", has_text="run the experiment that settles it").wait_for()

    finding.get_by_role("button", name="Run the experiment that settles it").click()
    page.locator("#arm-state", has_text="running").wait_for(timeout=FOLLOWED)
    assert finding.locator(".settle").is_disabled()
    page.locator(".notice", has_text="The experiment is recorded.").wait_for(timeout=FOLLOWED)
    page.locator("#arm-state", has_text="inactive").wait_for(timeout=FOLLOWED)
    page.locator("#diagnose .guide", has_text="diagnose m0 again").wait_for()
    new = next(run for run in doubtful.runs() if run["name"] != "slow")
    assert set(new["tags"]) == {"fit", "judge"}

    finding = ask(page)
    assert finding.get_attribute("data-effect") == BRAKE["effect"]
    assert DOUBT not in finding.inner_text()
    last, first = newest_diagnoses(doubtful)
    assert all(new["id"] in last["request"][side] for side in ("fit", "validate"))
    again, before = (job["result"]["findings"][0]["next_experiment"] for job in (last, first))
    assert again is None or again["kind"] != before["kind"] == new["kind"]
    assert not visitor.errors
