"""CiA 301 of the virtual drive, by masters that know nothing of it: raw frames, and canopen."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import canopen
import pytest
from bus_helpers import make_profile
from drive_bench import NODE, Bench, emergencies

from backends.eds import OWN_EDS
from backends.frames import REMOTE
from backends.virtual.drives.injection import Injection

OFF = 1 << 31
RPDO, TPDO = 0x200 + NODE, 0x180 + NODE
TORQUE, OFFSET, CONTROLWORD, MODE = 0x60710010, 0x60B20010, 0x60400010, 0x60600008
POSITION, STATUS, QUIET = 0x60640020, 0x60410010, 0x60B10020  # the last changes when we say
WRONG_VALUE, WRONG_STATE, NOT_MAPPABLE = 0x06090030, 0x08000022, 0x06040041


def make_pdo(bench: Bench, communication: int, cob_id: int, kind: int, *entries: int) -> None:
    """In the order that the standard asks for; every step has to be taken."""
    mapping = communication + 0x200
    steps = [(communication, cob_id | OFF, 4, 1), (communication, kind, 1, 2), (mapping, 0, 1, 0)]
    steps += [(mapping, entry, 4, k + 1) for k, entry in enumerate(entries)]
    steps += [(mapping, len(entries), 1, 0), (communication, cob_id, 4, 1)]
    assert [bench.abort(*step) for step in steps] == [0] * len(steps)


def of(sent: list[tuple[int, bytes]], can_id: int) -> list[bytes]:
    return [data for found, data in sent if found == can_id]


# --- transmission types ---


@pytest.mark.parametrize("kind", [1, 2, 7, 240])
def test_cyclic_types_count_syncs(bench: Bench, kind: int) -> None:
    make_pdo(bench, 0x1800, TPDO, kind, STATUS)
    bench.nmt(1)
    came = [len(of(bench.sync(), TPDO)) for _ in range(3 * kind)]
    assert came == ([0] * (kind - 1) + [1]) * 3


def test_type_0_is_sent_at_sync_and_only_when_something_changed(bench: Bench) -> None:
    make_pdo(bench, 0x1800, TPDO, 0, STATUS)
    bench.nmt(1)
    assert len(of(bench.sync(10), TPDO)) == 1, "once, as nothing was told yet"
    assert of(bench.send(0x600 + NODE, bytes.fromhex("2b 40 60 00 06 00 00 00")), TPDO) == []
    changed = [of(bench.sync(), TPDO) for _ in range(5)]
    assert [len(sent) for sent in changed] == [1, 0, 0, 0, 0]
    assert int.from_bytes(changed[0][0], "little") & 0x6F == 0x21


def test_event_driven_waits_for_a_change_the_inhibit_time_and_the_event_timer(
    bench: Bench,
) -> None:
    bench.write(0x1800, TPDO | OFF, 4, 1)
    assert bench.abort(0x1800, 100, 2, 3) == 0, "inhibit time, 10 ms"
    assert bench.abort(0x1800, 40, 2, 5) == 0, "event timer, 40 ms"
    make_pdo(bench, 0x1800, TPDO, 255, QUIET)
    bench.nmt(1)
    key = 0x60B1 << 8
    sent = []
    for cycle in range(60):  # of 2 ms
        if cycle < 20:
            bench.drive.values[key] = cycle
        sent += [cycle] * len(of(bench.sync(), TPDO))
    assert sent[:4] == [0, 5, 10, 15], "a change in every cycle, 10 ms apart"
    assert sent[4:] == [20, 40], "nothing changes, and it comes every 40 ms"


@pytest.mark.parametrize("kind", [*range(241, 252)])
@pytest.mark.parametrize("communication", [0x1400, 0x1800])
def test_reserved_types_are_refused(bench: Bench, communication: int, kind: int) -> None:
    before = bench.read(communication, 2)
    assert bench.abort(communication, kind, 1, 2) == WRONG_VALUE
    assert bench.read(communication, 2) == before


def test_types_for_remote_frames(bench: Bench) -> None:
    assert [bench.abort(0x1400, kind, 1, 2) for kind in (252, 253)] == [WRONG_VALUE] * 2, "no RPDO"
    key = 0x60B1 << 8
    for kind, at_sync in ((252, True), (253, False)):
        make_pdo(bench, 0x1800, TPDO, kind, QUIET)
        bench.nmt(1)
        bench.drive.values[key] = 11
        assert of(bench.sync(3), TPDO) == [], "never unasked"
        bench.drive.values[key] = 12
        [data] = of(bench.send(REMOTE | TPDO), TPDO)
        assert int.from_bytes(data, "little") == (11 if at_sync else 12)
        bench.nmt(128)
        assert bench.send(REMOTE | TPDO) == [], "not in PRE-OPERATIONAL"
    make_pdo(bench, 0x1800, TPDO | 1 << 30, 1, STATUS)
    bench.nmt(1)
    assert bench.send(REMOTE | TPDO) == [], "bit 30: no remote frames"


def test_synchronous_commands_wait_for_sync(bench: Bench) -> None:
    make_pdo(bench, 0x1400, RPDO, 1, TORQUE)
    bench.nmt(1)
    bench.send(RPDO, (77).to_bytes(2, "little"))
    assert bench.read(0x6071) == 0
    bench.sync()
    assert bench.read(0x6071) == 77
    make_pdo(bench, 0x1400, RPDO, 255, TORQUE)
    bench.send(RPDO, (78).to_bytes(2, "little"))
    assert bench.read(0x6071) == 78, "event-driven: at once"


def test_one_frame_is_for_every_rpdo_that_listens_to_it(bench: Bench) -> None:
    make_pdo(bench, 0x1400, RPDO, 255, TORQUE)
    make_pdo(bench, 0x1401, RPDO, 1, OFFSET)
    bench.nmt(1)
    bench.send(RPDO, (77).to_bytes(2, "little"))
    assert [bench.read(0x6071), bench.read(0x60B2)] == [77, 0], "the second waits for SYNC"
    bench.sync()
    assert bench.read(0x60B2) == 77


def test_a_pdo_goes_on_counting_and_waiting_while_another_is_set_up(bench: Bench) -> None:
    make_pdo(bench, 0x1800, TPDO, 5, STATUS)
    make_pdo(bench, 0x1802, TPDO + 0x200, 255, QUIET)
    make_pdo(bench, 0x1400, RPDO, 1, TORQUE)
    bench.nmt(1)
    assert len(of(bench.sync(3), TPDO + 0x200)) == 1, "once, as nothing was told yet"
    bench.send(RPDO, (77).to_bytes(2, "little"))
    assert emergencies(bench.send(RPDO, b"\1")) == [0x8210]
    assert [bench.abort(0x1801, 10, 2, 5), bench.abort(0x1401, 255, 1, 2)] == [0, 0]
    assert emergencies(bench.send(RPDO, b"\1")) == [], "told already"
    sent = bench.sync(2)
    assert len(of(sent, TPDO)) == 1, "the fifth SYNC"
    assert of(sent, TPDO + 0x200) == [], "nothing changed"
    assert bench.read(0x6071) == 77, "what was received took effect"


# --- what may be written, and when ---


def test_a_pdo_is_not_changed_while_it_exists(bench: Bench) -> None:
    for communication, cob_id in ((0x1400, RPDO), (0x1800, TPDO)):
        make_pdo(bench, communication, cob_id, 1, TORQUE)
        mapping = communication + 0x200
        assert bench.abort(communication, cob_id + 0x100, 4, 1) == WRONG_STATE, "COB-ID"
        assert bench.abort(mapping, 0, 1) == WRONG_STATE, "number of entries"
        assert bench.abort(mapping, OFFSET, 4, 1) == WRONG_STATE, "entry"
        assert bench.read(communication, 1) == cob_id
        assert bench.read(mapping, 1) == TORQUE
        assert bench.abort(communication, cob_id, 4, 1) == 0, "the same is no change"
        assert bench.abort(communication, (cob_id + 0x100) | OFF, 4, 1) == 0
        assert bench.abort(mapping, OFFSET, 4, 1) == WRONG_STATE, "count is not zero"
        assert bench.abort(communication, cob_id + 0x100, 4, 1) == 0
    assert bench.abort(0x1800, 5, 2, 3) == WRONG_STATE, "inhibit time"
    assert bench.abort(0x1800, 0, 1, 4) == 0x06090011, "sub-index 4 is not there"


@pytest.mark.parametrize(
    "can_id", [0, 0x7F, 0x101, 0x580 + NODE, 0x600 + NODE, 0x6E0, 0x700, 0x7FF]
)
def test_identifiers_that_belong_to_others_are_refused(bench: Bench, can_id: int) -> None:
    restricted = can_id != 0x700
    assert bool(bench.abort(0x1401, can_id, 4, 1)) == restricted
    assert bool(bench.abort(0x1005, can_id, 4)) == restricted
    for bit in (11, 28, 29):
        assert bench.abort(0x1401, 0x300 | 1 << bit, 4, 1) == WRONG_VALUE, "29-bit identifiers"


def test_emergencies_go_elsewhere_only_while_there_are_none(
    make_bench: Callable[..., Bench], tmp_path: Path
) -> None:
    text = OWN_EDS.read_text()
    at = text.index("[1014]")
    eds = tmp_path / "movable.eds"
    eds.write_text(text[:at] + text[at:].replace("AccessType=ro", "AccessType=rw", 1))
    bench = make_bench(drive={"eds": str(eds)})
    own, other = 0x80 + NODE, 0x90 + NODE
    assert bench.abort(0x1014, other, 4) == WRONG_STATE
    assert bench.abort(0x1014, own | OFF, 4) == 0
    assert bench.abort(0x1014, 0x701, 4) == WRONG_VALUE
    assert bench.abort(0x1014, other, 4) == 0
    bench.write(0x2F00, 0x2310, 4, 2)
    said = bench.send(0x600 + NODE, b"\x2f\x00\x2f\x01" + bytes([Injection.EMCY, 0, 0, 0]))
    assert [can_id for can_id, _ in said] == [other, 0x580 + NODE]


def test_what_is_received_can_be_written_and_what_is_sent_can_be_read(
    bench: Bench, make_bench: Callable[..., Bench], tmp_path: Path
) -> None:
    bench.write(0x1400, RPDO | OFF, 4, 1)
    bench.write(0x1600, 0, 1)
    for read_only in (POSITION, STATUS, 0x60610008):
        assert bench.abort(0x1600, read_only, 4, 1) == NOT_MAPPABLE
    assert bench.abort(0x1600, TORQUE, 4, 1) == 0
    text = OWN_EDS.read_text()
    at = text.index("[6040]")
    eds = tmp_path / "write_only.eds"
    eds.write_text(text[:at] + text[at:].replace("AccessType=rw", "AccessType=wo", 1))
    other = make_bench(drive={"eds": str(eds)})
    other.write(0x1800, TPDO | OFF, 4, 1)
    other.write(0x1A00, 0, 1)
    assert other.abort(0x1A00, CONTROLWORD, 4, 1) == NOT_MAPPABLE
    assert other.abort(0x1A00, STATUS, 4, 1) == 0


def test_one_node_has_one_heartbeat_time(bench: Bench) -> None:
    assert bench.abort(0x1016, 127 << 16 | 100, 4, 1) == 0
    assert bench.abort(0x1016, 127 << 16 | 200, 4, 2) == 0x06040043
    assert bench.abort(0x1016, 126 << 16 | 200, 4, 2) == 0
    assert bench.abort(0x1016, 127 << 16 | 300, 4, 1) == 0, "its own may change"
    assert bench.abort(0x1016, 255 << 16 | 300, 4, 2) == 0, "no node, and so not the same one"
    assert bench.drive.node.listens_to().count(0x77F) == 1
    bench.write(0x1016, 133 << 16 | 100, 4, 1)
    assert 0x705 not in bench.drive.node.listens_to(), "133 is no node, nor is it node 5"


# --- SYNC ---


def test_sync_is_what_1005_says(bench: Bench) -> None:
    make_pdo(bench, 0x1800, TPDO, 1, STATUS)
    bench.nmt(1)
    assert len(of(bench.sync(3), TPDO)) == 3
    assert bench.abort(0x1005, 0x40000080, 4) == WRONG_VALUE, "it cannot produce SYNC"
    assert bench.abort(0x1005, 0x81, 4) == 0
    assert of(bench.sync(3), TPDO) == []
    assert len(of(bench.send(0x81), TPDO)) == 1
    bench.nmt(130)
    assert bench.read(0x1005) == 0x80, "as after power-on"


def test_two_syncs_of_one_period_are_one_period(tmp_path: Path) -> None:
    bench = Bench(make_profile(tmp_path, 2))  # at 200 Hz
    assert bench.abort(0x1005, 0x81, 4) == 0
    bench.write(0x1017, 50, 2)
    beats = [of(bench.send(0x80) + bench.send(0x81), 0x700 + NODE) for _ in range(100)]
    assert sum(map(len, beats)) == 10, "100 periods of 5 ms, and a heartbeat every 50 ms"


def test_a_sync_has_a_counter_where_1019_says_so_and_nothing_else(bench: Bench) -> None:
    make_pdo(bench, 0x1400, RPDO, 1, TORQUE)
    bench.nmt(1)
    bench.send(RPDO, b"\x11\x00")
    assert emergencies(bench.send(0x80, b"\x01")) == [0x8240], "unexpected length: told …"
    assert bench.read(0x1001) == 0x11
    assert bench.read(0x6071) == 0, "… and no SYNC"
    assert emergencies(bench.send(0x80, b"\x02")) == [], "once"
    assert emergencies(bench.sync()) == [0]
    assert (bench.read(0x1001), bench.read(0x6071)) == (0, 0x11)
    assert bench.abort(0x1019, 4, 1) == 0
    bench.send(RPDO, b"\x22\x00")
    assert emergencies(bench.sync()) == [0x8240], "now the counter lacks"
    assert bench.read(0x6071) == 0x11
    assert emergencies(bench.send(0x80, b"\x01")) == [0]
    assert bench.read(0x6071) == 0x22


def test_a_sync_counter_is_set_while_no_sync_is_due(bench: Bench) -> None:
    for value in (1, 241, 255):
        assert bench.abort(0x1019, value, 1) == WRONG_VALUE
    assert bench.abort(0x1006, 2000, 4) == 0
    assert bench.abort(0x1019, 4, 1) == WRONG_STATE
    assert bench.abort(0x1006, 0, 4) == 0
    assert bench.abort(0x1019, 240, 1) == 0


def test_a_tpdo_counts_from_the_sync_that_it_is_told(bench: Bench) -> None:
    make_pdo(bench, 0x1800, TPDO, 2, STATUS)
    assert bench.abort(0x1800, 3, 1, 6) == WRONG_STATE, "it exists"
    assert bench.abort(0x1800, TPDO | OFF, 4, 1) == 0
    assert bench.abort(0x1800, 241, 1, 6) == WRONG_VALUE
    assert bench.abort(0x1800, 3, 1, 6) == 0
    assert bench.abort(0x1800, TPDO, 4, 1) == 0
    bench.nmt(1)
    uncounted = [len(of(bench.sync(), TPDO)) for _ in range(4)]
    assert uncounted == [0, 1, 0, 1], "without a counter it means nothing"
    assert bench.abort(0x1019, 4, 1) == 0
    bench.nmt(128)
    bench.nmt(1)
    came = [len(of(bench.send(0x80, bytes([1 + k % 4])), TPDO)) for k in range(8)]
    assert came == [0, 0, 0, 1, 0, 1, 0, 1]


def test_an_rpdo_that_does_not_come_in_time_is_told(bench: Bench) -> None:
    """500 Hz: 5 ms are over within the third period."""
    make_pdo(bench, 0x1400, RPDO, 255, TORQUE)
    make_pdo(bench, 0x1401, 0x300 + NODE, 255, OFFSET)
    assert [bench.abort(record, 5, 2, 5) for record in (0x1400, 0x1401)] == [0, 0]
    bench.nmt(1)
    assert emergencies(bench.sync(20)) == [], "the first one begins it"
    assert emergencies(bench.send(RPDO, b"\x11\x00")) == []
    assert emergencies(bench.sync(2)) == []
    bench.send(RPDO, b"\x12\x00")
    assert emergencies(bench.sync(2)) == []
    assert emergencies(bench.sync()) == [0x8250]
    assert bench.read(0x1001) == 0x11
    assert emergencies(bench.sync(20)) == [], "told once"
    bench.send(0x300 + NODE, b"\x00\x00")
    assert emergencies(bench.sync(4)) == [0x8250], "another one is another error"
    assert emergencies(bench.send(RPDO, b"\x12\x00")) == [], "one is late still"
    assert emergencies(bench.send(0x300 + NODE, b"\x00\x00")) == [0]
    assert bench.read(0x1001) == 0
    bench.sync(1)
    assert bench.abort(0x1400, 0, 2, 5) == bench.abort(0x1401, 0, 2, 5) == 0
    assert emergencies(bench.sync(20)) == [], "switched off"


# --- errors ---


def test_short_and_long_pdos(bench: Bench) -> None:
    make_pdo(bench, 0x1400, RPDO, 1, TORQUE)
    bench.nmt(1)
    bench.send(RPDO, b"\x11\x00")
    sent = bench.send(RPDO, b"\x22")
    assert emergencies(sent) == [0x8210], "too short: told …"
    assert bench.read(0x1001) == 0x11
    bench.sync()
    assert bench.read(0x6071) == 0x11, "… and not processed"
    assert emergencies(bench.send(RPDO, b"\x23")) == [], "an error is told once"
    assert emergencies(bench.send(RPDO, b"\x33\x00")) == [0], "and when it is over"
    assert bench.read(0x1001) == 0
    assert emergencies(bench.send(RPDO, b"\x44\x00\x55")) == [0x8220]
    bench.sync()
    assert bench.read(0x6071) == 0x44, "the first bytes count"


def test_the_history_is_kept_in_order_and_can_be_emptied(bench: Bench) -> None:
    def no_data(sub: int) -> bool:
        return bench.sdo(f"40 03 10 {sub:02x} 00 00 00 00").endswith("24 00 00 08")

    assert bench.read(0x1003) == 0
    assert no_data(1)
    for code in (0x4210, 0x3220):
        bench.write(0x2F00, code, 4, 2)
        assert emergencies(bench.send(0x600 + NODE, bytes.fromhex("2f 00 2f 01 08 00 00 00"))) == [
            code
        ]
    assert [bench.read(0x1003, sub) & 0xFFFF for sub in (0, 1, 2)] == [2, 0x3220, 0x4210]
    assert no_data(3)
    assert bench.read(0x1001) == 0x01 | 0x04 | 0x08, "voltage, temperature"
    assert bench.abort(0x1003, 1, 1) == WRONG_VALUE, "only zero"
    assert bench.read(0x1003) == 2
    assert bench.abort(0x1003, 0, 1) == 0
    assert bench.read(0x1003) == 0
    assert no_data(1)
    for k in range(12):
        bench.write(0x2F00, 0x2310 + k, 4, 2)
        bench.write(0x2F00, 8, 1, 1)
    assert bench.read(0x1003) == 8
    assert bench.read(0x1003, 1) & 0xFFFF == 0x231B, "the newest first"
    bench.nmt(130)
    assert bench.read(0x1003) == 8, "a reset of the communication does not hide what happened"
    bench.nmt(129)
    assert bench.read(0x1003) == 0


@pytest.mark.parametrize("powered", [False, True])
def test_a_new_master_finds_no_old_error_but_a_fault_and_its_cause(
    bench: Bench, powered: bool
) -> None:
    bench.write(0x1016, 127 << 16 | 100, 4, 1)
    bench.nmt(1)
    if powered:
        bench.enable()
    bench.send(0x77F, b"\x05")
    assert emergencies(bench.sync(100)) == [0x8130]
    bench.nmt(130)
    assert bench.read(0x603F) & 0xFFFF == (0x8130 if powered else 0)
    assert bool(bench.read(0x1001)) == powered
    assert bench.read(0x1003, 1) & 0xFFFF == 0x8130


# --- node guarding ---


def test_node_guarding(bench: Bench) -> None:
    ask = REMOTE | (0x700 + NODE)
    bench.write(0x100C, 20, 2)
    bench.write(0x100D, 3, 1)
    bench.nmt(1)
    bench.enable()
    assert emergencies(bench.sync(100)) == [], "not before the first question"
    states = [of(bench.send(ask), 0x700 + NODE)[0][0] for _ in range(3)]
    assert states == [0x05, 0x85, 0x05], "operational, and a bit that turns over"
    for _ in range(10):
        bench.send(ask)
        assert emergencies(bench.sync(25)) == []
    assert emergencies(bench.sync(40)) == [0x8130]
    assert bench.state() in ("FAULT REACTION ACTIVE", "FAULT")
    bench.write(0x1017, 100, 2)
    assert bench.send(ask) == [], "heartbeat and guarding exclude each other"


# --- CiA 402 over PDOs ---


def test_the_mode_by_rpdo_and_bit_12(bench: Bench) -> None:
    make_pdo(bench, 0x1400, RPDO, 1, CONTROLWORD, MODE, TORQUE)
    bench.nmt(1)

    def command(word: int, mode: int, torque: int = 0) -> int:
        data = word.to_bytes(2, "little") + bytes([mode]) + torque.to_bytes(2, "little")
        for _ in range(40):
            bench.send(RPDO, data)
            bench.sync()
        return bench.read(0x6041)

    for word in (6, 7):
        command(word, 0)
    assert command(15, 0, 100) & 0x106F == 0x0027, "enabled in no mode: it follows nobody"
    assert bench.arm.plant.torque[0] == 0.0
    assert command(15, 10, 100) & 0x106F == 0x1027
    assert bench.read(0x6061) == 10
    assert bench.arm.plant.torque[0] == pytest.approx(10.0)
    assert command(15, 8, 100) & 0x106F == 0x1027, "a mode it has not changes nothing"
    assert bench.read(0x6061) == 10
    assert command(15, 0, 100) & 0x1000 == 0


def test_polarity_and_torque_offset(bench: Bench) -> None:
    bench.enable()
    bench.arm.plant.q[:] = 0.5
    bench.sync()
    counts = bench.read(0x6064)
    bench.write(0x607E, 0x80, 1)
    bench.sync()
    assert bench.read(0x6064) == pytest.approx(-counts, abs=1000)
    bench.write(0x60B2, 300, 2)
    bench.sync()
    assert bench.arm.plant.torque[0] == pytest.approx(30.0), "on top of every command"


def test_the_brake_can_be_set_by_an_output(bench: Bench) -> None:
    bench.enable()
    assert bench.read(0x2F04) == 0
    bench.write(0x60FE, 1, 4, 1)
    bench.sync()
    assert bench.read(0x2F04) == 0, "not without its bit in the mask"
    bench.write(0x60FE, 1, 4, 2)
    bench.sync()
    assert bench.read(0x2F04) == 0, "it takes its time"
    bench.sync(20)
    assert bench.read(0x2F04) == 1
    bench.write(0x60FE, 0, 4, 1)
    assert bench.control(0) == "SWITCH ON DISABLED"
    assert bench.read(0x2F04) == 0, "whose mask gives it to the master has it from nobody else"


# --- by canopen ---


class Desk(canopen.Network):
    """canopen's network, with the drive at the other end of its function calls."""

    def __init__(self, bench: Bench) -> None:
        super().__init__()
        self._bench = bench

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        for found, answer in self._bench.send(can_id | (REMOTE if remote else 0), bytes(data)):
            self.notify(found, bytearray(answer), time.monotonic())


