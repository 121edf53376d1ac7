"""A CANopen node: NMT, boot-up, heartbeats, SDO, PDO (CiA 301). What it controls is elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from backends.frames import REMOTE, frame
from backends.virtual.drives.communication_rules import CAN_ID, check_write
from backends.virtual.drives.errors import (
    LATE_PDO,
    LONG_PDO,
    LOST_HEARTBEAT,
    SHORT_PDO,
    SYNC_LENGTH,
    ErrorMemory,
)
from backends.virtual.drives.heartbeats import Consumer, Guard, Producer
from backends.virtual.drives.injection import Injection, Injector
from backends.virtual.drives.object_dictionary import LiveDictionary, Value, key_of
from backends.virtual.drives.pdo import (
    INVALID,
    MAPPINGS,
    RPDO,
    TPDO,
    ReceivePdo,
    TransmitPdo,
    declared,
)
from backends.virtual.drives.sdo_server import SdoServer

BOOTING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
START, STOP, ENTER_PRE_OPERATIONAL, RESET, RESET_COMMUNICATION = 1, 2, 128, 129, 130
RESETS = (RESET, RESET_COMMUNICATION)
STATE_AFTER = {START: OPERATIONAL, STOP: STOPPED, ENTER_PRE_OPERATIONAL: PRE_OPERATIONAL}
HEARTBEAT_TIME, HISTORY = key_of(0x1017), key_of(0x1003)
AFTER_COMMUNICATION_ERROR = {0: PRE_OPERATIONAL, 2: STOPPED}  # 0x1029:1; else it goes on


class Application(Protocol):
    """What sits behind the node and is told what happens on the bus."""

    @property
    def in_fault(self) -> bool:
        """Whether an error keeps it from working until it is acknowledged."""
        ...

    def received(self, keys: list[int]) -> None:
        """An RPDO changed these values of the dictionary."""

    def written(self, key: int, value: Value) -> None:
        """An SDO changed the dictionary."""

    def may_write(self, key: int, value: Value) -> None:
        """Raise SdoAbort to refuse a value."""

    def connection_lost(self) -> None:
        """The node can no longer be commanded."""

    def restarted(self, completely: bool) -> None:
        """Dictionary values are as after power-on (``completely``) or of 0x1000 … 0x1FFF."""


class CanopenNode:
    """Frames in by ``receive`` and ``sync``, time by ``advance``, frames out by ``send``."""

    def __init__(
        self,
        node: int,
        dictionary: LiveDictionary,
        application: Application,
        send: Callable[[bytes], None],
        boot_time: float,
    ) -> None:
        self.id, self.dictionary = node, dictionary
        self.state = BOOTING
        self.injector = Injector()
        self.errors = ErrorMemory(dictionary, self._emergency)
        self.held: list[bytes] = []  # TPDOs that come late on purpose
        self.since_sync = 0.0  # s
        self.on_routes: Callable[[], None] = lambda: None
        self._application, self._send, self._boot_time = application, send, boot_time
        self._sdo = SdoServer(dictionary)
        self._producer, self._consumer, self._guard = Producer(), Consumer(), Guard()
        self._receive: dict[int, ReceivePdo] = {}  # by communication record, as the next one
        self._transmit: dict[int, TransmitPdo] = {}
        self._rpdos: dict[int, list[ReceivePdo]] = {}  # those that exist, by identifier
        self._tpdos: list[TransmitPdo] = []
        self._awaited: list[ReceivePdo] = []  # those with a deadline
        self.sync_id = 0x80
        self._sync_size = 0
        self._sync_count: int | None = None
        self._wrong_sync = False  # told once
        self._boot_left = boot_time
        dictionary.may_write, dictionary.on_write = self._may_write, self._written

    def listens_to(self) -> list[int]:
        """Identifiers of the frames this node wants, SYNC aside."""
        heartbeats = [0x700 + node for node in self._consumer.nodes]
        asked = [REMOTE | pdo.cob_id for pdo in self._tpdos] + [REMOTE | (0x700 + self.id)]
        return [0, 0x600 + self.id, *self._rpdos, *heartbeats, *asked]

    def receive(self, can_id: int, data: bytes) -> None:
        """A frame arrived."""
        if self.injector.silent:
            return
        if can_id == 0:
            self._command(data)
        elif self.state == BOOTING:
            return
        elif can_id & REMOTE:
            self._asked(can_id & CAN_ID)
        elif can_id == 0x600 + self.id:
            if self.state != STOPPED and (answer := self._sdo.answer(data)) is not None:
                self._say(0x580, answer)
        elif (pdos := self._rpdos.get(can_id)) is not None:
            if self.state == OPERATIONAL:
                for pdo in pdos:
                    self._take(pdo, data)
        elif can_id > 0x700:
            self._consumer.heard(can_id - 0x700)

    def obeys(self, sync: bytes) -> bool:
        """Whether this SYNC is one for us: it has a counter where 0x1019 says so, else nothing."""
        if len(sync) == self._sync_size:
            self._sync_count = sync[0] if sync else None
            if self._wrong_sync:
                self._wrong_sync = False
                self.errors.over(SYNC_LENGTH)
            return True
        if not self._wrong_sync and self.state in (PRE_OPERATIONAL, OPERATIONAL):
            self._wrong_sync = True
            self.errors.emergency(SYNC_LENGTH)
        return False

    def sync(self) -> None:
        """SYNC: what the synchronous RPDOs brought takes effect."""
        if self.injector.silent or self.state != OPERATIONAL:
            return
        self.since_sync = 0.0
        for pdo in self._receive.values():
            if pdo.waiting is not None:
                data, pdo.waiting = pdo.waiting, None
                pdo.apply(data)
                self._application.received(pdo.keys)

    def advance(self, dt: float) -> None:
        """Let ``dt`` s pass: boot, miss heartbeats."""
        if self.state == BOOTING:
            self._boot_left -= dt
            if self._boot_left <= 1e-9:
                self.boot()
            return
        self.since_sync += dt
        if self.state == OPERATIONAL and any([pdo.overdue(dt) for pdo in self._awaited]):
            self.errors.emergency(LATE_PDO)
        if self._consumer.lost(dt) is not None or self._guard.lost(dt):
            self.communication_error(LOST_HEARTBEAT)

    def answer(self, dt: float, synced: bool) -> None:
        """Send what is due after ``dt`` s: TPDOs from the present values, the heartbeat."""
        if self.injector.silent or self.state == BOOTING:
            return
        if self.state == OPERATIONAL:
            for pdo in self._tpdos:
                if (data := pdo.due(dt, synced, self._sync_count)) is not None:
                    self._offer(pdo, data)
        period = self.dictionary.values.get(HEARTBEAT_TIME, 0)
        if self._producer.due(dt, int(period)) and not self.injector.heartbeat_mute:
            self._say(0x700, bytes([self.state]))

    def communication_error(self, code: int) -> None:
        """Tell, let the application react, and leave OPERATIONAL as 0x1029 says."""
        self.errors.emergency(code)
        self._application.connection_lost()
        if self.state == OPERATIONAL:
            after = AFTER_COMMUNICATION_ERROR.get(self.dictionary.number(0x1029, 1), self.state)
            self._enter(after)

    def restart(self, completely: bool) -> None:
        """NMT reset of the node, or of its communication only."""
        self.dictionary.restore(communication_only=not completely)
        if completely or not self._application.in_fault:
            self.errors.restarted(completely)
        self.errors.publish()
        self._application.restarted(completely)
        self._consumer, self._guard = Consumer(), Guard()
        self._wrong_sync = False
        self.state, self._boot_left = BOOTING, self._boot_time
        if self._boot_time <= 0:
            self.boot()

    def boot(self) -> None:
        """End of start-up: the boot-up message, then PRE-OPERATIONAL."""
        self.state = PRE_OPERATIONAL
        self.configure()
        self._say(0x700, b"\0")

    def configure(self) -> None:
        """Take over the communication settings from the dictionary."""
        dictionary = self.dictionary
        self._receive = {k: ReceivePdo(dictionary, k) for k in declared(dictionary, RPDO)}
        self._transmit = {k: TransmitPdo(dictionary, k) for k in declared(dictionary, TPDO)}
        self._sort_pdos()
        self._watch_others()

    def _configure_pdo(self, index: int) -> None:
        """One record was written: the other PDOs go on counting and waiting where they are."""
        record = index & ~MAPPINGS
        if record in self._receive:
            self._receive[record] = ReceivePdo(self.dictionary, record)
        elif record in self._transmit:
            self._transmit[record] = TransmitPdo(self.dictionary, record)
        self._sort_pdos()
        self.on_routes()

    def _sort_pdos(self) -> None:
        self._rpdos = {}
        for pdo in self._receive.values():
            if pdo.enabled:
                self._rpdos.setdefault(pdo.cob_id, []).append(pdo)
        self._tpdos = [pdo for pdo in self._transmit.values() if pdo.enabled]
        self._awaited = [pdo for pdo in self._receive.values() if pdo.enabled and pdo.awaited]
        self._see_who_is_late()

    def _see_who_is_late(self) -> None:
        if not any(pdo.late for pdo in self._awaited):
            self.errors.over(LATE_PDO)

    def _watch_others(self) -> None:
        self._consumer.configure(self.dictionary)
        self._guard.configure(self.dictionary)
        self.sync_id = self.dictionary.number(0x1005, default=0x80) & CAN_ID or 0x80
        self._sync_size = 1 if self.dictionary.number(0x1019) else 0
        self.on_routes()

    def _say(self, function: int, data: bytes) -> None:
        if not self.injector.silent:
            self._send(frame(function + self.id, data))

    def _emergency(self, data: bytes) -> None:
        cob_id = self.dictionary.number(0x1014) or 0x80 + self.id
        speaks = self.state not in (BOOTING, STOPPED) and not self.injector.silent
        if speaks and not cob_id & INVALID:
            self._send(frame(cob_id & CAN_ID, data))

    def _enter(self, state: int) -> None:
        if state == OPERATIONAL and self.state != OPERATIONAL:
            for pdo in self._tpdos:
                pdo.restart()
        if state != OPERATIONAL:
            for received in self._receive.values():
                received.forget()
            self._see_who_is_late()
        self.state = state

    def _asked(self, can_id: int) -> None:
        """A remote frame: node guarding, or somebody wants a TPDO now."""
        if can_id == 0x700 + self.id:
            if not self.dictionary.values.get(HEARTBEAT_TIME, 0):  # not both at once
                self._say(0x700, self._guard.asked(self.state))
        elif self.state == OPERATIONAL:
            for pdo in self._tpdos:
                if pdo.cob_id == can_id and (data := pdo.asked()) is not None:
                    self._send(frame(can_id, data))

    def _command(self, data: bytes) -> None:
        known = len(data) == 2 and (data[0] in RESETS or data[0] in STATE_AFTER)
        if not known or data[1] not in (0, self.id):
            return
        if self.state == OPERATIONAL and data[0] != START:
            self._application.connection_lost()
        if data[0] in RESETS:
            self.restart(completely=data[0] == RESET)
        elif self.state != BOOTING:
            self._enter(STATE_AFTER[data[0]])

    def _take(self, pdo: ReceivePdo, data: bytes) -> None:
        """Too short is not processed, of what is too long the first part is; both are told."""
        if len(data) != pdo.size:
            if not pdo.wrong_length:
                self.errors.emergency(SHORT_PDO if len(data) < pdo.size else LONG_PDO)
            pdo.wrong_length = True
            if len(data) < pdo.size:
                return
        elif pdo.wrong_length:
            pdo.wrong_length = False
            self.errors.over(SHORT_PDO, LONG_PDO)
        pdo.came()
        self._see_who_is_late()
        if pdo.synchronous:
            pdo.waiting = data
        else:
            pdo.apply(data)
            self._application.received(pdo.keys)

    def _offer(self, pdo: TransmitPdo, data: bytes) -> None:
        if self.injector.idle or not pdo.synchronous:
            self._send(frame(pdo.cob_id, data))
        else:
            self._spoil(pdo.cob_id, data)

    def _spoil(self, cob_id: int, data: bytes) -> None:
        match self.injector.tpdo_fault():
            case Injection.TPDO_LATE:
                self.held.append(frame(cob_id, data))
            case Injection.TPDO_TWICE:
                self._send(frame(cob_id, data) * 2)
            case Injection.TPDO_SHORT:
                self._send(frame(cob_id, data[:-2]))

    def _may_write(self, key: int, value: Value) -> None:
        check_write(self.dictionary, key, value)
        self._application.may_write(key, value)

    def _written(self, key: int, value: Value) -> None:
        if key == HEARTBEAT_TIME:
            self._producer.restart(int(value))
        elif key == HISTORY:
            self.errors.empty()
        elif key_of(0x1400) <= key < key_of(0x1C00):
            self._configure_pdo(key >> 8)
        elif key < key_of(0x1400):
            self._watch_others()
        self._application.written(key, value)
