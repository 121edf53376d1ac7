"""A CANopen node: NMT, boot-up, heartbeats, SDO, PDO (CiA 301). What it controls is elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from backends.frames import frame
from backends.virtual.errors import LOST_HEARTBEAT, SHORT_PDO, ErrorMemory
from backends.virtual.heartbeats import Consumer, Producer
from backends.virtual.injection import Injection, Injector
from backends.virtual.object_dictionary import LiveDictionary, Value, key_of
from backends.virtual.pdo import Pdo, check_mapping_write, compile_pdos
from backends.virtual.sdo_server import SdoServer

BOOTING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
START, STOP, ENTER_PRE_OPERATIONAL, RESET, RESET_COMMUNICATION = 1, 2, 128, 129, 130
STATE_AFTER = {START: OPERATIONAL, STOP: STOPPED, ENTER_PRE_OPERATIONAL: PRE_OPERATIONAL}
HEARTBEAT_TIME = key_of(0x1017)


class Application(Protocol):
    """What sits behind the node and is told what happens on the bus."""

    def received(self) -> None:
        """An RPDO changed the dictionary."""

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
        self.errors = ErrorMemory(dictionary, lambda data: self._say(0x80, data))
        self.held: list[bytes] = []  # TPDOs that come late on purpose
        self.since_sync = 0.0  # s
        self.on_routes: Callable[[], None] = lambda: None
        self._application, self._send, self._boot_time = application, send, boot_time
        self._sdo = SdoServer(dictionary)
        self._producer, self._consumer = Producer(), Consumer()
        self._rpdos: dict[int, Pdo] = {}
        self._tpdos: list[Pdo] = []
        self._boot_left = boot_time
        dictionary.may_write, dictionary.on_write = self._may_write, self._written

    def listens_to(self) -> list[int]:
        """Identifiers of the frames this node wants, SYNC aside."""
        heartbeats = [0x700 + node for node in self._consumer.nodes]
        return [0, 0x600 + self.id, *self._rpdos, *heartbeats]

    def receive(self, can_id: int, data: bytes) -> None:
        """A frame arrived."""
        if self.injector.silent:
            return
        if can_id == 0:
            self._command(data)
        elif self.state == BOOTING:
            return
        elif can_id == 0x600 + self.id:
            if self.state != STOPPED and (answer := self._sdo.answer(data)) is not None:
                self._say(0x580, answer)
        elif (pdo := self._rpdos.get(can_id)) is not None:
            if self.state == OPERATIONAL:
                self._take(pdo, data)
        elif can_id > 0x700:
            self._consumer.heard(can_id - 0x700)

    def sync(self) -> None:
        """SYNC: what the synchronous RPDOs brought takes effect."""
        if self.injector.silent or self.state != OPERATIONAL:
            return
        self.since_sync = 0.0
        for pdo in self._rpdos.values():
            if pdo.waiting is not None:
                data, pdo.waiting = pdo.waiting, None
                self._apply(pdo, data)

    def advance(self, dt: float) -> None:
        """Let ``dt`` s pass: boot, miss heartbeats."""
        if self.state == BOOTING:
            self._boot_left -= dt
            if self._boot_left <= 1e-9:
                self.boot()
            return
        self.since_sync += dt
        if self._consumer.lost(dt) is not None:
            self.communication_error(LOST_HEARTBEAT)

    def answer(self, dt: float, synced: bool) -> None:
        """Send what is due after ``dt`` s: TPDOs from the present values, the heartbeat."""
        if self.injector.silent or self.state == BOOTING:
            return
        if self.state == OPERATIONAL:
            for pdo in self._tpdos:
                self._offer(pdo, synced)
        period = self.dictionary.values.get(HEARTBEAT_TIME, 0)
        if self._producer.due(dt, int(period)) and not self.injector.heartbeat_mute:
            self._say(0x700, bytes([self.state]))

    def communication_error(self, code: int) -> None:
        """Tell, let the application react, and leave OPERATIONAL as 0x1029 says."""
        self.errors.emergency(code)
        self._application.connection_lost()
        if self.state == OPERATIONAL and self.dictionary.number(0x1029, 1) == 0:
            self.state = PRE_OPERATIONAL

    def restart(self, completely: bool) -> None:
        """NMT reset of the node, or of its communication only."""
        self.dictionary.restore(communication_only=not completely)
        self._application.restarted(completely)
        self._consumer = Consumer()
        self.state, self._boot_left = BOOTING, self._boot_time
        if self._boot_time <= 0:
            self.boot()

    def boot(self) -> None:
        """End of start-up: the boot-up message, then PRE-OPERATIONAL."""
        self.state = PRE_OPERATIONAL
        self.configure()
        self._say(0x700, b"\0")

    def configure(self) -> None:
        """Take over PDO and heartbeat settings from the dictionary."""
        self._rpdos = {pdo.cob_id: pdo for pdo in compile_pdos(self.dictionary, 0x1400, 0x1600)}
        self._tpdos = compile_pdos(self.dictionary, 0x1800, 0x1A00)
        self._consumer.configure(self.dictionary)
        self.on_routes()

    def _say(self, function: int, data: bytes) -> None:
        if not self.injector.silent:
            self._send(frame(function + self.id, data))

    def _command(self, data: bytes) -> None:
        if len(data) != 2 or data[1] not in (0, self.id):
            return
        if self.state == OPERATIONAL and data[0] != START:
            self._application.connection_lost()
        if data[0] in (RESET, RESET_COMMUNICATION):
            self.restart(completely=data[0] == RESET)
        elif self.state != BOOTING:
            self.state = STATE_AFTER.get(data[0], self.state)

    def _take(self, pdo: Pdo, data: bytes) -> None:
        if pdo.synchronous:
            pdo.waiting = data
        else:
            self._apply(pdo, data)

    def _apply(self, pdo: Pdo, data: bytes) -> None:
        if pdo.apply(data):
            self._application.received()
        else:
            self.errors.emergency(SHORT_PDO)

    def _offer(self, pdo: Pdo, synced: bool) -> None:
        if not pdo.synchronous:
            if (data := pdo.pack()) != pdo.sent:
                pdo.sent = data
                self._send(frame(pdo.cob_id, data))
        elif synced:
            pdo.syncs += 1
            if pdo.syncs >= pdo.type:
                pdo.syncs = 0
                if self.injector.idle:
                    self._send(frame(pdo.cob_id, pdo.pack()))
                else:
                    self._spoil(pdo.cob_id, pdo.pack())

    def _spoil(self, cob_id: int, data: bytes) -> None:
        match self.injector.tpdo_fault():
            case Injection.TPDO_LATE:
                self.held.append(frame(cob_id, data))
            case Injection.TPDO_TWICE:
                self._send(frame(cob_id, data) * 2)
            case Injection.TPDO_SHORT:
                self._send(frame(cob_id, data[:-2]))

    def _may_write(self, key: int, value: Value) -> None:
        check_mapping_write(self.dictionary, key, value)
        self._application.may_write(key, value)

    def _written(self, key: int, value: Value) -> None:
        if key == HEARTBEAT_TIME:
            self._producer.restart(int(value))
        elif 0x100000 <= key < 0x200000:
            self.configure()
        self._application.written(key, value)
