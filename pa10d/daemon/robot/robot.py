"""The robot as the daemon sees it: the control process, the recorder, the state they tell."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backends.device import Device
from backends.registry import device
from pa10d.control.ring import Ring
from pa10d.control.states import POWERED, SWITCHING, ArmState
from pa10d.daemon.events import Events
from pa10d.daemon.processes.child import Child
from pa10d.daemon.processes.link import LinkClosed, Message
from pa10d.daemon.robot.fault_files import keep_fault
from pa10d.dynamics import Robot
from pa10d.profile import Gains, Profile

Array = NDArray[np.float64]

RING_SECONDS = 20.0
START_TIME = 180.0  # s for imports and compilation on a slow machine
SWITCHED = 30.0  # s for the drives to be enabled, disabled or reset, or to say why not
COMES_BACK = 60.0  # s for a new control process, before a reset says that there is none yet
ALIVE_EVERY = 0.5  # s
RECONNECT_EVERY = 2.0  # s between attempts while the robot is offline
LAST_WORDS = 1.0  # s for the recorder to close a run once control has ended
STARTING = "the control process is starting"
GONE = {
    "kind": "control_gone",
    "joint": None,
    "remedy": "the drives stopped by themselves; look at the log, then reset",
}

log = logging.getLogger("pa10d.robot")


class CommandRefused(Exception):
    """Control said no: its answer has ``detail`` and, mostly, ``state``, ``needed``, ``remedy``."""

    def __init__(self, answer: Message) -> None:
        super().__init__(answer.get("detail", "refused"))
        self.answer = answer


class RobotProcess:
    """Control and recorder of one robot, started again when they die; a death is a fault."""

    def __init__(
        self, profile: Profile, robot: Robot, data: Path, runtime: Path, events: Events
    ) -> None:
        self.profile, self.robot, self._data, self._events = profile, robot, data, events
        self.device = device(profile)
        self._runtime = runtime
        period = 1.0 / profile.control.rate
        self.ring = Ring.create(robot.n, int(RING_SECONDS / period), period, runtime / "ring")
        (runtime / "profile.json").write_text(profile.model_dump_json())
        self.control: Child | None = None
        self.recorder: Child | None = None
        self.notes: list[str] = []
        self.why_offline = STARTING
        self.remark: str | None = None  # what the daemon knows of the arm beside control
        self.controller: Message = {"name": "pid"}
        self.model: str | None = None
        self.joints: Message | None = None  # what a first motion has measured
        self.inherit: Sequence[int] = ()
        self._told: Message = {"state": "offline", "fault": None, "controller": "pid"}
        self._gone: Message | None = None
        self._changed = asyncio.Condition()
        self._keepers: list[asyncio.Task[None]] = []
        self._alive: asyncio.Task[None] | None = None
        self._keeps = True
        self._wanted = True  # connected whenever possible
        self.bus_ready = asyncio.Event()  # nobody answers before that
        self._awaited: dict[str, asyncio.Future[Message]] = {}

    # -- life -------------------------------------------------------------------------------

    def start(self) -> None:
        """Start both processes and keep them; a profile without drives is for recordings alone."""
        if lacking := self.device.lacking(self.profile):
            self.why_offline = lacking
            return
        loop = asyncio.get_running_loop()
        self._keepers = [
            loop.create_task(self._keep_control()),
            loop.create_task(self._keep_recorder()),
        ]
        self._alive = loop.create_task(self._stay_alive())

    def keep_no_more(self) -> None:
        """A process that ends from now on is not started again."""
        self._keeps = False
        for task in self._keepers:
            task.cancel()

    async def close(self, seconds: float) -> None:
        """Bring the arm to rest and end both processes; what has not ended by then is killed."""
        self.keep_no_more()
        await asyncio.gather(*self._keepers, return_exceptions=True)
        if self.control is not None:
            await self.control.end(seconds - LAST_WORDS)
        if self.recorder is not None:
            await self.recorder.end(LAST_WORDS, polite=False)
        if self._alive is not None:
            self._alive.cancel()

    # -- what is known ----------------------------------------------------------------------

    @property
    def state(self) -> str:
        """The arm's state as clients see it."""
        return "fault" if self._gone else str(self._told["state"])

    @property
    def fault(self) -> Message | None:
        """The latched fault."""
        return self._gone or self._told["fault"]

    @property
    def moving(self) -> bool:
        """Whether torque is on."""
        return self.state in _POWERED

    @property
    def braking_time(self) -> float:
        """s that the arm needs at most to come to rest along its limits."""
        with np.errstate(all="ignore"):
            longest = float(np.max(self.robot.velocity / self.robot.acceleration))
        return longest if np.isfinite(longest) else 0.0

    def document(self) -> dict[str, Any]:
        """All there is to know, for clients."""
        last, get = self.ring.last(), self.ring.layout.get
        offline = self.state == "offline" or last is None
        model = self.controller.get("model") or {}
        axes = [] if offline or last is None else [
            {
                "joint": j + 1,
                "name": name,
                "position": float(get(last, "q")[j]),
                "velocity": float(get(last, "dq")[j]),
                "torque": float(get(last, "tau")[j]),
                "target": float(get(last, "q_ref")[j]),
                "temperature": _finite(get(last, "temperature")[j]),
                "status_word": int(get(last, "status")[j]),
                "age": int(get(last, "age")[j]),
            }
            for j, name in enumerate(self.robot.joint_names)
        ]  # fmt: skip
        return {
            "profile": self.profile.name,
            "state": self.state,
            "fault": self.fault,
            "offline_reason": self.why_offline if self.state == "offline" else None,
            "controller": self.controller["name"],
            "model": model.get("name"),
            "model_parameters": model.get("parameters"),
            "rate": self.profile.control.rate,
            "simulated": self.profile.simulation is not None,
            "notes": [*self._notes(), *_remarks(self.device, axes)],
            "recording": not offline and last is not None and bool(get(last, "recording")),
            "time": None if offline or last is None else float(get(last, "time")),
            "axes": axes,
        }

    def pose(self) -> Array:
        """(n,) rad where the arm is held (its reference), or measured while unpowered."""
        last = self.ring.last()
        if last is None:
            return np.zeros(self.robot.n)
        field = "q_ref" if self.moving else "q"
        return np.array(self.ring.layout.get(last, field))

    async def until(self, *states: str, timeout: float) -> str:
        """Wait for one of the states; the state that there is when it came or time was over."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout), self._changed:
                await self._changed.wait_for(lambda: self.state in states)
        return self.state

    # -- commands ---------------------------------------------------------------------------

    async def command(self, do: str, timeout: float = 15.0, **fields: Any) -> Message:
        """Ask control; CommandRefused with its reasons."""
        if self.control is None:
            raise CommandRefused(self._no_control(do))
        try:
            answer = await self.control.link.ask(do, timeout, **fields)
        except LinkClosed as error:
            raise CommandRefused({**self._no_control(do), "detail": f"{do}: {error}"}) from error
        if not answer["ok"]:
            raise CommandRefused(answer)
        return answer

    async def enable(self) -> None:
        """Until the arm is held, or in fault, or somebody has stopped that."""
        await self._switch("enable")

    async def disable(self) -> None:
        """Until the arm is unpowered, or in fault."""
        await self.command("disable")
        await self.until("inactive", "fault", "offline", timeout=SWITCHED + self.braking_time)

    async def _switch(self, do: str) -> None:
        await self.command(do, timeout=SWITCHED)
        await self.until(*_SETTLED, timeout=SWITCHED)

    async def reset(self) -> None:
        """Leave a fault, also the one that control's own death was."""
        if self._gone is not None:
            await self._bring_back()
        await self._switch("reset")
        if self.state == "fault":
            raise CommandRefused(self._still_in_fault())

    async def use(self, controller: Message, model: str | None = None) -> None:
        """``{"name": "pid"}`` or ``{"name": "computed_torque", "model": {live model}}``; model: the
        id under which the whole of it is stored."""
        await self.command("controller", **controller)
        self.controller, self.model = controller, model

    async def use_gains(self, gains: Message, keep: bool) -> None:
        """Gains (``PidGains``) for every servo from now on; keep: also after control's death."""
        await self.command("gains", gains=gains)
        if keep:
            self.keep_gains(gains)

    def keep_gains(self, gains: Message) -> None:
        """For every control process that starts from now on; what the profile names stays."""
        given = self.profile.control.gains
        chosen = {k: getattr(given, k) or gains[k] for k in ("kp", "ki", "kd")}
        control = self.profile.control.model_copy(update={"gains": Gains(**chosen)})
        profile = self.profile.model_copy(update={"control": control})
        (self._runtime / "profile.json").write_text(profile.model_dump_json())

    def stop(self) -> None:
        """At once, without waiting for an answer."""
        if self.control is not None:
            with contextlib.suppress(LinkClosed):
                self.control.link.tell("stop")

    def look(self) -> None:
        """Have control look at the drives, also where simulated time stands still."""
        if self.control is not None:
            with contextlib.suppress(LinkClosed):
                self.control.link.tell("look")

    async def connect(self) -> None:
        """Try to reach the drives now, and from now on whenever they are away."""
        self._wanted = True
        await self.command("connect", timeout=60.0)

    async def disconnect(self) -> None:
        """Leave the bus."""
        await self.command("disconnect")
        self._wanted = False
        self.why_offline = "disconnected on request"

    async def record(self, do: str, **fields: Any) -> Message:
        """Ask the recorder; where it is being started again, that is waited for."""
        until = time.monotonic() + START_TIME
        while self.recorder is None and self._keeps and time.monotonic() < until:
            await asyncio.sleep(0.1)
        if self.recorder is None:
            raise CommandRefused({"detail": "the recorder does not start; look at the log"})
        try:
            answer = await self.recorder.link.ask(do, **fields)
        except LinkClosed as error:
            raise CommandRefused({"detail": f"recorder: {error}"}) from error
        if not answer["ok"]:
            raise CommandRefused(answer)
        return answer

    def expect_run(self, run: str) -> asyncio.Future[Message]:
        """The description of this run once the recorder has closed it."""
        self._awaited[run] = asyncio.get_running_loop().create_future()
        return self._awaited[run]

    def forget_run(self, run: str) -> None:
        """Nobody waits for it any more."""
        future = self._awaited.pop(run, None)
        if future is not None and future.done() and not future.cancelled():
            future.exception()  # seen

    # -- keeping the processes --------------------------------------------------------------

    async def _keep_control(self) -> None:
        while True:
            arguments = ["--profile", str(self._runtime / "profile.json")]
            arguments += ["--ring", str(self._runtime / "ring")]
            child = await Child.start(
                "control", "pa10d.control", arguments, self._heard, self.inherit
            )
            if await child.ready(START_TIME):
                self.control, self.notes = child, list(child.welcome["notes"])
                log.info("control process %d is ready", child.pid)
                await self._watch_control(child)
            await child.end(1.0, polite=False)
            self._control_died(child)
            await asyncio.sleep(1.0)

    async def _watch_control(self, child: Child) -> None:
        ended = asyncio.ensure_future(child.process.wait())
        try:
            if self.controller["name"] != "pid":
                with contextlib.suppress(CommandRefused):
                    await self._connect()
                    await self.command("controller", **self.controller)
            while not ended.done():
                if self._wanted and self.state == "offline":
                    await self._connect()
                await asyncio.wait([ended], timeout=RECONNECT_EVERY)
        finally:
            ended.cancel()

    async def _connect(self) -> None:
        await self.bus_ready.wait()
        try:
            await self.command("connect", timeout=60.0)
        except CommandRefused as refusal:
            self.why_offline = str(refusal).removeprefix("connect: ")

    def _control_died(self, child: Child) -> None:
        self.control = None
        was = str(self._told["state"])
        how = child.how_it_ended()
        self.why_offline = f"the control process {how}; it is being started again"
        log.warning("control process %s while %s", how, was)
        if was != "offline":
            cause = f"the control process {how} while the arm was {was}"
            sentence = f"{cause}; {GONE['remedy']}"
            self._gone = {**GONE, "cause": cause, "state": was, "sentence": sentence,
                          "time": 0.0, "sequence": self.ring.written, "device": False}  # fmt: skip
            keep_fault(self._data, self._gone, self.ring, self.robot.joint_names)
        self._told = {"state": "offline", "fault": None, "controller": "pid"}
        self._announce()

    async def _keep_recorder(self) -> None:
        while True:
            arguments = ["--profile", str(self._runtime / "profile.json")]
            arguments += ["--ring", str(self._runtime / "ring"), "--data", str(self._data)]
            arguments += ["--joints", *self.robot.joint_names]
            child = await Child.start(
                "recorder", "pa10d.recorder", arguments, self._heard, self.inherit
            )
            if await child.ready(START_TIME):
                self.recorder = child
                await child.process.wait()
            await child.end(1.0, polite=False)
            self.recorder = None
            self.ring.taken = -1
            if self.state == "running":
                self.stop()
            log.warning("recorder %s; it is being started again", child.how_it_ended())
            for future in self._awaited.values():
                if not future.done():
                    future.set_exception(CommandRefused({"detail": "the recorder process ended"}))
            await asyncio.sleep(0.5)

    async def _stay_alive(self) -> None:
        while True:
            if self.control is not None:
                with contextlib.suppress(LinkClosed):
                    self.control.link.tell("alive")
            await asyncio.sleep(ALIVE_EVERY)

    def _heard(self, message: Message) -> None:
        if message["event"] == "run":
            info = {k: v for k, v in message.items() if k != "event"}
            self._events.publish("run", info)
            if info["status"] == "failed" and self.state == "running":
                self.stop()  # a motion that nobody records goes no further
            future = self._awaited.get(info["id"])
            if future is not None and not future.done():
                future.set_result(info)
            return
        before, self._told = self._told, message
        if message["fault"] and message["fault"] != before["fault"]:
            keep_fault(self._data, message["fault"], self.ring, self.robot.joint_names)
        self._announce()

    def _announce(self) -> None:
        self._events.publish("robot", {"state": self.state, "fault": self.fault})

        async def wake() -> None:
            async with self._changed:
                self._changed.notify_all()

        asyncio.get_running_loop().create_task(wake())

    def _notes(self) -> list[str]:
        said = [] if self.remark is None else [self.remark]
        return [*said, *self.notes, *self._told.get("warnings", ())]

    async def _bring_back(self) -> None:
        """Control had died: the next one connects, and whatever the drives think of that death is
        acknowledged with the reset that follows."""
        until = time.monotonic() + COMES_BACK
        while self.control is None and self._keepers and time.monotonic() < until:
            await asyncio.sleep(0.1)
        if self._told["state"] == "offline":
            await self.bus_ready.wait()
            await self.connect()
        self._gone = None
        self._announce()

    def _still_in_fault(self) -> Message:
        fault = self.fault or {}
        return {
            "ok": False,
            "command": "reset",
            "state": self.state,
            "needed": [ArmState.FAULT.label],
            "detail": f"reset: {fault.get('sentence', 'the fault persists')}",
            "remedy": fault.get("remedy", "remove the cause, then reset"),
        }

    def _no_control(self, do: str) -> Message:
        return {
            "ok": False,
            "command": do,
            "state": self.state,
            "needed": [ArmState.INACTIVE.label],
            "detail": f"{do}: {self.why_offline}",
            "remedy": "wait a few seconds, then look at the robot's state again"
            if self._keepers
            else "add 'drives' to the profile, one entry per joint",
        }


def _remarks(words: Device, axes: list[Message]) -> list[str]:
    """What drives say beside their states, now."""
    return [
        f"joint {axis['joint']}: {remark}"
        for axis in axes
        for remark in words.remarks(axis["status_word"])
    ]


_POWERED = frozenset(state.label for state in POWERED)
_SETTLED = tuple(state.label for state in ArmState if state not in SWITCHING)


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
