"""One virtual drive in process and in simulated time, and somebody who writes frames to it."""

from __future__ import annotations

from canopen.profiles.p402 import State402

from backends.frames import frame, frames
from backends.virtual.arm import VirtualArm
from pa10d.profile import Profile

NODE = 10


class Recorder:
    """A port that keeps what was sent."""

    def __init__(self) -> None:
        self.sent: list[tuple[int, bytes]] = []

    def send(self, packet: bytes) -> None:
        self.sent += list(frames(packet))

    def receive(self, timeout: float) -> bytes:
        return b""

    def close(self) -> None: ...

    def take(self) -> list[tuple[int, bytes]]:
        taken, self.sent = self.sent, []
        return taken


class Bench:
    """One virtual drive in simulated time and somebody who writes frames to it."""

    def __init__(self, profile: Profile) -> None:
        self.port = Recorder()
        self.arm = VirtualArm(profile, self.port)
        self.drive = self.arm.drives[0]
        assert self.port.take()[0] == (0x700 + NODE, b"\0"), "boot-up"

    def send(self, can_id: int, data: bytes = b"") -> list[tuple[int, bytes]]:
        self.arm.handle(frame(can_id, data))
        return self.port.take()

    def sdo(self, request: str) -> str:
        sent = self.send(0x600 + NODE, bytes.fromhex(request))
        [answer] = [data for can_id, data in sent if can_id == 0x580 + NODE]
        return answer.hex(" ")

    def write(self, index: int, value: int, size: int, sub: int = 0) -> str:
        head = 0x23 | 4 - size << 2
        data = (value & (1 << 8 * size) - 1).to_bytes(size, "little").ljust(4, b"\0")
        return self.sdo(bytes([head, index & 0xFF, index >> 8, sub]).hex() + data.hex())

    def read(self, index: int, sub: int = 0) -> int:
        answer = bytes.fromhex(
            self.sdo(bytes([0x40, index & 0xFF, index >> 8, sub]).hex() + "00" * 4)
        )
        size = 4 - (answer[0] >> 2 & 3)
        return int.from_bytes(answer[4 : 4 + size], "little", signed=True)

    def sync(self, periods: int = 1) -> list[tuple[int, bytes]]:
        return [f for _ in range(periods) for f in self.send(0x80)]

    def nmt(self, command: int) -> list[tuple[int, bytes]]:
        return self.send(0, bytes([command, NODE]))

    def abort(self, index: int, value: int, size: int, sub: int = 0) -> int:
        """The abort code that a write meets, 0 where it is taken."""
        answer = bytes.fromhex(self.write(index, value, size, sub))
        return int.from_bytes(answer[4:], "little") if answer[0] == 0x80 else 0

    def state(self) -> str:
        """In the words of canopen's own table."""
        word = self.read(0x6041)
        return next(n for n, (m, b) in State402.SW_MASK.items() if word & m == b)

    def control(self, word: int, periods: int = 40) -> str:
        self.write(0x6040, word, 2)
        self.sync(periods)
        return self.state()

    def enable(self) -> None:
        self.write(0x6060, 10, 1)
        assert self.control(6) == "READY TO SWITCH ON"
        assert self.control(7) == "SWITCHED ON"
        assert self.control(15) == "OPERATION ENABLED"

    @property
    def speed(self) -> float:
        return float(self.arm.plant.dq[0])


def emergencies(sent: list[tuple[int, bytes]]) -> list[int]:
    return [int.from_bytes(d[:2], "little") for can_id, d in sent if can_id == 0x80 + NODE]
