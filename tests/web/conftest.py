"""Daemons with something to show, and browsers to look at them."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path

import pytest
from benches import served
from browsers import Visitor, chromium
from small_arm import small_arm

from backends.virtual.datasets import make_runs
from pa10d.client import Client, local_daemon
from pa10d.services.library import open_library
from pa10d.services.models import identify_runs
from pa10d.services.robots import load_robot
from pa10d.store import Channels, Samples

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items):
    """A page is used in real time, even where the arm is not."""
    for item in items:
        if item.path.parent == HERE:
            item.add_marker(pytest.mark.alone)
            item.add_marker(pytest.mark.browser)


@pytest.fixture(scope="package")
def browser():
    with chromium() as made:
        yield made


@pytest.fixture
def visit(browser):
    """visit(url) opens another window."""
    with contextlib.ExitStack() as stack:

        def opened(url: str, **options) -> Visitor:
            visitor = Visitor(browser, url, **options)
            stack.callback(visitor.close)
            return visitor

        yield opened


@pytest.fixture(scope="package")
def arm(browser, tmp_path_factory) -> Iterator[Client]:
    """An arm of three joints that hides something, in simulated time."""
    folder = tmp_path_factory.mktemp("web")
    with local_daemon(folder / "data", str(small_arm(folder)), clock="simulated") as client:
        yield client


@pytest.fixture(scope="package")
def archive(browser, tmp_path_factory) -> Iterator[tuple[str, Path]]:
    """(url, data): a daemon without an arm, with runs of 7 × 30 000 samples and a model."""
    data = tmp_path_factory.mktemp("archive")
    library = open_library(data)
    profile, robot = load_robot("pa10-sim")
    hidden = [{"effect": "stribeck", "joint": 4, "Fs": 4.0, "vs": 0.1}]
    runs = make_runs(5, hidden, "white", ("train_a", "valid_a"), profile, seconds=60.0)[0]
    for (name, run), tag in zip(runs.items(), ("fit", "judge"), strict=True):
        channels = Channels(joints=robot.joint_names)
        stamps = (run.t * 1e9).round().astype("int64")
        with library.runs.building(name, name, channels, profile, tags=(tag,)) as writer:
            writer.append(Samples(stamps, run.q, run.tau))
        assert len(run.t) >= 30_000
    identify_runs(library, ["train_a"], str(profile.path), name="m0")
    with served(data, f"void-{data.name}") as url:
        yield url, data


@pytest.fixture
def csv_text() -> str:
    joints = range(1, 8)
    head = ",".join(["time", *(f"q{j}" for j in joints), *(f"tau{j}" for j in joints)])
    rows = [
        ",".join(
            [
                f"{0.002 * k:.3f}",
                *[f"{0.3 * math.sin(0.02 * k):.4f}"] * 7,
                *[f"{0.3 * (k % 7) - 0.1:.1f}"] * 7,
            ]
        )
        for k in range(500)
    ]
    return "\n".join([head, *rows]) + "\n"
