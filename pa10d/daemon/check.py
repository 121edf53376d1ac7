"""Go or no-go before power: wire, machine, drives, limits, disk, clock."""

from __future__ import annotations

import contextlib
import gc
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from itertools import zip_longest
from pathlib import Path

import numpy as np

from backends.canopen_cia402.lifeline import not_accepted
from backends.device import Device
from backends.protocol import Backend
from backends.registry import device, open_backend
from pa10d.common.errors import UserError
from pa10d.common.processor import stay_on_one, take_priority
from pa10d.control.build import build_arm
from pa10d.control.clock import Clock
from pa10d.control.gains import burdens
from pa10d.control.joint_figures import presumed_figures
from pa10d.control.limits import arm_limits
from pa10d.control.realtime import PRIORITY
from pa10d.control.ring import Ring
from pa10d.control.states import Refused
from pa10d.daemon.presence import present
from pa10d.daemon.processes.simulator import simulated_bus
from pa10d.daemon.timekeeping import rate_to_write
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.experiments.checks import Check
from pa10d.profile import Profile
from pa10d.services.tuning.arm import Tuned
from pa10d.services.tuning.by_hand import gain_checks, range_checks
from pa10d.store.folders import write_text
from pa10d.trajectory.limits import limits_of
from pa10d.trajectory.poses import CLEAR, Surroundings

SMALL_DISK = 2.0  # GB; an hour of a seven-axis run takes about one
SLOW_DISK = 0.1  # s for a small synchronous write
LATE = 0.25  # of a period that the latest cycle in a hundred may be late
SANE_YEAR = 2025


def check_robot(profile: Profile, robot: Robot, data: Path, seconds: float) -> list[Check]:
    """Every check; nothing is powered."""
    return [
        *_bus(profile),
        *_limits(profile, robot),
        *_by_hand(data, profile, robot),
        *carrying_checks(robot),
        *environment_checks(robot),
        *_disk(data),
        *_clock(),
        *_timing(profile, seconds),
        *_drives(profile, robot, data, seconds),
    ]


def _bus(profile: Profile) -> list[Check]:
    wire = device(profile).wire(profile)
    return [] if wire is None else [Check("ok" if wire.fits else "error", "bus", wire.sentence())]


def _limits(profile: Profile, robot: Robot) -> list[Check]:
    try:
        arm_limits(profile, robot)
    except UserError as error:
        return [Check("error", "limits", str(error))]
    unbounded = [
        Check("warning", "limits", "turns for ever: no position limit", int(j) + 1)
        for j in np.flatnonzero(~np.isfinite(robot.lower) | ~np.isfinite(robot.upper))
    ]
    text = "position, velocity, acceleration and torque are known for every joint"
    return unbounded or [Check("ok", "limits", text)]


def _by_hand(data: Path, profile: Profile, robot: Robot) -> list[Check]:
    """What Tune would have asked about, had it been written there."""
    tuned = Tuned.of(data, profile, robot)
    return [*range_checks(tuned), *gain_checks(tuned)]


def carrying_checks(robot: Robot) -> list[Check]:
    """Whether each joint can hold what gravity asks of it: where the arm rests, and elsewhere."""
    rest = limits_of(robot).rest_pose()[None]
    still = np.zeros_like(rest)
    here = np.abs(inverse_dynamics(robot, robot.parameters, rest, still, still))[0]
    worst = np.maximum(here, burdens(robot, presumed_figures(robot)))
    found = []
    for j in np.flatnonzero(worst > robot.effort):
        always = here[j] > robot.effort[j]
        asked, unit = (here if always else worst)[j], "N" if robot.prismatic[j] else "N·m"
        found.append(Check(
            "error" if always else "warning", "limits",
            f"standing still {'where the arm rests' if always else 'in its worst pose'}, joint "
            f"{j + 1} needs {asked:.4g} {unit} and may give {robot.effort[j]:.4g}; look at the "
            "masses (URDF, tool), the mounting (base, gravity) and limits.torque", int(j) + 1,
        ))  # fmt: skip
    return found


def environment_checks(robot: Robot) -> list[Check]:
    """What plans keep clear of, and whether the arm can stand there at all."""
    around = Surroundings.of(robot)
    text = f"plans keep {1e3 * CLEAR:g} mm from {robot.environment}"
    gaps = around.capsules.clearance(around.limits.rest_pose()[None])[0]
    near = [
        Check("warning", "environment", f"at rest, {around.capsules.name(int(column))} are "
              f"{1e3 * gaps[column]:.0f} mm apart: few plans will be found from there")
        for column in np.flatnonzero(gaps < CLEAR)
    ]  # fmt: skip
    return near or [Check("ok", "environment", text)]


def _disk(data: Path) -> list[Check]:
    free = shutil.disk_usage(data).free / 1e9
    began = time.monotonic()
    with tempfile.TemporaryDirectory(dir=data) as folder:
        write_text(Path(folder) / "probe", "x" * 65536)
    took = time.monotonic() - began
    text = f"{free:.1f} GB free in {data}, {1e3 * took:.0f} ms for a synchronous write"
    if free < SMALL_DISK or took > SLOW_DISK:
        return [Check("warning", "disk", f"{text}; expected {SMALL_DISK:g} GB and a quicker disk")]
    return [Check("ok", "disk", text)]


