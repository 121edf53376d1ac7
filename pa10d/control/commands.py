"""Messages of the daemon turned into calls of the arm, and the answers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.control.admission import wrong_with_model
from pa10d.control.arm import Arm
from pa10d.control.computed_torque import WITH_MODEL, ComputedTorque
from pa10d.control.gains import PidGains
from pa10d.control.live_model import LiveModel
from pa10d.control.pid import Controller, Pid
from pa10d.control.reference import MotionUnderWay
from pa10d.control.states import POWERED, ArmState, Refused
from pa10d.dynamics import Robot


class Commands:
    """Carries out one message at a time; never raises."""

    def __init__(self, arm: Arm, robot: Robot, make_servo: Callable[[], Pid]) -> None:
        self._arm, self._robot, self._make_servo = arm, robot, make_servo
        self._plain: dict[str, Callable[[], str | None]] = {
            name: getattr(arm, name)
            for name in ("connect", "disconnect", "enable", "disable", "stop", "reset")
        }

    def carry_out(self, message: dict[str, Any]) -> dict[str, Any]:
        """→ ``{reply, ok, state}``, with ``said`` where something went wrong all the same, and with
        ``drives`` where they were asked what they remember, or
        ``{reply, ok: False, command, state, needed, detail, remedy}``."""
        number, what = message.get("id"), str(message.get("do"))
        more: dict[str, Any] = {}
        try:
            if what == "run":
                self._arm.run(load_motion(message))
            elif what == "controller":
                self._arm.use(self._controller(message))
            elif what == "gains":
                self._take_gains(message)
            elif what == "errors":
                found = self._arm.drive_errors(clear=bool(message.get("clear")))
                more = {"drives": [{"joint": k + 1, **d.document()} for k, d in enumerate(found)]}
            elif what in self._plain:
                if (said := self._plain[what]()) is not None:
                    more = {"said": said}
            else:
                raise ValueError(f"unknown command {what!r}")
        except Refused as refusal:
            return {
                "reply": number,
                "ok": False,
                "command": refusal.command,
                "state": refusal.state.label,
                "needed": [s.label for s in refusal.needed],
                "detail": str(refusal),
                "remedy": refusal.remedy,
            }
        except Exception as error:
            detail = f"{what}: {type(error).__name__}: {error}"
            return {"reply": number, "ok": False, "command": what, "detail": detail}
        return {"reply": number, "ok": True, "state": self._arm.state.label, **more}

    def _take_gains(self, message: dict[str, Any]) -> None:
        """Other gains for every servo from now on; the law at work stays what it is."""
        gains = PidGains.from_document(message["gains"])
        limit, period = self._arm.path.limits.torque, self._arm.backend.period
        self._make_servo = lambda: Pid(gains, limit, period)
        law: Controller = self._arm.path.controller
        servo = self._make_servo()
        law = type(law)(self._robot, law.model, servo) if isinstance(law, ComputedTorque) else servo
        if self._arm.state == ArmState.HOLDING:
            # held from where it is: stiffer gains make more of the same distance from its place
            self._arm.path.reference.rest(self._arm.path.q.copy())
        if self._arm.state in POWERED:
            self._arm.use(law)
        else:
            self._arm.path.controller = law  # begins when the arm is powered
        self._arm.path.make_servo = self._make_servo

    def _controller(self, message: dict[str, Any]) -> Controller:
        servo = self._make_servo()
        if message["name"] == "pid":
            return servo
        model = LiveModel.from_document(message["model"])
        wrong = wrong_with_model(model, self._robot, self._arm.path.limits.velocity)
        if wrong is not None:
            state = self._arm.state
            raise Refused("controller", state, (state,), f"model '{model.name}': {wrong}")
        return WITH_MODEL[message["name"]](self._robot, model, servo)


def load_motion(message: dict[str, Any]) -> MotionUnderWay:
    """The motion whose rows lie in a file of memory; they are paged in as they are followed."""
    rows = np.load(Path(message["rows"]), mmap_mode="r")
    return MotionUnderWay(int(message["number"]), rows, int(message["first"]), int(message["last"]))
