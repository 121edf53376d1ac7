"""The service under a real systemd on a real SocketCAN interface; run by scripts/rig-service.

Not for pytest: it installs a unit and takes an interface away. Prints a line per check and ends
with the number of those that failed.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from bus_observer import Observer  # noqa: E402

from pa10d.client import Client  # noqa: E402
from pa10d.errors import UserError  # noqa: E402
from pa10d.profile import find_profile  # noqa: E402
from pa10d.store import RunStore  # noqa: E402

PLACE = Path("/opt/pa10d-rig")
DATA = Path("/var/lib/pa10d")
PORT = 8010
AXES = 3
bad = 0


def check(name: str, good: bool, more: object = "") -> None:
    global bad
    bad += not good
    print(f"{'PASS' if good else 'FAIL'} {name} {more}", flush=True)


def shell(command: str, timeout: float = 200) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, shell=True, text=True, capture_output=True, timeout=timeout)


def show(what: str) -> str:
    return shell(f"systemctl show -p {what} --value pa10d").stdout.strip()


def wait(done: Callable[[], bool], seconds: float = 90.0) -> float | None:
    """Seconds until it is so, None where it never was."""
    began = time.monotonic()
    while time.monotonic() - began < seconds:
        try:
            if done():
                return time.monotonic() - began
        except (UserError, OSError):
            pass
        time.sleep(0.1)
    return None


def profile() -> Path:
    """Three axes of the simulated arm at a rate that this machine's system calls allow."""
    base = find_profile("pa10-sim")
    made = yaml.safe_load(base.read_text())
    made["urdf"] = str(base.parent / made["urdf"])
    for section in ("velocity", "acceleration", "torque"):
        made["limits"][section] = made["limits"][section][:AXES]
    made["joints"], made["drives"] = made["joints"][:AXES], made["drives"][:AXES]
    made["can"] = {"interface": "socketcan", "channel": "vcan0", "bitrate": 1000000}
    made["control"] = {"rate": 50.0, "controller": "pid", "bandwidth_hz": 0.8}
    made["safety"] = {"stale_cycles": 25, "following_error": [1.0] * AXES}
    PLACE.mkdir(exist_ok=True)
    path = PLACE / "arm.yaml"
    path.write_text(yaml.safe_dump(made))
    return path


def start_arm(path: Path) -> subprocess.Popen[str]:
    """The virtual arm on the real interface, outside of the service."""
    arm = subprocess.Popen(
        [sys.executable, "-m", "pa10d", "sim", "--profile", str(path)],
        stderr=subprocess.PIPE, text=True, env={**os.environ, "NUMBA_CACHE_DIR": "/opt/numba"},
    )  # fmt: skip
    assert arm.stderr is not None
    while "virtual arm on" not in (line := arm.stderr.readline()):
        print("sim:", line.strip(), flush=True)
        assert line, "the virtual arm did not start"
    return arm


def is_inactive() -> bool:
    with Client(f"http://127.0.0.1:{PORT}") as client:
        return bool(client.robot()["state"] == "inactive")


def start_moving() -> None:
    with Client(f"http://127.0.0.1:{PORT}", name="rig") as client:
        plan = {"kind": "tracking", "parameters": {"cycles": 20, "period": 8.0}}
        job = client.start("experiments", plan)

        def recording() -> bool:
            now = client.job(job["id"])
            assert now["status"] == "running", now["error"]
            return bool(client.robot()["recording"])

        assert wait(recording, 120) is not None
        time.sleep(1.0)


def last_run() -> str:
    info = RunStore(DATA).all()[-1]
    recording = RunStore(DATA).recording(info)
    return f"{info.status}, {recording.duration:.1f} s, {info.reason}"


def at_rest(within: float = 30.0) -> str:
    watch = Observer("vcan0", range(1, AXES + 1), "socketcan")
    try:
        return f"after {watch.wait_for_rest(within):.1f} s"
    except AssertionError as error:
        return f"no: {error}"
    finally:
        watch.close()


def main() -> int:
    path = profile()
    arm = start_arm(path)
    install = HERE.parents[1] / "scripts" / "install-service"
    began = time.monotonic()
    done = shell(f"{sys.executable} {install} --profile {path} --user root --port {PORT}")
    ready = done.returncode == 0 and show("ActiveState") == "active"
    took = f"{time.monotonic() - began:.1f} s {show('StatusText')} {done.stderr.strip()[-200:]}"
    check("start blocks until READY=1", ready, took)
    check("the robot answers", wait(is_inactive, 120) is not None)

    start_moving()
    began = time.monotonic()
    shell("systemctl stop pa10d")
    check("stop while moving", show("Result") == "success", f"{time.monotonic() - began:.1f} s")
    rest = at_rest()
    check("arm at rest, brakes on", rest.startswith("after"), rest)
    check("run readable", True, last_run())

    shell("systemctl start pa10d")
    wait(is_inactive, 120)
    start_moving()
    first = show("MainPID")
    os.kill(int(first), signal.SIGKILL)
    rest = at_rest()
    check("killed while moving: arm at rest, brakes on", rest.startswith("after"), rest)
    took_s = wait(lambda: show("ActiveState") == "active" and show("MainPID") not in (first, "0"))
    check("started again", took_s is not None, f"{took_s} s, restarts {show('NRestarts')}")
    check("the robot answers again", wait(is_inactive, 120) is not None)
    check("run readable", True, last_run())

    start_moving()
    second = show("MainPID")
    os.kill(int(second), signal.SIGSTOP)
    rest = at_rest()
    check("hung while moving: control stops the arm", rest.startswith("after"), rest)
    took_s = wait(lambda: show("ActiveState") == "active" and show("MainPID") not in (second, "0"))
    check("watchdog bites, started again", took_s is not None, f"{took_s} s")
    journal = shell("journalctl -u pa10d --no-pager -o cat").stdout
    check("journal says watchdog", "Watchdog timeout" in journal)
    check("the robot answers again", wait(is_inactive, 120) is not None)

    shell("ip link del vcan0")
    gone = wait(lambda: show("ActiveState") in ("inactive", "failed"))
    check("interface removed: service stopped", gone is not None, show("Result"))
    arm.kill()
    shell("ip link add vcan0 type vcan; ip link set vcan0 up")
    back = wait(lambda: show("ActiveState") == "active", 180)
    check("interface back: service started", back is not None, f"{back} s")
    arm = start_arm(path)
    check("the robot answers again", wait(is_inactive, 120) is not None)

    done = shell("systemd-analyze verify pa10d.service")
    check("systemd-analyze verify", done.returncode == 0, done.stderr.strip()[:300])
    done = shell("systemd-analyze security --no-pager pa10d.service")
    check("systemd-analyze security", done.returncode == 0, done.stdout.strip().splitlines()[-1])
    shell("systemctl stop pa10d")
    arm.kill()
    if bad:
        print(shell("journalctl -u pa10d --no-pager -o cat | tail -150").stdout)
    return bad


if __name__ == "__main__":
    sys.exit(main())
