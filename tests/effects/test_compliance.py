"""Series spring and gap against closed forms, an ODE solver, and links moved by Pinocchio."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from effect_motions import (
    DT,
    alone,
    arm_context,
    columns,
    context_of,
    flywheel,
    pa10,
    pinocchio_model,
    pinocchio_torque,
    rms,
    wandering,
)
from scipy.integrate import solve_ivp

from pa10d.effects import all_effects
from pa10d.effects.library.backlash import CONTACT_DAMPING, CONTACT_HZ

J = 3  # 0-based: the elbow
EFFECTS = all_effects()


@pytest.mark.long
@pytest.mark.parametrize("hertz", [1.0, 4.0, 7.0, 12.0])
def test_harmonic_response_of_a_flywheel_on_a_spring(hertz):
    """Δτ = -J·δ̈ with δ = J·q̈/(K - J·ω² + iωC), once the start has died away."""
    inertia, stiffness, zeta = 1.2, 2000.0, 0.1  # resonance at 6.5 Hz
    omega = 2 * np.pi * hertz

    def swing(t):
        return tuple(
            (omega**d * 0.01 * np.sin(omega * t + d * np.pi / 2))[:, None] for d in range(3)
        )

    context = context_of(flywheel(), swing, seconds=10.0)
    found = columns("joint_elasticity", context, 0, K=stiffness, zeta=zeta)[:, 0, 0]
    damping = 2 * zeta * np.sqrt(stiffness * inertia)
    push = inertia * -(omega**2) * 0.01
    delta = push / (stiffness - inertia * omega**2 + 1j * omega * damping)
    exact = np.imag(inertia * omega**2 * delta * np.exp(1j * omega * context.t))
    late = context.t > 6.0
    assert rms((found - exact)[late]) < 0.03 * rms(exact[late])


@pytest.mark.parametrize("hertz", [2.0, 9.0, 12.0])
def test_a_rotor_that_a_rigid_model_counts_to_its_link_stays_on_the_motor(hertz):
    """Of the inertia J only J - Ir swings: δ = (J - Ir)·q̈/(K - (J - Ir)·ω² + iωC)."""
    inertia, rotor, stiffness, zeta = 1.2, 0.7, 2000.0, 0.1  # resonance at 10 Hz instead of 6.5
    omega, link = 2 * np.pi * hertz, inertia - rotor

    def swing(t):
        return tuple(
            (omega**d * 0.01 * np.sin(omega * t + d * np.pi / 2))[:, None] for d in range(3)
        )

    context = context_of(flywheel(), swing, seconds=10.0)
    shape = {"K": stiffness, "zeta": zeta, "rotor": rotor}
    found = columns("joint_elasticity", context, 0, **shape)[:, 0, 0]
    damping = 2 * zeta * np.sqrt(stiffness * link)
    delta = link * -(omega**2) * 0.01 / (stiffness - link * omega**2 + 1j * omega * damping)
    exact = np.imag(link * omega**2 * delta * np.exp(1j * omega * context.t))
    late = context.t > 6.0
    assert rms((found - exact)[late]) < 0.03 * rms(exact[late])


def test_the_search_for_a_rotor_begins_only_where_the_model_does_not_know_it():
    kinds = [EFFECTS[name] for name in ("joint_elasticity", "backlash")]
    context = replace(arm_context(seconds=1.0), rotor_in_load=(0, 1))
    for kind in kinds:
        assert {"rotor" in s for s in kind.starts(context, [0])} == {True}
        assert {"rotor" in s for s in kind.starts(context, [J])} == {False}


@pytest.mark.by_default("joint_elasticity-shape1")
@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("joint_elasticity", {"K": 3e3, "zeta": 0.05}),
        ("joint_elasticity", {"K": 120.0, "zeta": 0.15}),  # wound by 0.2 rad, in the motion's band
        ("backlash", {"b": 3e-3}),
    ],
)
def test_against_links_moved_by_pinocchio(name, shape):
    """The elbow's link hangs on its transmission; all motors follow their angles exactly."""
    motion, model, data = wandering(7, seed=1), pinocchio_model(pa10()), None
    data = model.createData()
    context = context_of(pa10(), motion, seconds=4.0)
    inertia = context.typical_inertia[J]
    if name == "backlash":
        stiffness, gap = inertia * (2 * np.pi * CONTACT_HZ) ** 2, shape["b"]
        damping = 2 * CONTACT_DAMPING * np.sqrt(stiffness * inertia)
    else:
        stiffness, gap = shape["K"], 0.0
        damping = 2 * shape["zeta"] * np.sqrt(stiffness * inertia)

    def link(t, delta, rate):
        """Links' motion without δ̈, the load that it means for the elbow, and M_jj."""
        moved = [row[0] for row in motion(np.array([t]))]
        moved[0][J] -= delta
        moved[1][J] -= rate
        return moved, pin.rnea(model, data, *moved)[J], pin.crba(model, data, moved[0])[J, J]

    def acceleration(t, delta, rate):
        _, load, mass = link(t, delta, rate)
        side = np.sign(delta)
        passed = stiffness * (delta - side * gap) + damping * rate
        if abs(delta) <= gap or (gap > 0 and passed * side < 0):
            passed = 0.0
        return (load - passed) / mass

    first = link(0.0, 0.0, 0.0)[1]
    start = [first / stiffness + np.sign(first) * gap, 0.0]
    far = abs(start[0]) > 0.02
    if far:  # as it hangs there
        start, q = [0.0, 0.0], motion(np.zeros(1))[0][0]
        for _ in range(50):
            hanging = q - start[0] * np.eye(7)[J]
            start[0] = pin.rnea(model, data, hanging, 0 * q, 0 * q)[J] / stiffness
    found = solve_ivp(
        lambda t, y: [y[1], acceleration(t, *y)],
        (0, context.t[-1]),
        start,
        t_eval=context.t,
        rtol=1e-6,
        atol=1e-9,
        max_step=DT,
    )
    moved = [np.array(x) for x in (context.q, context.dq, context.ddq)]
    moved[0][:, J] -= found.y[0]
    moved[1][:, J] -= found.y[1]
    moved[2][:, J] -= [acceleration(t, *y) for t, y in zip(context.t, found.y.T, strict=True)]
    exact = pinocchio_torque(model, *moved) - pinocchio_torque(
        model, context.q, context.dq, context.ddq
    )
    effect = columns(name, context, J, **shape)[..., 0]
    size = max(rms(exact[:, j]) for j in range(7))
    assert size > 0.02
    for j in range(7):
        assert rms(effect[:, j] - exact[:, j]) < 0.03 * size


