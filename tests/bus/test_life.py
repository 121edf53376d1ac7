"""The whole life of seven axes, two processes: by our backend, and by canopen's own."""

from __future__ import annotations

import time
from pathlib import Path

import canopen
import numpy as np
import pytest
from bus_helpers import Driver, Meddler, make_profile, patient_eds, promptly, virtual_arm
from canopen.profiles.p402 import BaseNode402

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from backends.cia402 import DriveState, state_of
from backends.eds import OWN_EDS
from backends.protocol import BackendFault, Feedback
from backends.virtual.drives.injection import Injection
from backends.virtualbus import VirtualBus


def states(words: object) -> set[DriveState | None]:
    return {state_of(int(word)) for word in words}  # type: ignore[attr-defined]


@pytest.mark.parametrize("clock", ["simulated", pytest.param("real", marks=pytest.mark.realtime)])
def test_the_whole_life_by_our_backend(tmp_path: Path, clock: str) -> None:
    profile = make_profile(
        tmp_path,
        7,
        simulation={"clock": clock},
        control={"rate": 100.0},
        safety={"stale_cycles": 30},  # 0.3 s: no busy machine is judged
        drive={"eds": patient_eds(tmp_path, 600), "heartbeat_ms": 200},
    )
    with virtual_arm(profile), VirtualBus(profile.can.channel) as bus, promptly():
        arm = CanopenBackend(profile)
        assert arm.realtime == (clock == "real")
        arm.open()
        try:
            assert arm.warnings == [], "our own drive lacks nothing"
            assert [r.node for r in arm.reports] == list(range(10, 17))
            driver = Driver(arm)
            assert states(arm.read().status) == {DriveState.DISABLED}
            by_hand.enable(arm, driver.hold)
            assert states(driver.run(0.2).status) == {DriveState.ENABLED}
            most = 0.0
            for _ in range(100):
                feedback = driver.step()
                wanted = 0.3 * np.sin(2 * np.pi * feedback.time)
                if not arm.realtime:  # a busy machine comes late, and the arm with it
                    assert np.abs(feedback.q - wanted).max() < 0.1, "the arm does not follow"
                most = max(most, np.abs(feedback.tau).min())
            assert driver.reach > 0.2, "the arm does not move"
            assert most > 5.0, "torques are measured on every axis"

            arm.quick_stop()
            driver.until(lambda f: states(f.status) == {DriveState.DISABLED})
            rest = arm.read().q.copy()
            for _ in range(20):
                arm.read()
            assert np.abs(arm.read().q - rest).max() < 1e-3, "brakes hold"

            by_hand.enable(arm, driver.hold)
            driver.run(0.2)
            Meddler(profile, bus).inject(3, Injection.FAULT, 0x2310)
            with pytest.raises(BackendFault, match=r"joint 4.*overcurrent") as caught:
                driver.run(3.0)
            assert caught.value.axis == 3
            with pytest.raises(BackendFault, match="overcurrent"):
                by_hand.enable(arm)  # a fault stays until it is reset
            by_hand.disable(arm)
            assert states(arm.statuses()[:3]) == {DriveState.DISABLED}
            by_hand.reset(arm)
            assert states(arm.read().status) == {DriveState.DISABLED}

            by_hand.enable(arm, driver.hold)
            driver.run(0.2)
            by_hand.disable(arm)
            assert states(arm.statuses()) == {DriveState.DISABLED}
        finally:
            arm.close()


@pytest.mark.realtime
def test_the_whole_life_by_canopen_alone(tmp_path: Path) -> None:
    """An independent master: BaseNode402 knows nothing of our tables and layouts."""
    profile = make_profile(
        tmp_path,
        7,
        simulation={"clock": "real"},
        control={"rate": 100.0},
        drive={"eds": patient_eds(tmp_path)},
    )
    with virtual_arm(profile):
        network = canopen.Network()
        network.NOTIFIER_CYCLE = 0.05
        network.connect(interface="virtualbus", channel=profile.can.channel)
        try:
            _life_by_canopen(network)
        finally:
            network.sync.stop()
            network.disconnect()


