"""The arm: its state, and what may be asked of it."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from pa10d.api.deps import Client, Commander, TheDaemon
from pa10d.api.problems import Problem, responses
from pa10d.api.routes.models import find_model
from pa10d.api.schemas.arm import (
    ControllerRequest,
    DisableRequest,
    DriveMemories,
    EnableRequest,
    Lease,
    LeaseRequest,
    RobotState,
)
from pa10d.daemon.daemon import Daemon
from pa10d.daemon.motions.way_back import bring_inside

router = APIRouter(prefix="/robot", tags=["robot"])
COMMAND = responses("state", "held", "not-ready")
POWER = responses("state", "held", "not-ready", "conflict", "refused")


@router.get("")
async def show_robot(daemon: TheDaemon) -> RobotState:
    """The arm, now."""
    return describe(daemon)


@router.post("/enable", responses=POWER)
async def enable(
    daemon: TheDaemon, _client: Commander, request: EnableRequest | None = None
) -> RobotState:
    """Power on, release the brakes, hold the arm where it is.

    One of which a joint reads elsewhere than it stood before its drive was set up anew is refused
    until somebody has looked (``confirm``). One that stands outside its position limits is
    refused; with ``recover`` it is powered and brought back inside at a tenth of its speed, and
    the answer comes once it is held there.
    """
    if request is not None and request.recover:
        if (busy := daemon.busy()) is not None:
            raise Problem("conflict", busy, remedy="wait for it, or cancel it")
        with daemon.robot.stops.heard_by(daemon.robot.stops.count):
            await bring_inside(daemon)
    else:
        await daemon.robot.enable()
    return describe(daemon)


@router.post("/disable", responses=COMMAND)
async def disable(
    daemon: TheDaemon, _client: Commander, request: DisableRequest | None = None
) -> RobotState:
    """Bring the arm to rest, brakes on, power off. No job that runs powers it again.

    For 0.3 s the brakes have the load and power is at hand: where one does not hold it, the motors
    take it back within a few hundredths of a radian, the arm stays held, and the answer says which
    (``unheld``). With ``anyway`` power goes whether they hold or not.
    """
    daemon.robot.stops.ask()
    await daemon.robot.disable(anyway=request is not None and request.anyway)
    return describe(daemon)


@router.post("/stop")
async def stop(
    daemon: TheDaemon,
    wait: Annotated[float, Query(ge=0, le=30, description="s to wait for the arm's rest")] = 0.0,
) -> RobotState:
    """Bring the arm to rest along its limits. Everybody may, always; nothing needs to be held.

    Answers once control has been told; ``wait`` for those who want to see the arm at rest.
    """
    daemon.stop()
    if wait > 0:
        await daemon.robot.until("holding", "inactive", "fault", "offline", timeout=wait)
    return describe(daemon)


@router.post("/reset", responses=COMMAND)
async def reset(daemon: TheDaemon, _client: Commander) -> RobotState:
    """Leave a fault, once its cause is gone; the arm stays unpowered. A virtual arm that has died
    is started again."""
    await daemon.reset()
    await daemon.robot.until("inactive", timeout=3.0)
    return describe(daemon)


@router.post("/confirm", responses=COMMAND)
async def confirm_place(daemon: TheDaemon, _client: Commander) -> RobotState:
    """Somebody has looked at the arm: every joint stands where it reads, also those of
    ``misplaced``, which are not powered before. Nothing moves."""
    await daemon.robot.confirm()
    await daemon.robot.believed(timeout=3.0)
    return describe(daemon)


@router.post("/connect", responses=COMMAND)
async def connect(daemon: TheDaemon, _client: Commander) -> RobotState:
    """Try to reach the drives now; a virtual arm that has died is started again."""
    await daemon.revive()
    if daemon.robot.state == "offline":
        await daemon.robot.connect()
    await daemon.robot.until("inactive", timeout=3.0)
    return describe(daemon)


@router.post("/disconnect", responses=COMMAND)
async def disconnect(daemon: TheDaemon, _client: Commander) -> RobotState:
    """Leave the bus; the arm must be unpowered."""
    if daemon.robot.state != "offline":
        await daemon.robot.disconnect()
    await daemon.robot.until("offline", timeout=3.0)
    return describe(daemon)


@router.get("/errors", responses=responses("state", "not-ready"))
async def show_drive_errors(daemon: TheDaemon) -> DriveMemories:
    """What each drive remembers of its own errors, newest first; the arm must be unpowered, and may
    be offline."""
    return DriveMemories.model_validate({"drives": await daemon.robot.drive_errors()})


@router.post("/errors/clear", responses=COMMAND)
async def clear_drive_errors(daemon: TheDaemon, _client: Commander) -> DriveMemories:
    """Empty every drive's history. A fault is not acknowledged by that: ``reset`` does."""
    return DriveMemories.model_validate({"drives": await daemon.robot.clear_drive_errors()})


@router.put(
    "/controller",
    responses=responses("state", "held", "refused", "not-found"),
)
async def choose_controller(
    daemon: TheDaemon, _client: Commander, request: ControllerRequest
) -> RobotState:
    """Choose the control law; all but PID need a model, whose effects go along in every
    experiment from now on."""
    model = None if request.model is None else (await find_model(daemon, request.model)).id
    await daemon.use_controller(request.controller, model)
    return describe(daemon)


@router.get("/lease")
async def show_lease(daemon: TheDaemon) -> Lease:
    """Who commands the arm."""
    return Lease.model_validate(daemon.lease.document())


@router.put("/lease", responses=responses("held"))
async def take_lease(daemon: TheDaemon, client: Client, request: LeaseRequest) -> Lease:
    """Take or prolong the command of the arm. Every command does so for half a minute, too."""
    daemon.lease.take(client, request.seconds)
    daemon.events.publish("lease", daemon.lease.document())
    return Lease.model_validate(daemon.lease.document())


@router.delete("/lease", responses=responses("held"))
async def give_lease_back(daemon: TheDaemon, client: Client) -> Lease:
    """Let others command."""
    if not daemon.lease.release(client) and daemon.lease.current():
        holder = daemon.lease.current()
        raise Problem("held", f"{holder} holds the lease, not {client}", holder=holder)
    daemon.events.publish("lease", daemon.lease.document())
    return Lease.model_validate(daemon.lease.document())


def describe(daemon: Daemon) -> RobotState:
    """The robot's state as clients see it."""
    document = daemon.robot.document() | {"lease": daemon.lease.document()}
    for axis in document["axes"]:
        state = daemon.robot.device.state(axis["status_word"])
        axis["drive_state"] = None if state is None else str(state)
    return RobotState.model_validate(document)
