"""All that the daemon is made of, and how it begins and ends."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pa10d.common.disk import disk_words
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.words import listed
from pa10d.control.known_joints import MeasuredJoints
from pa10d.daemon.events import Events
from pa10d.daemon.hanging import with_weight
from pa10d.daemon.jobs.jobs import Job, Jobs, Progress, Report, Work
from pa10d.daemon.jobs.shelf import Shelf
from pa10d.daemon.night import Night, Secret
from pa10d.daemon.notify import notify, watchdog_period
from pa10d.daemon.processes.budget import of_a_job, of_an_answer
from pa10d.daemon.processes.crowded import Crowded
from pa10d.daemon.processes.simulator import Simulator, wants_simulator
from pa10d.daemon.processes.workers import TaskFailed, Workers
from pa10d.daemon.robot.lease import Lease
from pa10d.daemon.robot.robot import RobotProcess
from pa10d.daemon.robot.telemetry import Telemetry
from pa10d.dynamics import Robot
from pa10d.identify.scale import Body
from pa10d.investigation.archive import Archive
from pa10d.profile import Gains, Profile, load_profile
from pa10d.services.joints import kept_joints
from pa10d.services.robots import load_robot
from pa10d.services.tuning import own_profile
from pa10d.services.weighing.archive import Weighings
from pa10d.store import RunStore
from pa10d.store.models import ModelStore

MOVING = ("experiment", "series", "tracking", "improvement", "investigation", "weighing")
"""Kinds of jobs that move the arm."""

# of a profile, while it is served:
TUNED = ("path", "drives", "limits", "control", "safety", "environment")
SWITCHED, CONNECTED = 5.0, 60.0  # s for an arm to be off, and on again
HANGS = "a weight hangs on the virtual arm: {}; 'pa10d weigh record NAME' takes it off"
LOOK_EVERY = 0.5  # s between looks at the virtual arm
END_TIME = 6.0  # s for the whole daemon to end, beside what braking the arm takes
BEFORE_JOBS = 5  # niceness of what a request waits for
FOR_THE_ARM = 4.0  # s of it are kept for control, should jobs not end at once

log = logging.getLogger("pa10d.daemon")


class Daemon:
    """One robot, one data folder. Everything here runs in one event loop and never computes."""

    def __init__(
        self,
        profile: Profile,
        robot: Robot,
        data: Path,
        runtime: Path,
        *,
        simulator: bool = True,
        inherit: Sequence[int] = (),
        secret: Secret | None = None,
    ) -> None:
        """simulator: start the virtual arm too, where the profile has one; secret: what it
        hides."""
        self.profile, self.kinematics, self.data = profile, robot, data
        self.began = time.monotonic()
        self.events = Events()
        self.runs, self.models = RunStore(data), ModelStore(data)
        self.investigations = Archive(data)
        self.pauses: set[str] = set()  # investigations that are to rest after this step
        self.jobs = Jobs(data / "jobs", self.events)
        self.shelf, self.changes = Shelf("look"), Shelf("change")  # what takes the lock is apart
        self.workers = Workers(of_a_job())
        self.desk = Workers(of_an_answer(), most=2, niceness=BEFORE_JOBS)
        self.viewer = Workers(of_an_answer(), most=1, niceness=0)
        self.weighings = Weighings(data)
        self.robot = RobotProcess(profile, robot, data, runtime, self.events)
        self.robot.inherit = inherit
        self.robot.not_held = self._why_not_held
        self._judged: tuple[Gains, MeasuredJoints | None, str | None] | None = None
        self.robot.joints = self.measured_joints()
        if self.robot.joints is not None:
            self.robot.keep_gains(self.robot.joints.known.gains)
        self.runtime = runtime
        self.telemetry = Telemetry(self.robot.ring, robot)
        self.lease = Lease(busy=lambda: any(job.kind in MOVING for job in self.jobs.running()))
        self.simulator = Simulator(profile) if simulator and wants_simulator(profile) else None
        if self.simulator is not None:
            self.robot.no_arm = self._why_no_arm
        self._arm = profile  # the virtual one, without a weight
        self._hung: Body | None = None
        self._changing = asyncio.Lock()  # the profile, or the virtual arm
        self.night = Night(secret if self.simulator is not None else None, data)
        self._tasks: list[asyncio.Task[None]] = []
        self._eyes_open = False
        self._ending: asyncio.Future[None] | None = None

    def measured_joints(self) -> MeasuredJoints | None:
        """What is kept of the joints, by the profile's file, as every plan and table looks it up:
        what a virtual arm hides is in our memory only, and would look like another arm."""
        return kept_joints(self.data, load_profile(self.profile.path))

    async def _why_not_held(self) -> str | None:
        """Looked at by a worker, once for what is in force; gains by the rule need no look."""
        gains, joints = self.profile.control.gains, self.robot.joints
        if gains == Gains():
            return None
        known = self._judged
        if known is None or known[0] is not gains or known[1] is not joints:
            why = await self.tuning("why_not_held", gains=gains.model_dump())
            self._judged = known = gains, joints, why
        return known[2]

    def _why_no_arm(self) -> str | None:
        return None if self.simulator is None else self.simulator.refusal

    @property
    def uptime(self) -> float:
        """s since it began."""
        return time.monotonic() - self.began

    async def start(self) -> None:
        """Bring everything up; the robot connects by itself as soon as it can."""
        loop = asyncio.get_running_loop()
        self.robot.start()
        self._tasks = [
            loop.create_task(self._provide_bus()),
            loop.create_task(self._look_after_the_arm()),
            loop.create_task(self.telemetry.run()),
            loop.create_task(self._judge_weighings()),
            loop.create_task(_feed_watchdog()),
        ]
        notify("READY=1", f"STATUS=serving {self.profile.name}")

    async def close(self) -> None:
        """The arm comes to rest first, then everything ends. Whoever asks again waits for it."""
        if self._ending is None:
            self._ending = asyncio.ensure_future(self._end())
        await asyncio.shield(self._ending)

    async def _end(self) -> None:
        """One limit for all of it: whatever does not end by itself in time is killed."""
        notify("STOPPING=1")
        clock = asyncio.get_running_loop().time
        until = clock() + END_TIME + self.robot.braking_time
        self.robot.keep_no_more()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout_at(until - FOR_THE_ARM):
                await self.jobs.close()
        await self.robot.close(until - clock())
        for task in self._tasks:
            task.cancel()
        for ended in await asyncio.gather(*self._tasks, return_exceptions=True):
            if isinstance(ended, Exception):
                log.error("a task of the daemon had failed", exc_info=ended)
        for workers in (self.workers, self.desk, self.viewer):
            workers.close()
        self.shelf.close()
        self.changes.close()
        if self.simulator is not None:
            await self.simulator.close()

    async def _provide_bus(self) -> None:
        if self.simulator is not None:
            await self.simulator.start()
        self.robot.bus_ready.set()

    async def _look_after_the_arm(self) -> None:
        """Say so when the virtual arm has died, as no fault of its drives would."""
        while self.simulator is not None:
            dead = self.simulator.dead
            remark = dead and f"the virtual arm's process {dead}; 'reset' starts it anew"
            if remark != self.robot.remark:
                self.robot.remark = remark
                self.robot.look()
                self.events.publish("robot", self.robot.brief)
            await asyncio.sleep(LOOK_EVERY)

    async def reset(self) -> None:
        """Leave a fault, and bring back what has died: control, and the virtual arm."""
        await self.revive()
        await self.robot.reset()

    async def revive(self) -> None:
        """A virtual arm that was started here and has died is started again."""
        if self.simulator is not None and self.simulator.dead:
            self.robot.bus_ready.clear()
            try:
                await self.simulator.start()
                self.robot.arm_is_new = True
            finally:
                self.robot.bus_ready.set()
            self.robot.remark = None

    def busy(self) -> str | None:
        """Why nothing else may move or change the arm now, None where it may."""
        if self._changing.locked():
            return "the profile, or the virtual arm, is being changed"
        job = next((job for job in self.jobs.running() if job.kind in MOVING), None)
        return None if job is None else f"a job that moves the arm is running: {job.kind}"

    async def pass_night(self) -> None:
        """The virtual arm is switched off and on again, as it is on the next day."""
        await self.night.passes(self._next_arm)
        self.events.publish("story", self.night.document())

    async def _next_arm(self, profile: Profile) -> None:
        await self._switch_arm(profile, None)
        self._arm = profile

    async def hang(self, body: Body | None) -> None:
        """Bolt a weight on the virtual arm, or take it off: switched off meanwhile, as a real one
        would be."""
        if body != self._hung:
            await self._switch_arm(
                self._arm if body is None else with_weight(self._arm, body), body
            )

    async def _switch_arm(self, profile: Profile, hung: Body | None) -> None:
        """To its end, whatever becomes of who asked: half of it would leave no arm at all, or one
        with a weight that nobody knows of."""
        switching = asyncio.ensure_future(self._switch_whole_arm(profile, hung))
        try:
            await asyncio.shield(switching)
        except asyncio.CancelledError:
            await asyncio.wait([switching])
            raise

    async def _switch_whole_arm(self, profile: Profile, hung: Body | None) -> None:
        assert self.simulator is not None
        self.simulator.refuse_unless_own()
        async with self._changing:
            await self.robot.disconnect()
            await self.robot.until("offline", timeout=SWITCHED)
            await self.simulator.become(profile)
            self.robot.arm_is_new = True
            self._hung = hung
            self.robot.load = None if hung is None else HANGS.format(hung.words)
            await self.robot.connect()
            await self.robot.until("inactive", "fault", timeout=CONNECTED)

    def open_eyes(self) -> None:
        """Somebody has opened the page: have the viewer's libraries loaded before they look."""
        if not self._eyes_open:
            self._eyes_open = True
            self._tasks.append(asyncio.get_running_loop().create_task(self._warm_up_viewer()))

    async def _warm_up_viewer(self) -> None:
        with contextlib.suppress(TaskFailed, UserError, Crowded):
            await self.viewer.run("pa10d.services.plots:warm_up", lambda *_: None)

    async def _judge_weighings(self) -> None:
        """What was recorded before the last end, and is not analysed yet."""
        try:
            for state in await self.shelf(self.weighings.all):
                if state.pending:
                    self.compute("gains", "judge_weighing", {"weighing": state.id})
        except OSError as error:
            log.warning("what was weighed before is not judged: %s", disk_words(error))
        except Crowded:
            pass

    def compute(
        self, kind: str, task: str, request: JsonObject, *, sheet: bool = False, **more: Any
    ) -> Job:
        """Start a job that one worker carries out: a function of ``pa10d.daemon.jobs.tasks``.

        sheet: the task takes a folder for its plots and words, too.
        """

        async def work(report: Report) -> Any:
            if sheet:
                more["sheet"] = str(self.jobs.folder_of(report.job))
            return await self.compute_now(task, report, **request, **more)

        return self.jobs.start(kind, request, work)

    async def compute_now(self, task: str, progress: Progress, **arguments: Any) -> Any:
        """The result of a task, for a job that has more to do."""
        call = f"pa10d.daemon.jobs.tasks:{task}"
        return await self.workers.run(call, progress, data=str(self.data), **arguments)

    async def answer(self, task: str, **arguments: Any) -> Any:
        """The result of a short task, for a request that waits for it; jobs are not before it."""
        call = f"pa10d.daemon.jobs.tasks:{task}"
        return await self.desk.run(call, lambda *_: None, data=str(self.data), **arguments)

    async def look(self, plot: str, *, of: str = "plots", **arguments: Any) -> Any:
        """The result of a function of ``pa10d.services.plots``, or of another module ``of`` the
        services, from a process that waits for nothing else and remembers what it read."""
        call = f"pa10d.services.{of}:{plot}"
        return await self.viewer.run(call, lambda *_: None, data=str(self.data), **arguments)

    async def tune(self, restart: bool, task: str, **arguments: Any) -> JsonObject:
        """Write or undo a change of the profile, and go on with it. task: of
        ``pa10d.services.tuning``, or ``module:task`` of another of the services; restart: it is
        about more than the surroundings, which only plans look at."""
        if (busy := self.busy()) is not None:
            raise UserError(f"profile: {busy}; expected to be asked once that is over")
        async with self._changing:
            return await self._tune(restart, task, arguments)

    async def _tune(self, restart: bool, task: str, arguments: JsonObject) -> JsonObject:
        await asyncio.to_thread(self._refuse_edits)
        of, _, task = task.rpartition(":")
        made: JsonObject = {}
        which = {} if of else self._which()

        async def change() -> tuple[Profile, Robot]:
            made.update(await self.look(task, of=of or "tuning", **which, **arguments))
            loaded, robot = await asyncio.to_thread(load_robot, made["file"])
            if self.robot.joints is not None:
                self.robot.joints = await asyncio.to_thread(kept_joints, self.data, loaded)
            tuned = {key: getattr(loaded, key) for key in TUNED}
            return self.profile.model_copy(update=tuned), robot

        if restart:
            await self.robot.renew(change)
        else:
            self.robot.profile, self.robot.robot = await change()
        self.profile, self.kinematics = self.robot.profile, self.robot.robot
        self.telemetry.robot = self.kinematics
        self.events.publish("profile", {"version": made["version"]})
        return made

    def _refuse_edits(self) -> None:
        """What somebody has written into the file meanwhile does not go into force unsaid."""
        stands = load_profile(own_profile(self.data, self.profile.path))
        edited = [key for key in TUNED[1:] if getattr(stands, key) != getattr(self.profile, key)]
        if edited:
            raise UserError(
                f"{stands.path}: {listed(edited)} changed since it is served; expected that to be "
                "taken back by hand, or 'serve' to be started anew with it"
            )

    async def tuning(self, task: str, **arguments: Any) -> Any:
        """A question about the profile's tuning."""
        return await self.look(task, of="tuning", **self._which(), **arguments)

    def _which(self) -> dict[str, str]:
        return {"profile": str(self.profile.path)}

    async def use_controller(self, name: str, model: str | None) -> None:
        """Another control law; all but PID need a model of the store."""
        if name == "pid":
            await self.robot.law.use({"name": "pid"})
            return
        if model is None:
            raise UserError(f"controller '{name}': expected 'model', a model's name")
        live = await self.answer("live_model_of", model=model)
        await self.robot.law.use({"name": name, "model": live}, model)

    def move(self, kind: str, request: JsonObject, work: Work) -> Job:
        """Start a job of one of the ``MOVING`` kinds: a stop from now on ends it."""
        began = self.robot.stops.count

        async def heeding(report: Report) -> Any:
            with self.robot.stops.heard_by(began):
                return await work(report)

        return self.jobs.start(kind, request, heeding)

    def stop(self) -> None:
        """Rest, whoever asks. A running experiment ends as stopped; what was about to move the arm
        does not any more."""
        self.robot.stops.ask()
        self.robot.stop()


async def _feed_watchdog() -> None:
    """Tell systemd that this loop still turns."""
    period = watchdog_period()
    while period is not None:
        notify("WATCHDOG=1")
        await asyncio.sleep(period)


@contextlib.asynccontextmanager
async def running(daemon: Daemon):
    """From start to close."""
    try:
        await daemon.start()
        yield daemon
    finally:
        await daemon.close()
