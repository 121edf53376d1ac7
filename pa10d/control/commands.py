"""Messages of the daemon turned into calls of the arm, and the answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.admission import wrong_with_model
from pa10d.control.arm import Arm
from pa10d.control.build import weight_of
from pa10d.control.computed_torque import BY_NAME, ComputedTorque
from pa10d.control.gains import PidGains
from pa10d.control.messages import (
    AskErrors,
    Command,
    Connect,
    Do,
    FollowRows,
    PowerDown,
    PowerUp,
    UseGains,
    UseLaw,
    read_command,
)
from pa10d.control.pid import Controller, Pid
from pa10d.control.reference import MotionUnderWay
from pa10d.control.rows import rows_in
from pa10d.control.states import POWERED, ArmState, Refused
from pa10d.dynamics import Robot


class Commands:
    """Carries out one message at a time; never raises."""

    def __init__(self, arm: Arm, robot: Robot, make_servo: Callable[[], Pid]) -> None:
        self._arm, self._robot, self._make_servo = arm, robot, make_servo

    def carry_out(self, message: Mapping[str, Any]) -> JsonObject:
        """→ ``{reply, ok, state}``, with ``said`` where something went wrong all the same, and with
        ``drives`` where they were asked what they remember, or
        ``{reply, ok: False, command, state, needed, detail, remedy}``."""
        number, what = message.get("id"), str(message.get("do"))
        try:
            more = self._done(read_command(message))
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

    def _done(self, command: Command) -> JsonObject:
        """Carried out → what there is to tell beside the arm's state."""
        match command:
            case FollowRows():
                self._arm.run(motion_of(command, self._arm.backend.n))
            case UseLaw():
                self._arm.use(self._controller(command))
            case UseGains():
                self._take_gains(command.gains)
                self._take_weights(command.bodies)
            case AskErrors():
                found = self._arm.drive_errors(clear=command.clear)
                return {"drives": [{"joint": k + 1, **d.document()} for k, d in enumerate(found)]}
            case PowerUp():
                self._arm.enable(recover=command.recover)
            case PowerDown():
                self._arm.disable(anyway=command.anyway)
            case Connect():
                self._take_weights(command.bodies)
                n = self._arm.backend.n
                doubted = [joint - 1 for joint in command.doubted if 1 <= joint <= n]
                self._arm.connect(stood_at(command, n), command.measured, doubted)
            case Do():
                said = getattr(self._arm, command.what)()
                return {} if said is None else {"said": said}
        return {}

    def _take_weights(self, bodies: NDArray[np.float64] | None) -> None:
        """(n, 10) as they were felt; None: what is known stays."""
        if bodies is not None:
            self._arm.weigh(weight_of(self._robot, bodies))

    def _take_gains(self, gains: PidGains) -> None:
        """The law at work stays what it is."""
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

    def _controller(self, command: UseLaw) -> Controller:
        servo, model = self._make_servo(), command.model
        if command.name == "pid" or model is None:
            return servo
        wrong = wrong_with_model(model, self._robot, self._arm.path.limits)
        if wrong is not None:
            state = self._arm.state
            raise Refused("controller", state, (state,), f"model '{model.name}': {wrong}")
        return BY_NAME[command.name](self._robot, model, servo)


def stood_at(command: Connect, n: int) -> np.ndarray | None:
    """(n,) as it was kept, of an arm of as many joints."""
    known = command.stood
    return np.array(known) if known is not None and len(known) == n else None


def motion_of(command: FollowRows, n: int) -> MotionUnderWay:
    """Its rows are paged in as they are followed."""
    weight = None if command.weight is None else np.array(command.weight)
    if weight is not None and (weight.shape != (2, n) or not np.isfinite(weight).all()):
        raise ValueError(f"expected what {n} joints weigh at least and at most")
    rows = rows_in(command.rows)
    return MotionUnderWay(command.number, rows, command.first, command.last, weight)
