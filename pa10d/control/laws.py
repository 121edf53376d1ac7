"""The laws by which an arm is held and moved, by name."""

from __future__ import annotations

from typing import Literal, get_args

ModelLaw = Literal["feed_forward", "computed_torque"]
Law = Literal["pid", ModelLaw]

WITH_MODEL: tuple[ModelLaw, ...] = get_args(ModelLaw)
"""Those that take a model, from the one that asks least of a controller."""

LAWS: tuple[Law, ...] = get_args(Law)
