"""The service under a real systemd on a real SocketCAN interface; run by scripts/rig-tests.

Not for pytest: it installs a unit and takes an interface away. Prints a line per check and ends
with the number of those that failed. What ends by kill -9 systemd starts again as what it ended
itself: the former is tried with --long.
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
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "tests" / "bus"), str(HERE.parents[1])]

from bus_helpers import patient_eds  # noqa: E402
from bus_observer import Observer  # noqa: E402

from pa10d.client import Client  # noqa: E402
from pa10d.common.errors import UserError  # noqa: E402
from pa10d.profile import find_profile  # noqa: E402
from pa10d.store import RunStore  # noqa: E402

PLACE = Path("/opt/pa10d-rig")
DATA = Path("/var/lib/pa10d")
PORT = 8010
AXES = 3
PATIENCE = 180.0  # s; the rig takes a tenth of it where it has a core to itself
ENDS = 10.0  # s for the service to end once its interface is gone
EXPOSURE = 25  # tenths, of systemd-analyze security: 0 is tight, 100 wide open
bad = 0


def check(name: str, good: bool, more: object = "") -> None:
    global bad
    bad += not good
    print(f"{'PASS' if good else 'FAIL'} {name} {more}", flush=True)


def shell(command: str, timeout: float = 200) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, shell=True, text=True, capture_output=True, timeout=timeout)


def show(what: str) -> str:
    return shell(f"systemctl show -p {what} --value pa10d").stdout.strip()


def wait(done: Callable[[], bool], seconds: float = PATIENCE) -> float | None:
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
    made["control"] = {"rate": 50.0, "controller": "pid"}
    made["safety"] = {"stale_cycles": 25, "following_error": [1.0] * AXES}
    PLACE.mkdir(exist_ok=True)
    for drive in made["drives"]:
        drive |= {"eds": patient_eds(PLACE, 400), "heartbeat_ms": 200}
    path = PLACE / "arm.yaml"
    path.write_text(yaml.safe_dump(made))
    return path


def start_arm(path: Path) -> subprocess.Popen[str]:
    """The virtual arm on the real interface, outside of the service."""
    arm = subprocess.Popen(
        [sys.executable, "-m", "pa10d", "sim", "--profile", str(path)],
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert arm.stderr is not None
    while "virtual arm on" not in (line := arm.stderr.readline()):
        print("sim:", line.strip(), flush=True)
        assert line, "the virtual arm did not start"
    return arm


def is_inactive() -> bool:
    """Whether the robot answers; a fault is acknowledged: drives may have stopped by themselves."""
    with Client(f"http://127.0.0.1:{PORT}", name="rig") as client:
        state = client.robot()["state"]
        if state == "fault":
            client.reset()
        time.sleep(0.5)  # the first cycles may bring what the drives have to tell
        return bool(state == client.robot()["state"] == "inactive")


def answers(again: str = "") -> None:
    took = wait(is_inactive, PATIENCE)
    check(f"the robot answers{again}", took is not None, f"{took} s")


def start_moving() -> None:
    with Client(f"http://127.0.0.1:{PORT}", name="rig") as client:
        plan = {"kind": "tracking", "parameters": {"cycles": 20, "period": 8.0, "amplitude": 0.2}}
        job = client.start("experiments", plan)

        def recording() -> bool:
            now = client.job(job["id"])
            assert now["status"] == "running", now["error"]
            return bool(client.robot()["recording"])

        assert wait(recording, PATIENCE) is not None
        time.sleep(1.0)


def check_run(*statuses: str) -> None:
    """The newest run can be read up to its end, and says how it ended."""
    store = RunStore(DATA)
    info = store.all()[-1]
    seconds = store.recording(info).duration
    good = info.status in statuses and seconds > 0.1
    check("run readable", good, f"{info.status}, {seconds:.1f} s, {info.reason}")


def check_rest(what: str, within: float = 30.0) -> None:
    """Seen on the bus: no drive is powered, so all brakes are on, and nothing moves."""
    watch = Observer("vcan0", range(1, AXES + 1), "socketcan")
    try:
        check(f"{what}: arm at rest, brakes on", True, f"{watch.wait_for_rest(within):.1f} s")
    except AssertionError as error:
        check(f"{what}: arm at rest, brakes on", False, error)
    finally:
        watch.close()


def started_anew(pid: str) -> bool:
    return show("ActiveState") == "active" and show("MainPID") not in (pid, "0")


def keep_compiled() -> None:
    """What the host's tests have compiled lies beside the sources; the unit compiles its own."""
    folder = Path("/etc/systemd/system/pa10d.service.d")
    folder.mkdir(parents=True, exist_ok=True)
    lines = ("[Service]", "Environment=NUMBA_CACHE_DIR=", f"ReadWritePaths={HERE.parents[1]}")
    (folder / "rig.conf").write_text("\n".join(lines) + "\n")