def _life_by_canopen(network: canopen.Network) -> None:
    nodes = [BaseNode402(10 + k, str(OWN_EDS)) for k in range(7)]
    for node in nodes:
        network.add_node(node)
        be_patient(node)
        node.nmt.state = "RESET"
        node.nmt.wait_for_bootup(5)
        assert node.nmt.state == "PRE-OPERATIONAL"
        assert node.sdo[0x1000].raw & 0xFFFF == 402
        assert node.sdo[0x1008].raw == "pa10d virtual drive"  # a segmented transfer
        node.sdo[0x1017].raw = 50
        node.nmt.wait_for_heartbeat(5)
        node.tpdo.read()
        node.rpdo.read()
        node.rpdo[1].clear()
        node.rpdo[1].add_variable(0x6040)
        node.rpdo[1].add_variable(0x6071)
        node.tpdo[1].clear()
        node.tpdo[1].add_variable(0x6041)
        node.tpdo[1].add_variable(0x6064)
        node.tpdo[1].add_variable(0x6077)
        for pdo in (node.rpdo[1], node.tpdo[1]):
            pdo.trans_type, pdo.enabled = 1, True
            pdo.save()
        node.sdo[0x6085].raw = 10_000_000
    network.sync.start(0.01)
    for node in nodes:
        node.nmt.state = "OPERATIONAL"
        node.setup_402_state_machine(read_pdos=False)
        for pdo in (node.rpdo[1], node.tpdo[1]):
            assert len(pdo) in (2, 3)
        node.rpdo[1].start(0.01)
        node.op_mode = "CYCLIC SYNCHRONOUS TORQUE"
        assert node.op_mode == "CYCLIC SYNCHRONOUS TORQUE"
        node.state = "OPERATION ENABLED"
        assert node.state == "OPERATION ENABLED"

    before = [node.tpdo[1]["Position actual value"].raw for node in nodes]
    for node in nodes:
        node.rpdo[1]["Target torque"].raw = 300
    for node, start in zip(nodes, before, strict=True):
        position = node.tpdo[1]["Position actual value"]
        _wait(lambda p=position, s=start: p.raw > s + 1000)  # type: ignore[misc]
        assert node.tpdo[1]["Torque actual value"].raw == 300

    for node in nodes:
        node.rpdo[1]["Controlword"].raw = 2
    for node in nodes:
        _wait(lambda node=node: node.state == "SWITCH ON DISABLED")  # type: ignore[misc]
    rest = [node.tpdo[1]["Position actual value"].raw for node in nodes]
    time.sleep(0.1)
    for node, stopped in zip(nodes, rest, strict=True):
        assert abs(node.tpdo[1]["Position actual value"].raw - stopped) < 400, "brakes hold"

    faulty, codes = nodes[2], []
    faulty.emcy.add_callback(lambda error: codes.append(error.code))
    for node in nodes:
        node.rpdo[1]["Target torque"].raw = 0
    faulty.state = "OPERATION ENABLED"
    faulty.sdo[0x2F00][2].raw = 0x4310
    faulty.sdo[0x2F00][1].raw = int(Injection.FAULT)
    _wait(lambda: faulty.state == "FAULT")
    assert codes == [0x4310]
    assert faulty.sdo[0x603F].raw == 0x4310
    faulty.state = "SWITCH ON DISABLED"  # by the fault reset bit
    assert faulty.state == "SWITCH ON DISABLED"
    assert faulty.sdo[0x603F].raw == 0
    faulty.state = "OPERATION ENABLED"
    faulty.state = "SWITCHED ON"
    faulty.state = "SWITCH ON DISABLED"
    assert faulty.sdo[0x2F04].raw == 1, "brake on"


def be_patient(node: BaseNode402) -> None:
    """canopen waits for tenths of a second; a busy machine answers later."""
    node.sdo.RESPONSE_TIMEOUT = 5.0
    for name in dir(node):
        if name.startswith("TIMEOUT_"):
            setattr(node, name, 5.0)


def _wait(condition: object, seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < end, "timed out"
        time.sleep(0.01)


def test_all_brakes_open_in_the_same_cycle_and_meet_the_load(tmp_path: Path) -> None:
    """Side by side and not one after the other: no axis falls while another is still braked."""
    profile = make_profile(tmp_path, 7, simulation={"options": {"gravity": 60.0}})
    with virtual_arm(profile):
        arm = CanopenBackend(profile)
        arm.open()
        try:
            seen: list[list[bool]] = []

            def hold(feedback: Feedback) -> np.ndarray:
                seen.append([state_of(int(s)) is DriveState.ENABLED for s in feedback.status])
                return 60.0 * np.sin(feedback.q) - 200.0 * feedback.q

            by_hand.enable(arm, hold)
            enabled = [sum(row) for row in seen] + [
                sum(state_of(s) is DriveState.ENABLED for s in arm.statuses())
            ]
            assert sorted(set(enabled)) == [0, 7]
            assert len(seen) * arm.period < 0.2, "seven brakes take no longer than one"
        finally:
            arm.close()
