"""Options and fixtures of all tests."""

from __future__ import annotations

import gc
import os
import signal
import tempfile
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import settings

# a law holds for every input, not for every machine: how long an example takes is nobody's matter
settings.register_profile("any machine", deadline=None)
settings.load_profile("any machine")

pytest_plugins = ["by_default", "clock_witness", "groups"]

# Collecting makes half a million objects that all stay: looked through, they take as long as they
# took to be made.
gc.disable()

SHARED = Path(__file__).resolve().parents[2] / "shared"


def pytest_addoption(parser):
    parser.addoption("--long", action="store_true", help="slow tests and more of each kind, too")
    parser.addoption("--trials", type=int, help="how often --long tries what is drawn")


def pytest_configure(config):
    """Nothing of what the user keeps is read or written: not even the profile used last."""
    place = tempfile.TemporaryDirectory(prefix="pa10d-tests-", ignore_cleanup_errors=True)
    config.add_cleanup(place.cleanup)
    os.environ.pop("PA10D_DATA", None)
    os.environ["XDG_DATA_HOME"] = place.name
    # a shell's "&" has it ignored, and what is started here would inherit that
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(config, items):
    if config.getoption("--long"):
        return
    skip = pytest.mark.skip(reason="slow, or one more of a kind; --long runs it")
    for item in items:
        if "long" in item.keywords:
            item.add_marker(skip)


def pytest_collection_finish():
    gc.freeze()
    gc.enable()


def pytest_terminal_summary(terminalreporter):
    """What was skipped and why, however many workers there were."""
    reasons = Counter()
    for report in terminalreporter.stats.get("skipped", []):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        reasons[str(reason).removeprefix("Skipped: ")] += 1
    if reasons:
        terminalreporter.section("skipped")
    for reason, count in reasons.most_common():
        terminalreporter.write_line(f"{count:4d}  {reason}")


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of measurements and facts beside the project; a test is skipped without it."""
    if not SHARED.is_dir():
        pytest.skip("no folder 'shared' with test data beside the project")
    return SHARED


@pytest.fixture(scope="session")
def shared_data(shared: Path) -> Path:
    """Recordings of real robots."""
    return shared / "data"


@pytest.fixture(scope="session")
def half_a_minute(shared_data: Path, tmp_path_factory) -> Path:
    """robot.urdf, train.csv and valid.csv: the double pendulum, as much of it as shows every step
    of a story without a long wait."""
    source, folder = shared_data / "double_pendulum", tmp_path_factory.mktemp("half_a_minute")
    (folder / "robot.urdf").symlink_to(source / "robot.urdf")
    for name, samples in (("train", 5000), ("valid", 4000)):
        lines = (source / f"{name}1.csv").read_text().splitlines(keepends=True)
        (folder / f"{name}.csv").write_text("".join(lines[: samples + 1]))
    return folder
