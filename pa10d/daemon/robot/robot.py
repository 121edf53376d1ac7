"""The robot as the daemon sees it: the control process, the recorder, the state they tell."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import time
from collections.abc import Awaitable, Callable, Coroutine, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backends.registry import device
from pa10d.common.disk import sharing
from pa10d.common.errors import NotNow, UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.shortage import Short
from pa10d.control.brake_proof import Unheld, why_still_powered
from pa10d.control.faults import Fault
from pa10d.control.gains import PidGains
from pa10d.control.known_joints import MeasuredJoints
from pa10d.control.messages import Weights
from pa10d.control.outside import Outside, outside
from pa10d.control.ring import Ring
from pa10d.control.rows import sealed
from pa10d.control.states import EACH, POWERED, SWITCHING, ArmState
from pa10d.control.told import ArmTold
from pa10d.control.whereabouts import Misplaced
from pa10d.daemon.events import Events
from pa10d.daemon.offline import AGAIN, LEFT, RENEWED, STARTING, passes
from pa10d.daemon.processes.child import Child
from pa10d.daemon.processes.link import LinkClosed, Message
from pa10d.daemon.robot.awaited import AwaitedRuns
from pa10d.daemon.robot.axes import axes_of, remarks_of
from pa10d.daemon.robot.chosen_law import ChosenLaw
from pa10d.daemon.robot.doubted_signs import DoubtedSigns
from pa10d.daemon.robot.fault_files import keep_fault
from pa10d.daemon.robot.liveness import Liveness
from pa10d.daemon.robot.recorder import LAST_WORDS, SHORT_FOR, START_TIME, KeptRecorder
from pa10d.daemon.robot.refusals import (
    UNPOWERED,
    CommandRefused,
    being_started,
    no_control,
    no_virtual_arm,
    not_to_be_held,
    not_unpowered,
    still_in_fault,
    still_powered,
)
from pa10d.daemon.robot.stood import StoodAt
from pa10d.daemon.robot.stops import MOVES, Stops
from pa10d.dynamics import Robot
from pa10d.profile import Gains, Profile
from pa10d.store.run_info import load_info

Array = NDArray[np.float64]

RING_SECONDS = 20.0
SWITCHED = 30.0  # s for the drives to be enabled, disabled or reset, or to say why not
MEMORIES = 30.0  # s for drives to tell what they remember, some of them silent
COMES_BACK = 60.0  # s for a new control process, before a reset says that there is none yet
ALIVE_EVERY = 0.5  # s
RECONNECT_EVERY = 2.0  # s between attempts while the robot is offline
AT_REST = ("inactive", "fault")  # unpowered, and read
ENDED = 5.0  # s for control to end that holds nothing
DIED = "the drives stopped by themselves; look at the log, then reset"

log = logging.getLogger("pa10d.robot")


class RobotProcess:
    """Control and recorder of one robot, started again when they die; a death is a fault."""

    def __init__(
        self, profile: Profile, robot: Robot, data: Path, runtime: Path, events: Events
    ) -> None:
        self.profile, self.robot, self._data, self._events = profile, robot, data, events
        self.device = device(profile)
        self._runtime = runtime
        period = 1.0 / profile.control.rate
        self.ring = shared_ring(runtime, robot.n, period)
        self._hand_over(profile)
        self.control: Child | None = None
        self.recorder = KeptRecorder(self._begin_recorder, self._recorder_lost, self._recorder_back)
        self.notes: list[str] = []
        self.why_offline = STARTING
        self._missed = False  # the log has said that it is offline
        self.remark: str | None = None  # what the daemon knows of the arm beside control
        self.load: str | None = None  # what would be taken for the arm's own mass
        self.law = ChosenLaw(self.command, lambda: self._told)
        self.joints: MeasuredJoints | None = None  # what a first motion has measured
        self.inherit: Sequence[int] = ()
        self.no_arm: Callable[[], str | None] = lambda: None  # why no virtual arm can be there
        self.not_held: Callable[[], Coroutine[Any, Any, str | None]] = _held  # why it would swing
        self._told = ArmTold()
        self._gone: Fault | None = None  # that control's own death is
        self._changed = asyncio.Condition()
        self._keepers: list[asyncio.Task[None]] = []
        self._alive: asyncio.Task[None] | None = None
        self._asking: asyncio.Future[list[Message]] | None = None
        self._liveness, self._commanded = Liveness(ALIVE_EVERY), 0
        self._wanted = True  # connected whenever possible
        self._renewing = False  # control ends because it shall begin anew
        self._renewals = asyncio.Lock()  # what was wanted before one is no other's to remember
        self.bus_ready = asyncio.Event()  # nobody answers before that
        self.stops = Stops()
        self.runs = AwaitedRuns()
        self.stood = StoodAt(profile, data)
        self.doubted_signs = DoubtedSigns(profile, data)
        self.arm_is_new = False  # a virtual one was made, and stands where it begins

    # -- life -------------------------------------------------------------------------------

    def start(self) -> None:
        """Start both processes and keep them; a profile without drives is for recordings alone."""
        if lacking := self.device.lacking(self.profile):
            self.why_offline = lacking
            return
        loop = asyncio.get_running_loop()
        self._keepers = [
            loop.create_task(self._keep_control()),
            loop.create_task(self.recorder.keep()),
        ]
        self._alive = loop.create_task(self._stay_alive())

    def keep_no_more(self) -> None:
        """A process that ends from now on is not started again."""
        self.recorder.keeps = False
        for task in self._keepers:
            task.cancel()

    async def close(self, seconds: float) -> None:
        """Bring the arm to rest and end both processes; what has not ended by then is killed."""
        self.keep_no_more()
        await asyncio.gather(*self._keepers, return_exceptions=True)
        if self.control is not None:
            await self.control.end(seconds - LAST_WORDS)
        await self.recorder.end()
        if self._alive is not None:
            self._alive.cancel()
        self.stood.close()
        self.doubted_signs.close()

    # -- what is known ----------------------------------------------------------------------

    @property
    def state(self) -> str:
        """The arm's state as clients see it."""
        return "fault" if self._gone else self._told.state

    @property
    def fault(self) -> Fault | None:
        """The latched fault."""
        return self._gone or self._told.fault

    @property
    def brief(self) -> JsonObject:
        """State and fault for clients: drives that answer no more because their arm is dead want
        no cable looked at."""
        fault = self.fault
        if fault is not None and fault.device and self.remark is not None:
            fault = replace(fault, remedy=self.remark)
        return {"state": self.state, "fault": None if fault is None else fault.document()}

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

    def document(self) -> JsonObject:
        """All there is to know, for clients."""
        last, get = self.ring.last(), self.ring.layout.get
        offline = self.state == "offline" or last is None
        axes = axes_of(self.ring, self.robot, self.profile, self.state)
        return {
            "profile": self.profile.name,
            **self.brief,
            "offline_reason": self.why_offline if self.state == "offline" else None,
            "offline_passes": self.state == "offline" and passes(self.why_offline),
            "controller": self._told.controller,
            "model": self._told.model,
            "model_parameters": self.law.model_parameters,
            "rate": self.profile.control.rate,
            "simulated": self.profile.simulation is not None,
            "notes": [*self._notes(), *remarks_of(self.device, axes)],
            "recording": not offline and last is not None and bool(get(last, "recording")),
            "time": None if offline or last is None else float(get(last, "time")),
            "quiet": self._liveness.quiet if self.control is not None else 0.0,
            "axes": axes,
            "outside": [one.document() for one in self.outside()],
            "misplaced": [one.document() for one in self.misplaced()],
            "unheld": [one.document() for one in self.unheld()],
        }

    def pose(self) -> Array:
        """(n,) rad where the arm is held (its reference), or measured while unpowered."""
        last = self.ring.last()
        if last is None:
            return np.zeros(self.robot.n)
        field = "q_ref" if self.moving else "q"
        return np.array(self.ring.layout.get(last, field))

    def outside(self) -> list[Outside]:
        """Joints that stand outside their position limits, as they were read last."""
        last = self.ring.last()
        if last is None or self.state == "offline":
            return []
        q = self.ring.layout.get(last, "q")
        return outside(np.asarray(q), self.robot.lower, self.robot.upper)

    def misplaced(self) -> list[Misplaced]:
        """Joints that read elsewhere than they stood before their drive was set up anew."""
        return [] if self.state == "offline" else list(self._told.misplaced)

    def unheld(self) -> list[Unheld]:
        """Joints that their brakes did not hold, for which power stayed as it was to go last."""
        return list(self._told.unheld) if self.moving else []

    async def until(self, *states: str, timeout: float) -> str:
        """Wait for one of the states; the state that there is when it came or time was over."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout), self._changed:
                await self._changed.wait_for(lambda: self.state in states)
        return self.state

    # -- commands ---------------------------------------------------------------------------

    async def command(self, do: str, timeout: float = 15.0, **fields: Any) -> Message:
        """Ask control; CommandRefused with its reasons. Stopped where this would power or move the
        arm for a work that somebody has stopped."""
        if do in MOVES:
            self.stops.refuse()
        if self.control is None or self._renewing:
            raise CommandRefused(self._no_control(do))
        self._commanded += 1
        try:
            answer = await self.control.link.ask(do, timeout, **fields)
        except LinkClosed as error:
            raise CommandRefused({**self._no_control(do), "detail": f"{do}: {error}"}) from error
        finally:
            self._commanded -= 1
        self._liveness.heard()
        if not answer["ok"]:
            raise CommandRefused(answer)
        return answer

    async def follow(
        self, file: str, number: int, first: int, last: int, weight: Weights | None = None
    ) -> None:
        """Have control follow the rows of a file, which goes: it gets a copy that nobody changes
        any more. weight: see ``MotionUnderWay``."""
        try:
            memory = await asyncio.to_thread(_taken, Path(file))
        except OSError as error:
            raise NotNow(f"{file}: {error.strerror}; the motion has not begun") from error
        try:
            await self.command(
                "run", number=number, first=first, last=last, weight=weight, descriptors=(memory,)
            )
        finally:
            os.close(memory)

    def _no_control(self, do: str) -> Message:
        return no_control(do, self.state, self.why_offline, kept=bool(self._keepers))

    async def enable(self, recover: bool = False) -> None:
        """Until the arm is held, or in fault, or somebody has stopped that. recover: also where it
        stands outside its position limits."""
        with self.stops.heard_from_now():
            why = await self.stops.unless(self.not_held())
            if why is not None:
                raise CommandRefused(not_to_be_held(self.state, why))
            if self.state == "inactive" and not self._told.misplaced:
                await self.stood.forget()
            await self._switch("enable", recover=recover)
        await self._take_up_law()

    async def disable(self, anyway: bool = False) -> None:
        """Until the arm is unpowered, or in fault. CommandRefused where a brake does not hold it:
        its motors do, and power stays. anyway: also there."""
        await self.command("disable", anyway=anyway)
        ends = ("inactive", "holding", "fault", "offline")
        await self.until(*ends, timeout=SWITCHED + self.braking_time)
        if self.state == "holding" and (why := why_still_powered(self.unheld())) is not None:
            raise CommandRefused(still_powered(self.state, why))

    async def _switch(self, do: str, **fields: bool) -> None:
        await self.command(do, timeout=SWITCHED, **fields)
        await self.until(*_SETTLED, timeout=SWITCHED + EACH * self.robot.n)

    async def reset(self) -> None:
        """Leave a fault, also the one that control's own death was."""
        if self._gone is not None:
            await self._bring_back()
        await self._switch("reset")
        if self.state == "fault":
            raise CommandRefused(still_in_fault(self.state, self.fault))
        await self._believe_new_arm()
        await self._take_up_law()

    async def confirm(self) -> None:
        """Somebody has looked: every joint stands where it reads."""
        await self.command("confirm")

    async def believed(self, timeout: float) -> None:
        """Until every joint is, or time is over."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout), self._changed:
                await self._changed.wait_for(lambda: not self._told.misplaced)

    async def _believe_new_arm(self) -> None:
        """A virtual arm that was made anew begins where it begins: nobody moved it."""
        if self.arm_is_new and self.state == "inactive":
            await self.confirm()
            self.arm_is_new = False

    async def _take_up_law(self) -> None:
        await self.law.take_up(self.state)

    async def use_gains(
        self, gains: PidGains, keep: bool, felt: NDArray[np.float64] | None = None
    ) -> None:
        """Gains for every servo from now on; keep: also after control's death. felt: (n, 10) bodies
        that the arm is known to have."""
        await self.command("gains", gains=gains.document(), bodies=_listed(felt))
        if keep:
            self.keep_gains(gains)

    def keep_gains(self, gains: PidGains) -> None:
        """For every control process that starts from now on; what the profile names stays."""
        given, measured = self.profile.control.gains, gains.document()
        chosen = {k: getattr(given, k) or measured[k] for k in ("kp", "ki", "kd")}
        control = self.profile.control.model_copy(update={"gains": Gains(**chosen)})
        self._hand_over(self.profile.model_copy(update={"control": control}))

    def _hand_over(self, profile: Profile) -> None:
        """What every process that starts from now on begins with."""
        with sharing(self._runtime / "profile.json"):
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
        await self._reach()

    async def disconnect(self) -> None:
        """Leave the bus."""
        answer = await self.command("disconnect")
        self._wanted = False
        said = answer.get("said")
        self.why_offline = LEFT + (f"; {said}" if said else "")

    async def renew(self, change: Callable[[], Awaitable[tuple[Profile, Robot]]]) -> None:
        """Take over what ``change`` gives: the same arm under another profile. Control and recorder
        begin anew with it, and connect by themselves. CommandRefused unless the arm is unpowered;
        nobody can power it meanwhile."""
        async with self._renewals:
            await self._renew(change)

    async def _renew(self, change: Callable[[], Awaitable[tuple[Profile, Robot]]]) -> None:
        if self.state not in UNPOWERED or (self._keepers and self.control is None):
            raise CommandRefused(not_unpowered(self.state, self.why_offline))
        wanted = self._wanted
        if self.state != "offline":
            await self.disconnect()
            await self.until("offline", timeout=SWITCHED)
        self._wanted, self._renewing = False, True
        try:
            self.profile, self.robot = await change()
            self.stood.becomes(self.profile)
            self.doubted_signs.becomes(self.profile)
            self._hand_over(self.profile)
            if self.joints is not None:
                self.keep_gains(self.joints.known.gains)
            if self.control is not None:
                await self.control.end(ENDED)
            await self.recorder.end()
            while any(c is not None and c.process.returncode is not None
                      for c in (self.control, self.recorder.child)):  # fmt: skip
                await asyncio.sleep(0.01)  # until whoever keeps them has seen it
        finally:
            self._wanted, self._renewing = wanted, False

    async def drive_errors(self) -> list[Message]:
        """What the drives remember; whoever asks meanwhile gets the same answer."""
        if self._asking is None or self._asking.done():
            self._asking = asyncio.ensure_future(self._memories(clear=False))
        return await asyncio.shield(self._asking)

    async def clear_drive_errors(self) -> list[Message]:
        """Empty what they remember → what is left."""
        return await self._memories(clear=True)

    async def _memories(self, clear: bool) -> list[Message]:
        if self._keepers and not self.bus_ready.is_set():
            raise CommandRefused(being_started("errors", self.state))
        answer = await self.command("errors", timeout=MEMORIES, clear=clear)
        names = self.robot.joint_names
        return [{**one, "name": names[one["joint"] - 1]} for one in answer["drives"]]

    # -- keeping the processes --------------------------------------------------------------

    async def _keep_control(self) -> None:
        while True:
            arguments = ["--profile", str(self._runtime / "profile.json")]
            arguments += ["--ring", str(self._runtime / "ring")]
            try:
                child = await Child.start(
                    "control", "pa10d.control", arguments, self._heard, self.inherit
                )
            except Short as error:
                self._not_started(error)
                await asyncio.sleep(SHORT_FOR)
                continue
            if await child.ready(START_TIME):
                self.control, self.notes = child, list(child.welcome["notes"])
                self._liveness.heard()
                log.info("control process %d is ready", child.pid)
                await self._watch_control(child)
            await child.end(1.0, polite=False)
            self._control_died(child)
            await asyncio.sleep(1.0)

    def _not_started(self, error: Short) -> None:
        self.why_offline = f"the control process cannot be started: {error}"
        log.error("%s", self.why_offline)
        self._announce()

    async def _watch_control(self, child: Child) -> None:
        ended = asyncio.ensure_future(child.process.wait())
        try:
            if not (self._wanted or self._renewing):
                self.why_offline = LEFT
            while not ended.done():
                if self._wanted and self.state == "offline":
                    await self._connect()
                await asyncio.wait([ended], timeout=RECONNECT_EVERY)
        finally:
            ended.cancel()

    async def _connect(self) -> None:
        await self.bus_ready.wait()
        with contextlib.suppress(CommandRefused):
            await self._reach()

    async def _reach(self) -> None:
        """CommandRefused where the drives cannot be reached; clients see why, whoever tried."""
        try:
            if (why := self.no_arm()) is not None:
                raise CommandRefused(no_virtual_arm("connect", self.state, why))
            known = None if self.joints is None else self.joints.known
            await self.command(
                "connect",
                timeout=60.0,
                stood=self.stood.known,
                bodies=_listed(None if known is None else known.felt),
                measured=known is not None,
                doubted=list(self.doubted_signs.known),
            )
        except CommandRefused as refusal:
            why = str(refusal).removeprefix("connect: ")
            if refusal.answer.get("state", "offline") != "offline":
                raise  # another was quicker: it is there
            if why != self.why_offline:  # tried again and again, said once
                log.warning("the arm is offline: %s", why)
                self._missed = True
            self.why_offline = why
            raise
        if self._missed:
            log.warning("the arm is there: its drives answer")
            self._missed = False
        await self._believe_new_arm()
        await self._take_up_law()

    def _control_died(self, child: Child) -> None:
        self.control = None
        was = self._told.state
        how = child.how_it_ended()
        self.why_offline = RENEWED if self._renewing else f"the control process {how}; {AGAIN}"
        log.warning("control process %s while %s", how, was)
        if was != "offline":
            cause = f"the control process {how} while the arm was {was}"
            self._gone = Fault(
                "control_gone", cause, remedy=DIED, state=was, sequence=self.ring.written
            )
        self._told = ArmTold()
        self._announce()  # before all that may fail
        if self._gone is not None and was != "offline":
            keep_fault(self._data, self._gone, self.ring, self.robot.joint_names)

    async def _begin_recorder(self) -> Child:
        arguments = ["--profile", str(self._runtime / "profile.json")]
        arguments += ["--ring", str(self._runtime / "ring"), "--data", str(self._data)]
        arguments += ["--joints", *self.robot.joint_names]
        return await Child.start("recorder", "pa10d.recorder", arguments, self._heard, self.inherit)

    def _recorder_lost(self) -> None:
        self.ring.taken = -1
        if self.state in ("holding", "running"):  # a motion may have begun, and not be told of yet
            self.stop()
        self.runs.lost(CommandRefused({"detail": "the recorder process ended"}))

    async def _recorder_back(self, run: str) -> None:
        """Clients have it as being recorded still."""
        with contextlib.suppress(UserError):  # it has been deleted since
            info = await asyncio.to_thread(load_info, self._data / "runs" / run)
            self._events.publish("run", info.document())

    async def _stay_alive(self) -> None:
        while True:
            if self.control is not None:
                with contextlib.suppress(LinkClosed):
                    self.control.link.tell("alive")
                self._note_where_it_stands()
                why = self._liveness.tick(self.ring.written, commanded=self._commanded > 0)
                if why is not None:
                    log.error("control process %d: %s", self.control.pid, why)
                    await self.control.break_off(why)
                    self._liveness.heard()
            await asyncio.sleep(ALIVE_EVERY)

    def _note_where_it_stands(self) -> None:
        last, get = self.ring.last(), self.ring.layout.get
        if last is None or self._told.state not in AT_REST or self._told.misplaced:
            return
        if not np.any(get(last, "age")):
            self.stood.note(np.asarray(get(last, "q")), np.asarray(get(last, "dq")))

    def _heard(self, message: Message) -> None:
        if message["event"] == "alive":
            self._liveness.heard()
            return
        if message["event"] == "run":
            info = {k: v for k, v in message.items() if k != "event"}
            self._events.publish("run", info)
            if info["status"] == "failed" and self.state == "running":
                self.stop()  # a motion that nobody records goes no further
            self.runs.closed(info)
            return
        before, self._told = self._told, ArmTold.from_document(message)
        if self._told.signals > before.signals:
            self.stops.ask()
        fault = self._told.fault
        self._announce()  # before all that may fail
        if self._told.state != "offline":  # before that it does not know what is known here
            self.doubted_signs.note(self._told.doubted)
        if fault is not None and fault != before.fault:
            keep_fault(self._data, fault, self.ring, self.robot.joint_names)

    def _announce(self) -> None:
        self._events.publish("robot", self.brief)

        async def wake() -> None:
            async with self._changed:
                self._changed.notify_all()

        asyncio.get_running_loop().create_task(wake())

    def _notes(self) -> list[str]:
        said = [one for one in (self.remark, self.load, self.law.lost) if one is not None]
        return [*said, *self.notes, *self._told.warnings]

    async def _bring_back(self) -> None:
        """Control had died: the next one connects, and whatever the drives think of that death is
        acknowledged with the reset that follows."""
        until = time.monotonic() + COMES_BACK
        while self.control is None and self._keepers and time.monotonic() < until:
            await asyncio.sleep(0.1)
        if self._told.state == "offline":
            await self.bus_ready.wait()
            await self.connect()
        self._gone = None
        self._announce()


def shared_ring(runtime: Path, joints: int, period: float) -> Ring:
    """For control to write and everybody to read."""
    with sharing(runtime / "ring"):
        return Ring.create(joints, int(RING_SECONDS / period), period, runtime / "ring")


def _taken(file: Path) -> int:
    """What it holds, as sealed memory; both at once would take the room twice."""
    memory = sealed(file)
    file.unlink(missing_ok=True)
    return memory


def _listed(bodies: NDArray[np.float64] | None) -> list[list[float]] | None:
    return None if bodies is None else bodies.tolist()


async def _held() -> str | None:
    """Nobody knows of gains that would not hold the arm."""
    return None


_POWERED = frozenset(state.label for state in POWERED)
_SETTLED = tuple(state.label for state in ArmState if state not in SWITCHING)