def installed(path: Path) -> None:
    install = HERE.parents[1] / "scripts" / "install-service"
    began = time.monotonic()
    done = shell(f"{sys.executable} {install} --profile {path} --user root --port {PORT}")
    ready = done.returncode == 0 and show("ActiveState") == "active"
    took = f"{time.monotonic() - began:.1f} s, {show('StatusText')}"
    check("start blocks until READY=1", ready, took)
    assert ready, done.stderr
    answers()


def killed_while_moving() -> None:
    start_moving()
    pid = show("MainPID")
    os.kill(int(pid), signal.SIGKILL)
    check_rest("killed")
    took = wait(lambda: started_anew(pid))
    check("started again after kill -9", took is not None, f"{took} s")
    answers(" after kill -9")
    check_run("stopped", "aborted", "failed")


def hung_while_moving() -> None:
    start_moving()
    pid = show("MainPID")
    os.kill(int(pid), signal.SIGSTOP)
    check_rest("hung")
    took = wait(lambda: started_anew(pid))
    check("started again after the watchdog's bite", took is not None, f"{took} s")
    journal = shell("journalctl -u pa10d --no-pager -o cat").stdout
    check("journal names the watchdog", "Watchdog timeout" in journal)
    answers(" after the watchdog's bite")
    check_run("aborted")


def unplugged_while_moving() -> None:
    start_moving()
    shell("ip link del vcan0")
    took = wait(lambda: show("ActiveState") in ("inactive", "failed"))
    result = show("Result")
    good = took is not None and took < ENDS and result == "success"
    check("interface removed: service ended by itself", good, f"{took} s, {result}")
    check_run("aborted", "stopped", "failed")
    shell("ip link add vcan0 type vcan; ip link set vcan0 up")
    took = wait(lambda: show("ActiveState") == "active")
    check("interface back: service started", took is not None, f"{took} s")
    answers(" after that")


def stopped_while_moving() -> None:
    start_moving()
    began = time.monotonic()
    shell("systemctl stop pa10d")
    check("stop while moving", show("Result") == "success", f"{time.monotonic() - began:.1f} s")
    check_rest("stopped", 10.0)
    check_run("stopped", "aborted")


def analysed() -> None:
    done = shell("systemd-analyze verify pa10d.service")
    check("systemd-analyze verify", done.returncode == 0, done.stderr.strip()[:300])
    done = shell(f"systemd-analyze security --no-pager --threshold={EXPOSURE} pa10d.service")
    check("systemd-analyze security", done.returncode == 0, done.stdout.strip().splitlines()[-1])


def main() -> int:
    path = profile()
    keep_compiled()
    arm = start_arm(path)
    try:
        installed(path)
        more = [killed_while_moving] if "--long" in sys.argv else []
        for trial in (*more, hung_while_moving, unplugged_while_moving, stopped_while_moving):
            began = time.monotonic()
            trial()
            print(f"     {trial.__name__}: {time.monotonic() - began:.0f} s", flush=True)
        analysed()
    except Exception as error:
        check("carried on", False, repr(error))
    arm.kill()
    if bad:
        print(shell("journalctl -u pa10d --no-pager -o cat | tail -150").stdout)
    return bad


if __name__ == "__main__":
    sys.exit(main())
