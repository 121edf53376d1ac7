"""What no effect of the library explains: the page says so, and hides it by a map when asked to."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from benches import served
from small_arm import small_arm

from backends.virtual.datasets import make_runs
from pa10d.services.library import open_library
from pa10d.services.models import compare_runs, identify_runs
from pa10d.services.robots import load_robot
from pa10d.store import Channels, Samples

WHEEL = {"effect": "gyroscope", "joints": [2, 3], "amplitude": 8.0}
"""A wheel in the drive of joint 2, turned by joint 3: no effect of the library."""
PATIENCE = 300_000  # ms on a loaded machine


@pytest.fixture
def puzzled(browser, tmp_path) -> Iterator[tuple[str, object]]:
    """(url, library): a daemon without an arm, with runs of one that hides the wheel."""
    path, data = small_arm(tmp_path), tmp_path / "data"
    profile, robot = load_robot(str(path))
    kinds = ("train_a", "train_b", "valid_a", "valid_b")
    library = open_library(data)
    for name, run in make_runs(5, [WHEEL], "white", kinds, profile, seconds=40.0)[0].items():
        stamps = (run.t * 1e9).round().astype("int64")
        tag = "fit" if name.startswith("train") else "judge"
        with library.runs.building(
            name, name, Channels(joints=robot.joint_names), profile, tags=(tag,)
        ) as writer:
            writer.append(Samples(stamps, run.q, run.tau))
    identify_runs(library, ["train_a", "train_b"], str(path), name="m0")
    with served(data, f"void-{data.parent.name}") as url:
        yield url, library


@pytest.mark.long
@pytest.mark.timeout(900)
def test_a_map_removes_what_nobody_can_name(puzzled, visit):
    url, library = puzzled
    visitor = visit(url)
    page = visitor.page
    visitor.open("diagnose")
    page.click("#diagnose-start")
    place = page.locator(".finding[data-unexplained='2']")
    place.wait_for(timeout=PATIENCE)
    assert page.locator(".finding[data-effect]").count() == 0
    assert "no effect of the library explains" in page.locator("#findings").inner_text()

    place.get_by_role("button", name="Remove it by a smooth map").click()
    page.locator(".notice", has_text="explains nothing").first.wait_for(timeout=PATIENCE)
    done = place.get_by_role("link", name="see how far the error fell")
    done.wait_for(timeout=PATIENCE)
    assert not place.get_by_role("button", name="Remove it by a smooth map").is_visible()
    made = library.models.find(done.inner_text().split()[2].rstrip(":"))
    assert "smooth_map J2" in made.change

    done.click()
    page.locator("#models", has_text="smooth_map").wait_for()
    old, new = (
        compare_runs(library, model, ["valid_a", "valid_b"]).comparison.pooled.scores.rms
        for model in ("m0", made.name)
    )
    assert new[1] < 0.5 * old[1]
    assert not visitor.errors