def test_at_rest_the_link_sags_by_load_over_stiffness():
    still = np.zeros(800)
    context = alone(1, np.full(800, 0.7), still, still)
    found = columns("joint_elasticity", context, 1, K=4e4, zeta=0.3)[-1, :, 0]
    model = pinocchio_model(pa10())
    q = context.q[:1].copy()
    straight = pinocchio_torque(model, q, 0 * q, 0 * q)[0]
    sag = 0.0
    for _ in range(50):
        bent = q.copy()
        bent[0, 1] -= sag
        torque = pinocchio_torque(model, bent, 0 * q, 0 * q)[0]
        sag = torque[1] / 4e4
    assert found == pytest.approx(torque - straight, rel=0.02, abs=1e-6)
    assert abs(found[1]) > 1e-3


def test_a_hard_spring_and_a_closed_gap_are_a_rigid_joint():
    context = arm_context(seed=1, seconds=3.0)
    soft = columns("joint_elasticity", context, J, K=2e3, zeta=0.1)
    hard = columns("joint_elasticity", context, J, K=1e7, zeta=0.7)
    assert rms(hard) < 0.01 * rms(soft)


def test_across_the_gap_no_torque_passes():
    """Transmitted torque = rigid load + Δτ of the joint itself: zero for as long as it crosses."""
    t = np.arange(0.0, 8.0, DT)
    w = 2 * np.pi * 0.25
    context = alone(1, *(0.1 * w**d * np.sin(w * t + d * np.pi / 2) for d in range(3)))
    # upright, so that gravity changes sides
    q = context.q.copy()
    q[:, [0, 2, 3, 4, 5, 6]] = 0.0
    still = type(context)(
        context.robot, t, q, context.dq, context.ddq, context.rigid, np.zeros_like(q)
    )
    load = still.load[:, 1]
    passed = load + columns("backlash", still, 1, b=0.02)[:, 1, 0]
    free = np.abs(passed) < 0.02 * np.max(np.abs(load))
    tight = np.abs(load) < 0.02 * np.max(np.abs(load))
    assert np.count_nonzero(free) > 2 * np.count_nonzero(tight)
    assert np.max(np.abs(load[free])) > 0.1 * np.max(np.abs(load))
