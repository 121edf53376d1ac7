"""The arm behind real or virtual CiA 402 drives on a CAN bus."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection

import numpy as np
from numpy.typing import NDArray

from backends import vendors
from backends.bus_budget import BusBudget, require_fit
from backends.bus_lock import BusLock
from backends.by_hand import pacer
from backends.canopen_cia402 import error_memory, other_masters, sequence
from backends.canopen_cia402.brakes import OUTPUTS, PHYSICAL, Brakes
from backends.canopen_cia402.bring_up import BootWatch, bring_up, let_go
from backends.canopen_cia402.bus_cycle import MASTER, BusCycle, Pace, bus_fault
from backends.canopen_cia402.configure import DriveReport, Wish
from backends.canopen_cia402.exchange import Counters, Exchange
from backends.canopen_cia402.lifeline import not_accepted
from backends.canopen_cia402.network import PortNetwork
from backends.canopen_cia402.other_masters import NMT
from backends.canopen_cia402.poll import Poll, every
from backends.canopen_cia402.reaction import REACTION, Reactions
from backends.canopen_cia402.scales import Scales
from backends.canopen_cia402.watch import NEVER_FOLLOWED, SILENCE, Watch
from backends.canopen_cia402.who_answers import NEAR, require_own
from backends.cia402 import Control, DriveState, FaultReaction, state_of
from backends.eds import eds_path, load_eds
from backends.error_history import DriveErrors
from backends.faults import fault, refusal
from backends.frames import frame
from backends.ports import Port, drain, open_port
from backends.protocol import Array, BackendFault, Feedback
from pa10d.common.errors import UserError
from pa10d.profile import Profile

STOP_NODE = 2  # NMT
RAMPS = (DriveState.QUICK_STOP, DriveState.REACTING)
BRAKED = (DriveState.DISABLED, DriveState.READY, DriveState.SWITCHED_ON, DriveState.FAULT)
TRIAL_CYCLES = 3  # at the end of open
KEEPS_REACTION = (
    f"Fault reaction option code (0x{REACTION:04X}) was not taken beside the cycle: its drive "
    "reacts to a fault as before"
)
LISTEN, LISTEN_TO_SIMULATION = 0.25, 0.05  # s, before the first frame of our own


class CanopenBackend:
    """Backend for CiA 402 drives in cyclic synchronous torque mode; see backends/protocol.py."""

    _sequence: sequence.Sequence | None  # what was begun and is not carried out yet

    def __init__(self, profile: Profile, port: Callable[[], Port] | None = None) -> None:
        """``port`` opens the bus; default: as the profile's ``can`` says."""
        if not profile.drives:
            raise UserError(f"{profile.path}: drives: missing, expected one entry per joint")
        self.budget: BusBudget = require_fit(profile)
        self.profile, self.drives = profile, profile.drives
        self.n = len(self.drives)
        self.period = 1.0 / profile.control.rate
        simulation = profile.simulation
        self.realtime = simulation is None or simulation.clock == "real"
        self.reports: list[DriveReport] = []
        self.scales = Scales(profile)
        self._open_port = port or (lambda: open_port(profile.can, str(profile.path)))
        self._port: Port | None = None
        self._lock = BusLock(profile.can)
        self._cycle: BusCycle | None = None
        self._heartbeat = min(drive.heartbeat_ms for drive in self.drives) / 1000.0
        self._keeps: set[int] = set()  # axes whose drives take no other reaction to a fault
        self._reactions = Reactions(self._set_reaction, self._keeps.add)
        n = self.n
        self._feedback = Feedback(
            0.0, np.zeros(n), np.zeros(n), np.zeros(n, np.int64), np.zeros(n, np.int64)
        )
        self._forget()

    @property
    def warnings(self) -> list[str]:
        """What each drive lacks, known after ``open``."""
        lacks = [f"joint {k + 1}: {lack}" for k, r in enumerate(self.reports) for lack in r.lacks]
        lacks += [f"joint {k + 1}: {KEEPS_REACTION}" for k in sorted(self._keeps)]
        return lacks + [f"joint {k + 1}: {NEVER_FOLLOWED}" for k in self._watch.never_followed]

    @property
    def counters(self) -> Counters:
        """Late, repeated and missing TPDOs since ``open``."""
        return self._exchange.counters

    # --- life ---

    def open(self) -> None:
        self._forget()
        try:
            self._attach()
            reports = self._configure(list(range(self.n)))
            self.reports = [reports[axis] for axis in range(self.n)]
            self._start_cycling()
        except BaseException:
            self._drop_port()
            raise

    @property
    def switching(self) -> bool:
        return self._sequence is not None

    def trust(self, axes: Collection[int]) -> None:
        self._reactions.trust(axes)

    def begin_enable(self) -> None:
        self._begin_enabling(sequence.Enable(self))

    def begin_enable_one_by_one(self) -> None:
        braked = [drive.brake for drive in self.drives]
        self._begin_enabling(sequence.EnableOneByOne(self, braked))

    @property
    def out_of_brakes(self) -> tuple[int, ...] | None:
        under_way = self._sequence
        return under_way.out if isinstance(under_way, sequence.EnableOneByOne) else None

    def try_again(self) -> None:
        if isinstance(self._sequence, sequence.EnableOneByOne):
            self._sequence.again()

    def read(self) -> Feedback:
        self._connected().beating = True  # from now on the drives watch us
        feedback = self.cycle()
        under_way = self._sequence
        if under_way is not None:
            self._continue(under_way, feedback)
        if under_way is not None and not under_way.judged:
            return feedback
        if (new := self._watch.check(self._exchange, self._powered)) is not None:
            raise new
        return feedback

    def write(self, torque: Array) -> None:
        self._per_mille = self.scales.per_mille(torque)
        self._send_words()

    def quick_stop(self) -> None:
        self._powered, self._sequence = False, None
        self.command([Control.QUICK_STOP] * self.n)

    def cut_power(self, axis: int) -> None:
        self._powered, self._sequence = False, None
        self._cut.add(axis)
        cut, stop = Control.DISABLE_VOLTAGE, Control.QUICK_STOP
        self.command([cut if k in self._cut else stop for k in range(self.n)])

    def begin_disable(self) -> None:
        self._begin(sequence.Disable(self))

    def begin_relieve(self) -> None:
        self._begin(sequence.Relieve(self))

    def begin_reset(self) -> None:
        self._powered, self._sequence = False, None
        self._cut.clear()
        kinds = {axis: found.kind for axis, found in self._watch.faults.items()}
        if self._cycle is None or None in kinds:
            self.close()
            self.open()
            kinds = {}
        lost = [k for k in kinds if k is not None and kinds[k] not in sequence.STILL_CONFIGURED]
        if lost:
            for axis, report in self._configure(lost).items():
                self.reports[axis] = report
                self._exchange.expect(axis)
            self._know_life_signs()
        self._watch.clear()
        self._begin(sequence.Acknowledge(self))

    def close(self) -> None:
        if self._port is None:
            return
        try:
            if self._cycle and any(word & 0x6F in (0x27, 0x07) for word in self.statuses()):
                self._brake_at_last()
            if self._cycle:
                self._brakes.set_all()
                self._port.send(self._poll.settings())
            with self._network.listening():
                let_go(self._network, self._nodes)
        except (OSError, BackendFault):
            pass  # a bus that is gone needs no farewell; the drives stop by themselves
        finally:
            self._drop_port()

    # --- what the drives remember ---

    def read_errors(self) -> list[DriveErrors]:
        return self._ask_memories(error_memory.remembered)

    def clear_errors(self) -> list[DriveErrors]:
        return self._ask_memories(error_memory.emptied)

    # --- what the sequences use ---

    def cycle(self) -> Feedback:
        """SYNC and the answers to it, without judging them."""
        cycle, feedback = self._connected(), self._feedback
        cycle.run()
        feedback.time = cycle.sent_at
        self._reactions.insist(cycle.sent_at)
        self.scales.fill(self._exchange, feedback)
        return feedback

    def set_words(self, words: list[Control]) -> None:
        """Controlwords of all axes, sent with the next torques."""
        self._words = [int(word) for word in words]

    def command(self, words: list[Control]) -> None:
        """Controlwords of all axes, from the next SYNC on, with the torques as they are."""
        self.set_words(words)
        self._send_words()

    def statuses(self) -> list[int]:
        """The last statusword of every axis."""
        return [seen.status for seen in self._exchange.axes]

    @property
    def ramping(self) -> NDArray[np.bool_]:
        return np.array([state_of(word) in RAMPS for word in self.statuses()])

    @property
    def in_brakes(self) -> NDArray[np.bool_]:
        """By its drive, which opens its brake as it is enabled; so do we, where it is ours."""
        states = [state_of(word) for word in self.statuses()]
        braked = zip(self.drives, states, strict=True)
        return np.array([drive.brake and state in BRAKED for drive, state in braked])

    def silent(self, axis: int) -> bool:
        """Whether the axis has not been heard for too long to be commanded."""
        age = self._exchange.cycle - self._exchange.axes[axis].cycle
        return age >= self.profile.safety.stale_cycles

    def stop_node(self, axis: int) -> None:
        """NMT: its drive takes no more commands, and ends its torque by its own reaction."""
        self._connected().send(frame(NMT, bytes([STOP_NODE, self.drives[axis].node])))

    def latched(self) -> list[BackendFault]:
        """Every fault since the last reset, the first one first."""
        return list(self._watch.faults.values())

    # --- inside ---

    def _begin_enabling(self, what: sequence.Sequence) -> None:
        if latched := self.latched():
            raise latched[0]  # only reset forgets a fault
        if open_risks := self._open_risks():
            raise refusal("unaccepted_risk", open_risks)
        self._cut.clear()
        self._begin(what)

    def _begin(self, what: sequence.Sequence) -> None:
        self._powered, self._sequence = False, what

    def _continue(self, under_way: sequence.Sequence, feedback: Feedback) -> None:
        """One step on; a sequence that fails is over."""
        self._sequence = None
        if under_way.step(feedback):
            self._sequence = under_way
        elif isinstance(under_way, sequence.Enable):
            self._powered = True
        elif isinstance(under_way, sequence.Acknowledge):
            self._watch.clear()

    def _ask_memories(self, look: error_memory.Look) -> list[DriveErrors]:
        """By SDO, beside a cycle that waits meanwhile; over a bus of its own where none is open."""
        visiting = self._port is None
        try:
            if visiting:
                self._attach()
            alive = self._cycle.keep_alive if self._cycle else lambda: None
            with self._network.listening(also=self._overheard, idle=alive):
                found = error_memory.of_each(self._nodes, look)
        except OSError as error:
            raise self._watch.latch(bus_fault(error)) from error
        finally:
            if visiting:
                self._drop_port()
        self._watch.start([], self._now())
        return found

    def _brake_at_last(self) -> None:
        """Nobody commands any more: brakes on, with the torques as they are until those hold."""
        disable, pace = sequence.Disable(self), pacer(self)
        while disable.step(self.cycle()):
            self.command([Control(word) for word in self._words])
            pace()

    def _forget(self) -> None:
        self._watch = Watch(
            nodes=[drive.node for drive in self.drives],
            heartbeat=[drive.heartbeat_ms / 1000.0 for drive in self.drives],
            most_counts=self.scales.counts_per_period(self.period),
            period=self.period,
            stale_cycles=self.profile.safety.stale_cycles,
        )
        self._words, self._per_mille = [int(Control.DISABLE_VOLTAGE)] * self.n, [0] * self.n
        self._powered = False
        self._cut: set[int] = set()  # axes that are left to their brakes
        self._sequence = None

    def _connected(self) -> BusCycle:
        if self._cycle is None:
            raise fault("interface_down", "the bus is not open")
        return self._cycle

    def _attach(self) -> None:
        """The bus, as its only master, and the nodes on it; nothing is sent."""
        self._lock.take()
        self._port = self._open_port()
        self._listen(self._port)
        self._network = PortNetwork(self._port)
        self._nodes = {
            axis: self._network.add_drive(
                drive.node, load_eds(eds_path(self.profile, axis), drive.node)
            )
            for axis, drive in enumerate(self.drives)
        }

    def _drop_port(self) -> None:
        if self._port is not None:
            self._port.close()
        self._port = self._cycle = None
        self._lock.release()

    def _listen(self, port: Port) -> None:
        nodes = [drive.node for drive in self.drives]
        try:
            other_masters.listen(port, nodes, LISTEN if self.realtime else LISTEN_TO_SIMULATION)
        except OSError as error:
            raise self._watch.latch(bus_fault(error)) from error

    def _configure(self, axes: list[int]) -> dict[int, DriveReport]:
        assert self._port is not None
        boot = BootWatch()
        chosen = {axis: self._nodes[axis] for axis in axes}
        wishes = {axis: self._wish(axis) for axis in axes}
        alive = self._cycle.keep_alive if self._cycle else lambda: None
        try:
            for axis in axes:
                self._reactions.set_up(axis)
                self._keeps.discard(axis)
            drain(self._port)
            with self._network.listening(also=boot.frame, idle=alive):
                reports = bring_up(self._network, chosen, wishes, boot)
        except OSError as error:
            raise self._watch.latch(bus_fault(error)) from error
        self._watch.start(axes, self._now())
        return reports

    def _now(self) -> float:
        """s on the clock of the watch."""
        simulated = self._cycle.sent_at if self._cycle else 0.0
        return time.monotonic() if self.realtime else simulated

    def _wish(self, axis: int) -> Wish:
        return Wish(
            drive=self.drives[axis],
            scaling=self.scales.axes[axis],
            limits=self.scales.limits[axis],
            period=self.period,
            bitrate=self.profile.can.bitrate,
            master=MASTER,
            silence_ms=round(1000 * SILENCE * self._heartbeat),
            trusted=axis in self._reactions.trusted,
        )

    def _start_cycling(self) -> None:
        assert self._port is not None
        nodes = [drive.node for drive in self.drives]
        known = [vendors.TEMPERATURE_OBJECT.get((r.vendor, r.product)) for r in self.reports]
        shown = [report.shows_mode for report in self.reports]
        self._poll = Poll(
            nodes,
            known,
            shown,
            self._watch.mode,
            self._refused,
            self._watch.altered,
            self._taken,
            every(self.profile.can.sdo_reserve, self.profile.can.bitrate),
        )
        self._brakes = Brakes(
            [report.brake for report in self.reports],
            [limits.acceleration for limits in self.scales.limits],
            self._set_output,
            self._watch.output_unanswered,
        )
        self._feedback.temperature = self._poll.values if self._poll.measured else None
        self._exchange = Exchange(
            nodes,
            [r.feedback for r in self.reports],
            [r.command for r in self.reports],
            self._other,
            self.profile.safety.stale_cycles,
        )
        pace = Pace(self.realtime, self.period, self._heartbeat)
        self._cycle = BusCycle(self._port, self._exchange, self._watch, self._poll, pace)
        self._know_life_signs()
        sequence.prove(self, TRIAL_CYCLES, self.profile.safety.stale_cycles, pacer(self))
        told = [report.position for report in self.reports]
        near = [NEAR * axis.counts_per_radian for axis in self.scales.axes]
        require_own(nodes, told, self._exchange.position.tolist(), near)
        self._watch.clear()
        for axis, report in enumerate(self.reports):
            self._watch.remember(axis, report.error)

    def _know_life_signs(self) -> None:
        """Who is asked, and who tells by itself, that it lives."""
        self._connected().guarded = [report.node for report in self.reports if report.guarded]
        for axis, report in enumerate(self.reports):
            self._watch.listen_for(axis, report.heard)
            self._poll.fix(axis, report.fixed)

    def _open_risks(self) -> dict[int, str]:
        """What keeps a real arm from being powered, by axis; a simulated one hurts nobody."""
        if self.profile.simulation is not None:
            return {}
        pairs = zip(self.drives, self.reports, strict=True)
        found = {axis: not_accepted(drive, r.risks) for axis, (drive, r) in enumerate(pairs)}
        return {axis: "; ".join(risks) for axis, risks in found.items() if risks}

    def _set_output(self, axis: int, value: int) -> None:
        self._poll.set(axis, OUTPUTS, PHYSICAL, value)

    def _set_reaction(self, axis: int, reaction: FaultReaction) -> None:
        if self.reports[axis].has_reaction:
            self._poll.set(axis, REACTION, 0, reaction, size=2)
        else:
            self._reactions.refused(axis)

    def _taken(self, axis: int, index: int) -> None:
        if index == OUTPUTS:
            self._brakes.taken(axis)
        elif index == REACTION:
            self._reactions.taken(axis)

    def _refused(self, axis: int, index: int, code: int) -> None:
        if index != REACTION:
            self._watch.refused(axis, index, code)
            return
        self._reactions.refused(axis)
        self._keeps.add(axis)

    def _send_words(self) -> None:
        """Controlwords and torques, as far as the brakes let them pass."""
        feedback = self._feedback
        words = self._brakes.let_pass(
            self._words, self.statuses(), feedback.time, feedback.q, self._cut
        )
        self._connected().send(self._exchange.pack(words, self._per_mille))

    def _other(self, can_id: int, data: bytes) -> None:
        if 0x580 < can_id <= 0x5FF:
            self._poll.frame(can_id, data)
        else:
            self._watch.frame(can_id, data)

    def _overheard(self, can_id: int, data: bytes) -> None:
        """While drives are asked: EMCY and boot-ups count, answers are somebody else's."""
        if not 0x580 < can_id <= 0x5FF:
            self._watch.frame(can_id, data)
