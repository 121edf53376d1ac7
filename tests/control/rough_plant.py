"""An arm that its URDF describes badly: heavier or lighter, rubbing, springy, wired the wrong way.

Links by Pinocchio's mass matrix and bias forces; each joint has a rotor, rigidly on the link or
behind a spring, dry friction as an impulse that stops the rotor or is used up (time stepping), and
viscous friction. The encoder sits on the rotor. Shares no code with the product.
"""

from __future__ import annotations

import numba
import numpy as np
import pinocchio as pin

SUBSTEP = 1e-3  # s
BODIES = 2e-3  # s for which mass matrix and bias forces are good: a joint turns by 0.7° at most
SWEEPS = 6
RATED = 232.0  # N·m of the joint that the figures below are of
COUNTS = 819200.0  # of the encoder per turn


class RoughPlant:
    """Scales are one number or one per joint: ``inertia`` of the link's own inertia about its
    centre of mass and of the rotor; ``mass`` of masses; ``friction`` of dry and viscous friction.

    rotor: of the rotor's, in place of ``inertia``;
    coulomb, viscous: N·m, N·m·s/rad in place of the usual ones; springs: joint (1-based) → N·m/rad;
    signs: of the torque; lag: s by which a drive's torque follows its command (first order).
    """

    def __init__(
        self, profile, inertia=1.0, mass=1.0, rotor=None, friction=1.0, coulomb=None, viscous=None,
        springs=None, signs=1.0, lag=0.0, noise=1.0, seed=4,
    ):  # fmt: skip
        model = pin.buildModelFromUrdf(str(profile.urdf))
        self.model, self.data, self.n = model, model.createData(), model.nv
        n = self.n
        turn, heavy, rub = (np.broadcast_to(s, n) for s in (inertia, mass, friction))
        for j in range(n):
            body = model.inertias[j + 1]
            model.inertias[j + 1] = pin.Inertia(
                heavy[j] * body.mass, body.lever, turn[j] * np.array(body.inertia)
            )
        size = np.array(profile.limits.torque) / RATED
        self.rotor = (turn if rotor is None else np.broadcast_to(rotor, n)) * 0.75 * size**1.75
        self.dry = rub * (8.0 * size**0.83 if coulomb is None else np.broadcast_to(coulomb, n))
        self.wet = rub * (10.0 * size**0.83 if viscous is None else np.broadcast_to(viscous, n))
        self.level = noise * 0.2 * size**0.7
        self.signs, self.lag = np.broadcast_to(np.asarray(signs, float), n), lag
        springs = {int(j) - 1: float(k) for j, k in (springs or {}).items()}
        self.bent = np.array(sorted(springs), dtype=np.int64)
        self.stiffness = np.array([springs[j] for j in self.bent])
        # a rotor on its spring swings with 3 % of critical damping
        self.loss = 2 * 0.03 * np.sqrt(self.stiffness * self.rotor[self.bent])
        self.at = np.arange(n)  # which coordinate carries a joint's rotor
        self.at[self.bent] = n + np.arange(len(self.bent))
        self.rng = np.random.default_rng(seed)
        self.reset(np.zeros(n))

    def reset(self, q0):
        """At rest, springs wound up by gravity."""
        q0 = np.array(q0, float)
        self.q = np.concatenate([q0, q0[self.bent]])
        if len(self.bent):
            for _ in range(3):
                load = pin.computeGeneralizedGravity(self.model, self.data, self.q[: self.n])
                self.q[self.bent] = q0[self.bent] - load[self.bent] / self.stiffness
        self.v = np.zeros(len(self.q))
        self.sent = self.felt = np.zeros(self.n)

    def step(self, torque, dt):
        self.sent = np.asarray(torque, float)
        count = max(1, round(dt / SUBSTEP))
        h, n = dt / count, self.n
        share = 1.0 if self.lag <= 0 else 1.0 - np.exp(-h / self.lag)
        each = max(1, round(BODIES / h))
        for k in range(count):
            self.felt = self.felt + share * (self.sent - self.felt)
            angle, speed = self.q[:n], self.v[:n]
            if k % each == 0:
                mass = pin.crba(self.model, self.data, angle)
                bias = pin.nonLinearEffects(self.model, self.data, angle, speed)
            self.v = _advance(
                mass, bias, self.q, self.v, self.signs * self.felt, self.rotor, self.at,
                self.bent, self.stiffness, self.loss, self.dry, self.wet, h,
            )  # fmt: skip
            self.q = self.q + h * self.v

    def mass_at(self, angle):
        """(n, n) kg·m² of the links."""
        half = np.triu(pin.crba(self.model, self.data, np.asarray(angle, float)))
        return half + np.triu(half, 1).T

    def measure(self):
        shown = np.round(self.q[self.at] * COUNTS / (2 * np.pi)) * 2 * np.pi / COUNTS
        return shown, self.felt + self.level * self.rng.standard_normal(self.n)


@numba.njit(cache=True)
def _advance(mass, bias, q, v, torque, rotor, at, bent, stiffness, loss, dry, wet, h):
    n, size = len(rotor), len(q)
    whole, force = np.zeros((size, size)), np.zeros(size)
    for i in range(n):
        for j in range(i, n):
            whole[i, j] = whole[j, i] = mass[i, j]
        force[i] = -bias[i]
    for j in range(n):
        whole[at[j], at[j]] += rotor[j] + h * wet[j]  # implicit: any friction is stable
        force[at[j]] += torque[j] - wet[j] * v[at[j]]
    for k in range(len(bent)):
        i, j = bent[k], n + k
        give, twist = h * loss[k] + h * h * stiffness[k], q[j] - q[i] + h * (v[j] - v[i])
        pull = stiffness[k] * twist + loss[k] * (v[j] - v[i])
        force[i] += pull
        force[j] -= pull
        whole[i, i] += give
        whole[j, j] += give
        whole[i, j] -= give
        whole[j, i] -= give
    back = np.linalg.inv(whole)
    speed = v + h * (back @ force)
    impulse = np.zeros(n)
    for _ in range(SWEEPS):
        for j in range(n):
            k = at[j]
            asked = impulse[j] - speed[k] / back[k, k]
            wanted = min(max(asked, -h * dry[j]), h * dry[j])
            speed += back[:, k] * (wanted - impulse[j])
            impulse[j] = wanted
    return speed


def make(profile, **options):
    """The factory that a profile names."""
    return RoughPlant(profile, **options)
