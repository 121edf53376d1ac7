"""Drives on a bus and a plant behind them, one period per SYNC."""

from __future__ import annotations

import logging
import time

import numpy as np

from backends.eds import eds_path
from backends.frames import frames
from backends.limits import axis_limits
from backends.ports import Port
from backends.scaling import nameplate
from backends.virtual.drives.drive import TEMPERATURE, VirtualDrive
from backends.virtual.drives.mechanics import Actuation, Mechanics
from backends.virtual.drives.node import BOOTING
from backends.virtual.drives.object_dictionary import LiveDictionary
from backends.virtual.load_plant import load_plant
from pa10d.common.errors import UserError
from pa10d.profile import Profile, Simulation

FUNCTION, COMMAND = 0x780, 0x200  # of identifiers: RPDO 1 is the command
BOOT_TIME = 0.05  # s, in real time; in simulated time nothing passes before the first SYNC
MOST_PERIODS = 50  # caught up at once after a stall
TEMPERATURE_EVERY = 0.1  # s

log = logging.getLogger("pa10d.virtual")


class VirtualArm:
    """Drives and plant of one profile. ``handle`` takes packets, ``tick`` real time."""

    def __init__(self, profile: Profile, port: Port) -> None:
        simulation = profile.simulation or Simulation()
        if not profile.drives:
            raise UserError(f"{profile.path}: drives: missing, expected one entry per joint")
        self.period = 1.0 / profile.control.rate
        self.realtime = simulation.clock == "real"
        self.plant = load_plant(profile, len(profile.drives))
        self.port, self._outbox = port, list[bytes]()
        self.drives = [self._drive(profile, k) for k in range(len(profile.drives))]
        strength = np.array([drive.scaling.rated for drive in self.drives])
        slides = np.array([limits.slides for limits in axis_limits(profile)])
        count = np.array([1.0 / drive.scaling.counts_per_radian for drive in self.drives])
        self.mechanics = Mechanics(self.plant, strength, slides, count)
        for drive, angle in zip(self.drives, self.mechanics.q.tolist(), strict=True):
            drive.stands(angle)
        self._all = np.ones(len(self.drives), bool)
        self._powered = ~self._all
        self._routes: dict[int, list[VirtualDrive]] = {}
        self._synced_by: set[int] = set()  # identifiers of the SYNCs that ended this period
        self._find_routes()
        for drive in self.drives:
            drive.node.on_routes = self._find_routes
        self._time = time.monotonic()  # up to which the plant was advanced
        self._until_temperature = 0.0
        self._read_temperature(0.0)  # a master may ask before time goes on
        self._losing = False  # nobody took the last frames
        self.flush()

    def handle(self, packet: bytes) -> None:
        """Take in frames and answer them."""
        for can_id, data in frames(packet):
            if can_id in self._sync_ids:
                self._synced(can_id, data)
                continue
            for drive in self._routes.get(can_id, ()):
                drive.node.receive(can_id, data)
            if can_id & FUNCTION == COMMAND:  # whoever sends it no longer waits for answers
                self._release_held()
        self.flush()

    def tick(self) -> None:
        """Real time without SYNC: time goes on for drives and plant."""
        for _ in range(MOST_PERIODS):
            if not self.realtime or self.wait() > 0:
                return
            self._time += self.period
            self._cycle(synced_by=None)
            self.flush()
        self._time = time.monotonic()  # too slow for real time: the rest is skipped

    @property
    def booted(self) -> bool:
        """Whether every drive has sent its boot-up message."""
        return all(drive.node.state != BOOTING for drive in self.drives)

    def wait(self) -> float:
        """Seconds until ``tick`` has something to do."""
        return self._time + 1.5 * self.period - time.monotonic() if self.realtime else 0.5

    def flush(self) -> None:
        """Send what waits. A full queue loses it, as in a drive; who listens misses it."""
        packet = b"".join(self._outbox)
        self._outbox.clear()
        if not packet:
            return
        try:
            self.port.send(packet)
            self._losing = False
        except OSError as error:
            if not self._losing:  # said once, not with every cycle
                log.warning("frames of the drives are lost: %s", error)
            self._losing = True

    def _synced(self, can_id: int, data: bytes) -> None:
        """A period ends with it; drives with a SYNC of their own (0x1005) share the period."""
        self._release_held()
        periods = int(not self._synced_by or can_id in self._synced_by)
        if periods:
            self._synced_by.clear()
        self._synced_by.add(can_id)
        if self.realtime:
            now = time.monotonic()
            periods = min(int((now - self._time) / self.period + 0.5), MOST_PERIODS)
            self._time = now if periods else self._time
        for _ in range(periods - 1):
            self._cycle(synced_by=None)
        self._cycle(can_id, data, advance=periods > 0)

    def _cycle(self, synced_by: int | None, sync: bytes = b"", advance: bool = True) -> None:
        dt = self.period if advance else 0.0
        q, torque = self.mechanics.measure(self._powered, dt)
        velocity = self.mechanics.velocity.tolist()
        self._read_temperature(dt)
        seen = zip(self.drives, q.tolist(), velocity, torque.tolist(), strict=True)
        for drive, angle, speed, effort in seen:
            synced = drive.node.sync_id == synced_by and drive.node.obeys(sync)
            drive.update(dt, angle, speed, effort, synced)
        if synced_by is not None:
            self.flush()  # the answer first: the plant may take its time
        if not advance:
            return
        if all(drive.follows for drive in self.drives):
            self._powered = self._all
            torque = np.array([drive.torque for drive in self.drives])
            self.mechanics.follow(torque, self.period)
        else:
            act = self._actuation()
            self._powered = act.powered
            self.mechanics.advance(act, self.period)

    def _actuation(self) -> Actuation:
        drives = self.drives
        return Actuation(
            torque=np.array([d.torque for d in drives]),
            powered=np.array([d.machine.powered for d in drives]),
            stopping=np.array([d.machine.stopping for d in drives]),
            braked=np.array([d.brake_closed for d in drives]),
            deceleration=np.array([d.deceleration for d in drives]),
            limit=np.array([d.torque_limit for d in drives]),
            racing=np.array([d.racing for d in drives]),
            fastest=np.array([d.fastest for d in drives]),
        )

    def _read_temperature(self, dt: float) -> None:
        self._until_temperature -= dt
        if self._until_temperature > 0:
            return
        self._until_temperature = TEMPERATURE_EVERY
        if not hasattr(self.plant, "temperature"):
            for drive in self.drives:  # nobody measures: the drive has nothing to tell
                drive.values.pop(TEMPERATURE, None)
            return
        for drive, degrees in zip(self.drives, self.plant.temperature(), strict=True):
            drive.values[TEMPERATURE] = max(-32768, min(32767, round(10 * float(degrees))))

    def _release_held(self) -> None:
        for drive in self.drives:
            if drive.node.held:
                self._outbox.extend(drive.node.held)
                drive.node.held.clear()

    def _find_routes(self) -> None:
        routes: dict[int, list[VirtualDrive]] = {}
        for drive in self.drives:
            for can_id in drive.node.listens_to():
                routes.setdefault(can_id, []).append(drive)
        self._routes = routes
        self._sync_ids = {drive.node.sync_id for drive in self.drives}

    def _drive(self, profile: Profile, axis: int) -> VirtualDrive:
        assert profile.drives is not None
        settings = profile.drives[axis]
        return VirtualDrive(
            number=settings.node,
            dictionary=LiveDictionary(eds_path(profile, axis), settings.node),
            scaling=nameplate(settings),
            rated_torque=settings.rated_torque,
            gear_ratio=settings.gear_ratio,
            send=self._outbox.append,
            boot_time=BOOT_TIME if self.realtime else 0.0,
            brake=settings.brake,
        )