def _clock() -> list[Check]:
    source = Path("/sys/devices/system/clocksource/clocksource0/current_clocksource")
    name = source.read_text().strip() if source.is_file() else "unknown"
    step = time.get_clock_info("monotonic").resolution
    if time.gmtime().tm_year < SANE_YEAR:
        text = f"this machine believes in {time.strftime('%Y-%m-%d')}: runs get wrong dates"
        return [Check("warning", "clock", f"{text}; set the clock, use NTP")]
    if name not in ("tsc", "arch_sys_counter", "kvm-clock", "unknown"):
        return [Check("warning", "clock", f"clock source {name} is slow to read; expected tsc")]
    return [Check("ok", "clock", f"source {name}, resolution {1e9 * step:.0f} ns")]


def _timing(profile: Profile, seconds: float) -> list[Check]:
    """A bare loop at the profile's rate on this machine, with the priority that we get."""
    with _real_time() as notes:
        late = _late(profile, seconds, lambda: None)
    return [*[Check("warning", "timing", n) for n in notes], _judged("bare loop", late, profile)]


def _drives(profile: Profile, robot: Robot, data: Path, seconds: float) -> list[Check]:
    """Who answers, what they lack, and a loop that reads them, unpowered."""
    daemon = present(data)
    if daemon is not None:
        text = f"the daemon at {daemon.url} holds the bus; look at its robot's notes"
        return [Check("warning", "drives", text)]
    try:
        return _asked(profile, robot, seconds)
    except UserError as error:
        return [Check("error", "drives", str(error))]


def _asked(profile: Profile, robot: Robot, seconds: float) -> list[Check]:
    with contextlib.ExitStack() as stack:
        stack.enter_context(simulated_bus(profile))
        backend = open_backend(profile)
        period = 1.0 / profile.control.rate
        arm = build_arm(profile, robot, backend, Ring.create(robot.n, 4096, period))
        try:
            arm.connect()
        except Refused as refusal:
            return _refused(refusal)
        stack.callback(arm.disconnect)
        found = _who_answers(profile, backend)
        with _real_time():
            late = _late(profile, seconds, arm.cycle)
        if arm.fault is not None:
            return [*found, Check("error", "drives", arm.fault.sentence)]
        return [
            *found,
            *_remarks(device(profile), backend),
            _judged("loop with the drives", late, profile),
        ]


def _refused(refusal: Refused) -> list[Check]:
    """One line for each joint that has a reason."""
    lines = str(refusal).removeprefix("connect: ").splitlines()
    axes: tuple[int, ...] = getattr(refusal.__cause__, "axes", ())
    return [
        Check("error", "drives", line, None if axis is None else axis + 1)
        for line, axis in zip_longest(lines, axes[: len(lines)])
    ]


def _who_answers(profile: Profile, backend: Backend) -> list[Check]:
    """Identity of every drive; what it lacks, or that it lacks nothing."""
    reports = getattr(backend, "reports", ())
    found = [Check("ok", "drives", report.identity) for report in reports]
    risks = [
        (f"joint {k + 1}: ", not_accepted(drive, report.risks))
        for k, (drive, report) in enumerate(zip(profile.drives or [], reports, strict=False))
    ]
    errors = [joint + risk for joint, open_risks in risks for risk in open_risks]
    found += [Check("error", "safety", error) for error in errors]
    found += [
        Check("warning", "safety", warning)
        for warning in backend.warnings
        if not any(error.startswith(warning) for error in errors)
    ]
    for report in reports:
        if not report.lacks:
            text = f"node {report.node}: has every safety object, and took every setting"
            found.append(Check("ok", "safety", text))
    return found


def _remarks(words: Device, backend: Backend) -> list[Check]:
    """What drives say beside their states."""
    statuses: list[int] = getattr(backend, "statuses", list)()
    return [
        Check("warning", "drives", f"joint {k + 1}: {remark}", k + 1)
        for k, word in enumerate(statuses)
        for remark in words.remarks(word)
    ]


def _late(profile: Profile, seconds: float, cycle: Callable[[], None]) -> tuple[np.ndarray, int]:
    """s by which each cycle began late, and how many were not finished in time."""
    clock, late = Clock(1.0 / profile.control.rate), []
    for _ in range(max(10, int(seconds * profile.control.rate))):
        clock.wait(paced=True)
        cycle()
        clock.done()
        late.append(clock.late)
    return np.array(late), clock.missed


def _judged(what: str, found: tuple[np.ndarray, int], profile: Profile) -> Check:
    late, missed = found
    usual, rare = np.quantile(late, [0.5, 0.99])
    text = (
        f"{what} at {profile.control.rate:g} Hz: {1e6 * usual:.0f} µs late as a rule, "
        f"{1e6 * rare:.0f} µs once in a hundred cycles, {missed} of {len(late)} not done in time"
    )
    if rare > LATE / profile.control.rate or missed > len(late) // 200:
        return Check("warning", "timing", f"{text}; {rate_to_write(profile, 2 * float(rare))}")
    return Check("ok", "timing", text)


@contextlib.contextmanager
def _real_time() -> Iterator[list[str]]:
    """Priority, one processor and quiet garbage collection for a while."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    allowed = os.sched_getaffinity(0)
    notes = take_priority(PRIORITY)
    stay_on_one()
    gc.disable()
    try:
        yield notes
    finally:
        gc.enable()
        policy, parameters = before  # the flag is for root alone to take away
        os.sched_setaffinity(0, allowed)
        os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, parameters)
