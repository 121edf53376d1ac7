"""The simulated arm as the virtual drives and the data generator hold it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from backends.virtual.plant.assemble import arm_model, physics_of, true_arm
from backends.virtual.plant.hidden import Hidden, hidden_effects
from backends.virtual.plant.laws import AtWork, catalogue
from backends.virtual.plant.noise import Noise, white_level
from backends.virtual.plant.records import Array
from backends.virtual.plant.run import Log, Servo, advance, follow, look, new_log
from backends.virtual.plant.sensing import HISTORY, Sensing, new_reading, sensing_of
from backends.virtual.plant.state import Physics, figures_of, new_scratch, new_state
from backends.virtual.plant.substeps import longest_substep
from backends.virtual.plant.textbook import Textbook, peak_torques, textbook_of
from backends.virtual.plant.warmth import celsius
from pa10d.common.errors import UserError
from pa10d.profile import Profile

PA10_RESOLUTION = 2.0 * math.pi / 819200  # rad per encoder count


def build(
    profile: Profile,
    *,
    effects: Sequence[Mapping[str, Any]] = (),
    noise: str | Mapping[str, Any] = "white",
    seed: int | None = None,
    dynamics: Mapping[str, Any] | None = None,
    resolution: float | None = None,
    substep: float | None = None,
    torque_gains: Sequence[float] | None = None,
) -> Plant:
    """The plant factory that profiles name.

    effects   what is hidden, see catalogue.py, and laws.py for those of other packages
    noise     none, white, strong or coloured, or {kind, white, slow, corner_hz}; the numbers are
              multiples of 0.5 N·m at a 232 N·m joint, less at smaller ones
    seed      of the noise and, unless dynamics has its own, of the arm; default: the profile's
    dynamics  {spread, seed, rotor_inertia, coulomb, viscous}: spread 0.2 makes an arm whose
              masses are ±20 % of the URDF's, friction and rotors up to e^±0.4 of the defaults
    resolution  rad per encoder count, 0: exact; default: the drives' or the PA10's
    torque_gains  per joint, N·m that the drive commands and reads for one that its motor makes:
              torque constants other than the nameplate's; default: 1
    substep   s; default: 0.5 ms or what the stiffest spring needs
    """
    given = dict(dynamics or {})
    if seed is None:
        seed = profile.simulation.seed if profile.simulation else 0
    known = {"spread", "seed", "rotor_inertia", "coulomb", "viscous"}
    if unknown := set(given) - known:
        raise UserError(
            f"simulation.options.dynamics: unknown {sorted(unknown)[0]!r}, "
            f"expected {', '.join(sorted(known))}"
        )
    model = arm_model(profile)
    spread = float(given.get("spread", 0.0))
    rng = np.random.default_rng([int(given.get("seed", seed)), 7])
    arm = true_arm(profile, model, spread, rng)
    book = textbook_of(peak_torques(model, profile), given, rng)
    hidden = hidden_effects(effects, len(book.effort), catalogue())
    physics = physics_of(arm, book, hidden)
    n = len(book.effort)
    steps = encoder_steps(profile, resolution, book)
    sensing = sensing_of(hidden, n, steps, _gains(torque_gains, n))
    step = substep if substep is not None else longest_substep(physics)
    return Plant(physics, sensing, Noise(noise, white_level(book.effort), seed), book, hidden, step)


def _gains(given: Sequence[float] | None, n: int) -> Array:
    values = [1.0] * n if given is None else given
    good = isinstance(values, list | tuple) and len(values) == n
    if not good or not all(
        isinstance(v, int | float) and not isinstance(v, bool) and 0 < v < math.inf for v in values
    ):
        raise UserError(
            f"simulation.options.torque_gains: found {given!r}, expected {n} numbers above 0, one "
            "per joint"
        )
    return np.array(values, dtype=float)


def encoder_steps(profile: Profile, resolution: float | None, book: Textbook) -> Array:
    """Radians per encoder count, (n,)."""
    n = len(book.effort)
    if resolution is not None:
        return np.full(n, float(resolution))
    if profile.drives is None or len(profile.drives) != n:
        return np.full(n, PA10_RESOLUTION)
    return np.array([2.0 * math.pi / drive.counts_per_rev for drive in profile.drives])


class Plant:
    """Rigid links, rotors, friction that sticks, sensors with errors; see INTERFACES, plants."""

    def __init__(
        self,
        physics: Physics,
        sensing: Sensing,
        noise: Noise,
        textbook: Textbook,
        effects: list[Hidden],
        substep: float,
    ) -> None:
        self.n = len(textbook.effort)
        self.physics, self.sensing, self.textbook = physics, sensing, textbook
        self.effects, self.substep = effects, substep
        self._noise = noise
        self._figures = figures_of(physics, sensing)
        self._scratch = new_scratch(physics)
        self._dt = 0.002
        self.reset(np.zeros(self.n))

    def reset(self, q0: Array) -> None:
        """At rest in pose q0 (n,), rad, everything cold; the noise goes on with a fresh stream."""
        q0 = np.asarray(q0, float)
        if q0.shape != (self.n,):
            raise ValueError(f"q0 has shape {q0.shape}, expected ({self.n},)")
        self.state = new_state(self.physics, q0)
        self._laws = AtWork(self.effects, self.n)
        self._reading = new_reading(self.n)
        self._noise.restart()
        look(self._figures, self.state, self._reading, self._draw(1)[0])

    def step(self, torque: Array, dt: float) -> None:
        """Hold motor torque (n,), N·m at the joint side, for dt seconds."""
        self._expect(dt)
        self._resist(dt)
        advance(
            self._figures, self.state, self._scratch, self._reading,
            np.ascontiguousarray(torque, float), dt, self._substeps(dt), self._draw(1)[0],
        )  # fmt: skip

    def measure(self) -> tuple[Array, Array]:
        """What encoders (rad) and current sensors (N·m) reported last, (n,) each."""
        return self._reading.q.copy(), self._reading.torque.copy()

    def angles(self) -> Array:
        """Where the encoders' axes are, rad, (n,), whatever the encoders tell."""
        joints = self._figures.joints
        angles: Array = self.state.q[joints["rotor"]] + joints["encoder_offset"]
        return angles

    def temperature(self) -> Array:
        """Joint temperatures, °C, (n,)."""
        return celsius(self.physics.warmth, self.state.warm)

    def follow(self, servo: Servo, q: Array, dq: Array, forward: Array, dt: float) -> Log:
        """A whole run in compiled code, the same to the bit as calling step in a loop.

        q, dq, forward (steps, n): reference rad, rad/s and feed-forward torque N·m per sample.
        """
        self._expect(dt)
        log, noise = new_log(*q.shape), self._draw(len(q))
        wanted = [np.ascontiguousarray(x) for x in (q, dq, forward)]
        at_once = 1 if self._laws else len(q)
        for k in range(0, len(q), at_once):
            part = slice(k, k + at_once)
            self._resist(dt)
            follow(
                self._figures, self.state, self._scratch, self._reading, servo,
                *(x[part] for x in wanted), dt, self._substeps(dt), noise[part],
                Log(*(x[part] for x in log)),
            )  # fmt: skip
        return log

    def _resist(self, dt: float) -> None:
        """What laws of other packages do over the next sample."""
        if self._laws:
            n = self.n
            self.state.outside[:] = self._laws.torque(dt, self.state.q[:n], self.state.v[:n])

    def _substeps(self, dt: float) -> int:
        return max(1, math.ceil(dt / self.substep - 1e-9))

    def _draw(self, steps: int) -> Array:
        return self._noise.draw(steps, self._dt)

    def _expect(self, dt: float) -> None:
        self._dt = dt
        longest = float(np.max(self.sensing.delay))
        if longest > (HISTORY - 2) * dt:
            raise UserError(f"torque_delay: {longest} s is more than {HISTORY - 2} samples")
