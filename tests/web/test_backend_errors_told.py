"""What breaks in a backend is read by people: in GET /robot, at a command's end, on the page."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
import yaml
from benches import served
from small_arm import small_arm

from pa10d.cli import main
from pa10d.client import Client
from pa10d.store import RunStore

pytestmark = [pytest.mark.long, pytest.mark.timeout(400)]

HERE = Path(__file__).resolve().parent
EMCY = "joint 2: lost its encoder; check its plug"
CODE = "TypeError: unsupported operand"
TRACKING = ("experiment", "tracking", "--set", "period=4", "cycles=8")


class FaultyDaemon:
    def __init__(self, url: str, data: Path, plan: Path, profile: Path) -> None:
        self.url, self.data, self.plan, self.profile = url, data, plan, profile
        self.client = Client(url)

    def breaks(self, call: str, way: str, **more: object) -> None:
        waiting = self.plan.with_suffix(".new")
        waiting.write_text(json.dumps({"call": call, "way": way, **more}))
        waiting.rename(self.plan)

    def mend(self) -> None:
        self.plan.unlink(missing_ok=True)
        robot = self.client.robot()
        if robot["state"] == "offline":
            self.client.wait_for_robot("inactive", "fault", timeout=120)
        if self.client.robot()["state"] == "fault":
            self.client.reset()
        if self.client.robot()["state"] == "holding":
            self.client.disable()
        self.client.wait_for_robot("inactive", timeout=30)


@pytest.fixture(scope="module")
def faulty(browser, tmp_path_factory):
    folder = tmp_path_factory.mktemp("faulty")
    path = small_arm(folder)
    profile = yaml.safe_load(path.read_text())
    profile["backend"] = "faulty_arm:open_backend"
    profile["safety"] = {"following_error": [3.0] * 3}
    path.write_text(yaml.safe_dump(profile))
    patch = pytest.MonkeyPatch()
    patch.setenv("PYTHONPATH", str(HERE.parent / "daemon"))
    patch.setenv("FAULTY_ARM", str(folder / "plan.json"))
    patch.syspath_prepend(str(HERE.parent / "daemon"))
    data = folder / "data"
    with served(data, f"f{os.getpid()}", "--profile", str(path)) as url:
        made = FaultyDaemon(url, data, folder / "plan.json", path)
        made.client.wait_for_robot("inactive", timeout=120)
        yield made
        made.client.close()
    patch.undo()


@pytest.fixture(autouse=True)
def mended(faulty):
    yield
    faulty.mend()


def told_everywhere(faulty, visit, capfd, says: str, state: str, command=TRACKING) -> None:
    """GET /robot, the last line of a command, and the page say it."""
    robot = faulty.client.robot()
    assert robot["state"] == state
    assert says in (robot["fault"] or {}).get("sentence", robot["offline_reason"])
    capfd.readouterr()
    assert main(["--data", str(faulty.data), *command, "--profile", str(faulty.profile)]) == 1
    assert says in capfd.readouterr().err.strip().splitlines()[-1]
    visitor = visit(faulty.url)
    visitor.open("robot")
    page = visitor.page
    page.locator(".state-word", has_text=state).wait_for()
    page.locator(".state-head", has_text=says).wait_for()
    if state == "fault":
        page.locator("[data-guide=robot]", has_text=says).wait_for()
    assert not visitor.errors
    visitor.close()


@pytest.mark.parametrize(("way", "says"), [("axis", EMCY), ("code", CODE), ("exit", "SystemExit")])
@pytest.mark.parametrize("call", ["read", "write", "begin_enable"])
def test_while_the_arm_is_enabled_and_held(faulty, visit, capfd, call, way, says):
    faulty.breaks(call, way, after=0 if call == "begin_enable" else 50)
    run = ["--data", str(faulty.data), *TRACKING, "--profile", str(faulty.profile)]
    capfd.readouterr()
    assert main(run) == 1
    assert says in capfd.readouterr().err.strip().splitlines()[-1]
    told_everywhere(faulty, visit, capfd, says, "fault")


def test_in_motion_the_run_stays_readable_and_says_why(faulty, visit, capfd):
    faulty.breaks("read", "axis", after=6000, once=True)
    run = ["--data", str(faulty.data), *TRACKING, "--profile", str(faulty.profile)]
    assert main(run) == 1
    assert EMCY in capfd.readouterr().err.strip().splitlines()[-1]
    store = RunStore(faulty.data)
    (info,) = store.all()
    assert (info.status, info.reason) == ("aborted", EMCY)
    assert store.read(info).samples.q.shape[0] == info.samples > 500
    told_everywhere(faulty, visit, capfd, EMCY, "fault")


def test_while_the_arm_is_disabled(faulty, visit, capfd):
    faulty.client.enable()
    faulty.breaks("begin_disable", "code", once=True)
    faulty.client.disable()
    told_everywhere(faulty, visit, capfd, CODE, "fault")


def test_while_a_fault_is_reset(faulty, visit, capfd):
    faulty.breaks("read", "axis", once=True)
    faulty.client._ask("POST", "/api/v1/robot/enable")
    faulty.client.wait_for_robot("fault")
    faulty.breaks("begin_reset", "system")
    with pytest.raises(Exception, match="No such device"):
        faulty.client.reset()
    told_everywhere(faulty, visit, capfd, "No such device", "fault")


@pytest.mark.parametrize(("way", "says"), [("axis", EMCY), ("code", CODE), ("exit", "SystemExit")])
def test_while_the_bus_is_opened(faulty, visit, capfd, way, says):
    faulty.client.disconnect()
    faulty.breaks("open", way)
    with pytest.raises(Exception, match=says.split(";")[0]):
        faulty.client.connect()
    faulty.client.wait_for_robot("offline")
    told_everywhere(faulty, visit, capfd, says, "offline")


def test_while_the_bus_is_left(faulty, visit, capfd):
    faulty.breaks("close", "code")
    assert CODE in faulty.client.disconnect()["offline_reason"]
    told_everywhere(faulty, visit, capfd, CODE, "offline")
    faulty.plan.unlink()
    faulty.client.connect()


@pytest.mark.parametrize("call", ["read", "write", "begin_enable"])
def test_a_backend_that_hangs_is_ended_and_said_to(faulty, visit, capfd, call):
    """Once nobody waits for an answer to a command; before, it counted as held for ever."""
    faulty.breaks(call, "hang", once=True, after=0 if call == "begin_enable" else 300)
    try:
        faulty.client.enable()
    except Exception as error:
        assert "no answer to 'enable'" in str(error)  # noqa: PT017
    faulty.client.wait_for_robot("fault", timeout=100)  # 75 s, where it hangs before its answer
    told_everywhere(faulty, visit, capfd, "its backend hangs", "fault")


def test_a_backend_that_cannot_even_be_made_says_why(faulty, visit, capfd):
    faulty.client.enable()
    faulty.breaks("read", "hang", after=10)
    faulty.client.stop(0.0)  # simulated time goes on for a while
    faulty.client.wait_for_robot("fault", timeout=60)
    faulty.breaks("factory", "code")
    with pytest.raises(Exception, match="unsupported operand"):
        faulty.client.reset()