def test_canopen_as_master(bench: Bench) -> None:
    network = Desk(bench)
    node = network.add_node(NODE, str(OWN_EDS))
    network.subscribe(0x80 + NODE, node.emcy.on_emcy)
    assert node.sdo[0x1000].raw == 0x20192
    assert node.sdo[0x608F][1].raw / node.sdo[0x608F][2].raw == 16384
    node.tpdo.read()
    node.rpdo.read()
    for pdo, names in ((node.rpdo[1], (0x6040, 0x6060, 0x6071)), (node.tpdo[1], (0x6041, 0x6061))):
        pdo.clear()
        for index in names:
            pdo.add_variable(index)
        pdo.trans_type, pdo.enabled = 2, True
        pdo.save()
    node.tpdo[2].clear()
    node.tpdo[2].add_variable(0x2F10)
    node.tpdo[2].trans_type, node.tpdo[2].inhibit_time, node.tpdo[2].event_timer = 255, 50, 100
    node.tpdo[2].enabled = True
    node.tpdo[2].save()
    assert (node.sdo[0x1801][3].raw, node.sdo[0x1801][5].raw) == (50, 100)
    node.nmt.state = "OPERATIONAL"
    node.rpdo[1]["Modes of operation"].raw = 10
    for word in (6, 7, 15):
        node.rpdo[1]["Controlword"].raw = word
        node.rpdo[1].transmit()
        for _ in range(40):
            network.sync.transmit()
    assert node.tpdo[1]["Statusword"].raw & 0x106F == 0x1027
    assert node.tpdo[1]["Modes of operation display"].raw == 10
    node.rpdo[1]["Target torque"].raw = 250
    node.rpdo[1].transmit()
    network.sync.transmit()
    assert node.sdo[0x6074].raw == 250
    node.sdo[0x2F00][2].raw = 0x2310
    node.sdo[0x2F00][1].raw = 9
    assert [error.code for error in node.emcy.active] == [0x2310]
    assert node.sdo[0x1003][1].raw == 0x2310
    node.sdo[0x1003][0].raw = 0
    with pytest.raises(canopen.SdoAbortedError, match="0x08000024"):
        _ = node.sdo[0x1003][1].raw
    with pytest.raises(canopen.SdoAbortedError, match="0x06090030"):
        node.sdo[0x1800][2].raw = 245
    for _ in range(300):
        network.sync.transmit()
    for word in (0, 0x80):
        node.sdo[0x6040].raw = word
    assert node.emcy.active == [], "the reset is told"


@pytest.mark.parametrize("cycles", [0, 3])
def test_a_temperature_that_nobody_measures_is_no_value(
    make_bench: Callable[..., Bench], cycles: int
) -> None:
    """Not 0 degrees: the drive says that there is nothing to be read. Nor is one 0 degrees that was
    not yet measured when somebody asked."""
    bench = make_bench(simulation={"plant": "pendulums:without_thermometer"})
    bench.sync(cycles)
    assert bytes.fromhex(bench.sdo("40102f00" + "00" * 4)).hex() == "80102f0024000008"
    measured = make_bench()
    measured.sync(cycles)
    assert measured.read(0x2F10) == 250
