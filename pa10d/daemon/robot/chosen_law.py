"""The control law that was chosen, which is not always the one that has the arm."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from pa10d.control.told import ArmTold
from pa10d.daemon.processes.link import Message
from pa10d.daemon.robot.refusals import CommandRefused

CHOOSING = ("inactive", "holding")  # states in which control takes another law


class ChosenLaw:
    """``{"name": "pid"}``, or a law with a model ``{"name": …, "model": {live model}}``; model: the
    id under which the whole of it is stored. command: asks control; told: what it last said."""

    def __init__(
        self, command: Callable[..., Awaitable[Message]], told: Callable[[], ArmTold]
    ) -> None:
        self._command, self._told = command, told
        self.controller: Message = {"name": "pid"}
        self.model: str | None = None
        self.lost: str | None = None  # why control has another one

    @property
    def name(self) -> Any:
        """Of the law."""
        return self.controller["name"]

    @property
    def in_force(self) -> bool:
        """Whether control has it."""
        model, told = self.controller.get("model") or {}, self._told()
        return bool((self.name, model.get("name")) == (told.controller, told.model))

    @property
    def model_parameters(self) -> int | None:
        """Of the model that control has."""
        model = (self.controller.get("model") or {}) if self.in_force else {}
        return model.get("parameters")

    async def use(self, controller: Message, model: str | None = None) -> None:
        """From now on; CommandRefused where control does not take it."""
        await self._command("controller", **controller)
        self.controller, self.model, self.lost = controller, model, None

    async def go_back_to(self, controller: Message, model: str | None, state: str) -> None:
        """The law that was there before; where the arm is in fault or away, from its return on."""
        self.controller, self.model = controller, model
        await self.take_up(state)

    async def take_up(self, state: str) -> None:
        """Once control has begun anew or has left a fault, in which the servo alone has the arm;
        where it is refused, the servo keeps it, and a note says why. state: of the arm."""
        if state not in CHOOSING or self.in_force:
            return
        try:
            await self.use(self.controller, self.model)
        except CommandRefused as refusal:
            if "reply" not in refusal.answer or refusal.answer.get("state") not in CHOOSING:
                return  # control or the arm is gone: again when it is back
            lost = f"{self.name} was not taken up again: {refusal}; PID has the arm"
            await self.use({"name": "pid"})
            self.lost = lost
