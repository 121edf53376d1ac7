"""Every light on the panel tells the same truth: connection, fault and queue before the story."""

from __future__ import annotations

import contextlib
import os
import re
import signal

import pytest
from benches import children_of
from browsers import until
from small_arm import small_arm

from pa10d.client import local_daemon
from pa10d.daemon.presence import present

LONG = 120_000  # ms


@pytest.fixture(scope="module")
def bench(browser, tmp_path_factory):
    """A daemon and its arm, to be hurt, each time a little more; (client, process id)."""
    folder = tmp_path_factory.mktemp("lights")
    with local_daemon(folder / "data", str(small_arm(folder)), clock="simulated") as client:
        yield client, present(folder / "data").pid


def lights(page) -> dict[str, str]:
    """What header, card, guide and job bar say."""
    places = {
        "header": "#arm-state", "card": ".state-word", "meaning": ".state-head p",
        "guide": "section:not([hidden]) .guide", "jobs": "#jobs",
    }  # fmt: skip
    return {name: page.locator(place).first.inner_text() for name, place in places.items()}


@pytest.mark.long
def test_a_control_process_that_stands_still_is_not_said_to_move_the_arm(bench, visit):
    client, pid = bench
    visitor = visit(client.url)
    page = visitor.page
    visitor.open("robot")
    moving = {"kind": "tracking", "parameters": {"amplitude": 0.05, "cycles": 60}}
    job = client.start("experiments", moving)
    page.locator("#arm-state", has_text="running").wait_for(timeout=LONG)
    assert "The arm is moving" in lights(page)["meaning"]
    [control] = children_of(pid, "pa10d.control")
    os.kill(control, signal.SIGSTOP)
    try:
        page.locator("#arm-state", has_text="no answer").wait_for(timeout=15_000)
        said = lights(page)
        assert said["card"].lower() == "no answer"
        assert "what the arm does now is not known" in said["meaning"]
        assert "control process does not answer" in said["guide"]
        assert not any("The arm is moving" in text for text in said.values())
        assert page.locator(".old .axes").count() == 1
        assert "s old" in page.locator(".panel .warn").first.inner_text()
        assert page.locator(".columns button:enabled").count() == 0
        page.keyboard.press("Escape")
        page.keyboard.press("Escape")
        unheard = page.locator("#stop-said.bad", has_text="control process has not answered")
        unheard.wait_for()
        assert "hardware emergency stop" in unheard.inner_text()
    finally:
        os.kill(control, signal.SIGCONT)
    page.locator("#stop-said", has_text="Stop was heard").wait_for(timeout=LONG)
    page.locator("#arm-state").get_by_text("no answer").wait_for(state="detached")
    assert page.locator(".old .axes").count() == 0
    client.cancel(job["id"])
    page.locator("#jobs", has_text="Last: Experiment").wait_for()
    # stopping takes a moment: what still ran when asked would stay powered for the next test
    page.locator("#arm-state", has_text=re.compile("^(holding|inactive)$")).wait_for(timeout=LONG)
    if client.robot()["state"] == "holding":
        client.disable()
    client.let_others_command()
    assert not visitor.errors


def test_connection_fault_and_queue_outrank_the_story(bench, visit):
    client, pid = bench
    visitor = visit(client.url)
    page = visitor.page
    visitor.open("robot")
    story = lights(page)["guide"]
    assert any(words in story for words in ("Nothing is recorded yet", "Mark which runs"))

    # an experiment that is planned does not move the arm yet; nobody plans before it was seen
    client.check_experiment({"kind": "boundary_velocity"})
    workers = children_of(pid, "pa10d.daemon.processes.worker")
    assert workers
    for one in workers:
        os.kill(one, signal.SIGSTOP)
    try:
        job = client.start("experiments", {"kind": "boundary_velocity"})
        page.locator(".guide", has_text="An experiment is being prepared").first.wait_for()
        said = lights(page)
        assert "the arm stands still" in said["guide"]
        assert said["header"] == "inactive"
        assert page.get_by_role("button", name="Enable").count() == 1
        client.cancel(job["id"])
    finally:
        for one in workers:
            with contextlib.suppress(ProcessLookupError):
                os.kill(one, signal.SIGCONT)

    # a daemon that hangs: nothing is claimed, what was known is grey and tells its age
    os.kill(pid, signal.SIGSTOP)
    try:
        page.locator("#arm-state", has_text="no connection").wait_for(timeout=15_000)
        said = lights(page)
        assert said["card"].lower() == "no connection"
        assert "not known" in said["meaning"]
        assert "does not answer" in said["guide"]
        assert not any("brakes on" in text for text in said.values())
        assert page.locator(".old .axes").count() == 1
        assert "s old" in page.locator(".panel .warn").first.inner_text()
        assert page.locator(".columns button:enabled").count() == 0
    finally:
        os.kill(pid, signal.SIGCONT)
    page.locator("#arm-state", has_text="inactive").wait_for(timeout=15_000)
    assert page.locator(".old .axes").count() == 0
    assert lights(page)["guide"] == story

    # a fault: the guide says what happened and names the button that can be pressed
    until(page, "document.querySelectorAll('.scope canvas').length === 4")
    client.enable()
    own = children_of(pid, "pa10d.daemon.processes.simulator")
    for one in own:
        os.kill(one, signal.SIGKILL)
    page.locator("#arm-state", has_text="fault").wait_for(timeout=15_000)
    page.locator(".guide", has_text="commands the arm and may reset it").first.wait_for()
    assert page.get_by_role("button", name="Reset").is_disabled()
    client.let_others_command()
    page.locator(".guide", has_text="Remove its cause, then press Reset").first.wait_for()
    assert lights(page)["card"].lower() == "fault"
    page.locator(".old .axes").wait_for()
    assert "last values before the fault" in page.locator(".panel .warn").first.inner_text()
    assert page.get_by_role("button", name="Reset").is_enabled()
    assert page.locator("#robot .guide a:visible").count() == 0  # it is on this page
    page.goto(f"{client.url}/#/models")
    page.locator("#models .guide a", has_text="Reset").click()
    page.locator("#robot").wait_for()
    assert not visitor.errors
