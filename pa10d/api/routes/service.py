"""Health and metrics, for machines."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import PlainTextResponse

from pa10d.api.deps import TheDaemon
from pa10d.api.schemas.arm import Health
from pa10d.common.jsonable import JsonObject
from pa10d.common.version import __version__
from pa10d.control.states import ArmState

router = APIRouter(tags=["service"])
STATES = tuple(state.label for state in ArmState)


@router.get("/healthz", response_model=Health)
async def health(daemon: TheDaemon) -> JsonObject:
    """Answers while the daemon is alive."""
    return {"version": __version__, "robot": daemon.robot.state, "uptime": daemon.uptime}


@router.get("/metrics", response_class=PlainTextResponse)
async def metrics(daemon: TheDaemon) -> PlainTextResponse:
    """Prometheus text exposition format 0.0.4."""
    ring, get = daemon.robot.ring, daemon.robot.ring.layout.get
    last = ring.last()
    lines = [f'pa10d_info{{version="{__version__}",profile="{daemon.profile.name}"}} 1']
    lines += [f'pa10d_arm_state{{state="{s}"}} {int(s == daemon.robot.state)}' for s in STATES]
    values: dict[str, float] = {
        "pa10d_uptime_seconds": daemon.uptime,
        "pa10d_loop_cycles_total": ring.written,
        "pa10d_telemetry_listeners": daemon.telemetry.listeners,
        "pa10d_jobs_running": len(daemon.jobs.running()),
    }
    if last is not None:
        values["pa10d_loop_missed_total"] = float(get(last, "missed"))
        recent, _ = ring.read(max(0, ring.written - 500))
        values["pa10d_loop_late_seconds_max"] = float(get(recent, "late").max(initial=0.0))
        values["pa10d_loop_busy_seconds_max"] = float(get(recent, "busy").max(initial=0.0))
        for j, torque in enumerate(get(last, "tau")):
            lines.append(f'pa10d_joint_torque_newton_metres{{joint="{j + 1}"}} {torque:.6g}')
    lines += [f"{name} {value:.9g}" for name, value in values.items()]
    return PlainTextResponse("\n".join(lines) + "\n", media_type="text/plain; version=0.0.4")
