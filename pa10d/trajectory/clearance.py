"""Distances between the capsules of a moving arm, compiled: the inner loop of every check."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def _frames(q, parent, order, fixed, offset, axis, prismatic, rot, pos):
    turn, above = np.empty((3, 3)), np.empty((3, 3))
    for j in order:
        p = parent[j]
        x, y, z = axis[j]
        if prismatic[j]:
            turn[:] = 0.0
            for k in range(3):
                turn[k, k] = 1.0
        else:
            c, s = np.cos(q[j]), np.sin(q[j])
            t = 1.0 - c
            turn[0, 0], turn[0, 1], turn[0, 2] = t * x * x + c, t * x * y - s * z, t * x * z + s * y
            turn[1, 0], turn[1, 1], turn[1, 2] = t * x * y + s * z, t * y * y + c, t * y * z - s * x
            turn[2, 0], turn[2, 1], turn[2, 2] = t * x * z - s * y, t * y * z + s * x, t * z * z + c
        for i in range(3):
            pos[j, i] = offset[j, i] if p < 0 else pos[p, i]
            for k in range(3):
                value = 0.0
                if p < 0:
                    value = fixed[j, i, k]
                else:
                    pos[j, i] += rot[p, i, k] * offset[j, k]
                    for m in range(3):
                        value += rot[p, i, m] * fixed[j, m, k]
                above[i, k] = value
        if prismatic[j]:
            for i in range(3):
                for k in range(3):
                    pos[j, i] += above[i, k] * axis[j, k] * q[j]
        for i in range(3):
            for k in range(3):
                rot[j, i, k] = (
                    above[i, 0] * turn[0, k] + above[i, 1] * turn[1, k] + above[i, 2] * turn[2, k]
                )


@numba.njit(cache=True)
def origins(q, parent, order, fixed, offset, axis, prismatic, out):
    """Where each joint stands, m in the base frame, for each pose: (N, n, 3)."""
    samples, n = q.shape
    rot = np.empty((n, 3, 3))
    for s in range(samples):
        _frames(q[s], parent, order, fixed, offset, axis, prismatic, rot, out[s])


@numba.njit(cache=True)
def _between(p1, q1, p2, q2):
    """Distance of two segments (Ericson, Real-Time Collision Detection, 5.1.9)."""
    a = e = f = c = b = 0.0
    for k in range(3):
        d1, d2, r = q1[k] - p1[k], q2[k] - p2[k], p1[k] - p2[k]
        a += d1 * d1
        e += d2 * d2
        f += d2 * r
        c += d1 * r
        b += d1 * d2
    denominator = a * e - b * b
    s = min(max((b * f - c * e) / denominator, 0.0), 1.0) if denominator > 1e-12 * a * e else 0.0
    t = (b * s + f) / e
    if t < 0.0:
        t = 0.0
        s = min(max(-c / a, 0.0), 1.0)
    elif t > 1.0:
        t = 1.0
        s = min(max((b - c) / a, 0.0), 1.0)
    total = 0.0
    for k in range(3):
        gap = p1[k] + s * (q1[k] - p1[k]) - p2[k] - t * (q2[k] - p2[k])
        total += gap * gap
    return np.sqrt(total)


@numba.njit(cache=True)
def _from_box(p, q, box):
    """Distance of a segment from a solid box: rows centre, half lengths, and its three axes.

    The squared distance is convex along the segment: its slope is bisected."""
    at, way = np.empty(3), np.empty(3)
    for i in range(3):
        at[i] = way[i] = 0.0
        for k in range(3):
            at[i] += box[2 + i, k] * (p[k] - box[0, k])
            way[i] += box[2 + i, k] * (q[k] - p[k])
    low, high = 0.0, 1.0
    if _slope(at, way, box[1], 1.0) <= 0.0:
        low = 1.0
    if _slope(at, way, box[1], 0.0) >= 0.0:
        high = 0.0
    for _ in range(40):
        if low >= high:
            break
        middle = 0.5 * (low + high)
        if _slope(at, way, box[1], middle) > 0.0:
            high = middle
        else:
            low = middle
    total = 0.0
    for i in range(3):
        outside = max(abs(at[i] + min(low, high) * way[i]) - box[1, i], 0.0)
        total += outside * outside
    return np.sqrt(total)


@numba.njit(cache=True)
def _slope(at, way, half, share):
    slope = 0.0
    for i in range(3):
        x = at[i] + share * way[i]
        slope += way[i] * (x - min(max(x, -half[i]), half[i]))
    return slope


@numba.njit(cache=True)
def measure(
    q, parent, order, fixed, offset, axis, prismatic, link, start, end, radius,
    pairs, grounded, floor, blocked, boxes, out,
):  # fmt: skip
    samples, n = q.shape
    rot, pos = np.empty((n, 3, 3)), np.empty((n, 3))
    ends = np.empty((len(link), 2, 3))
    for s in range(samples):
        _frames(q[s], parent, order, fixed, offset, axis, prismatic, rot, pos)
        for c in range(len(link)):
            j = link[c]
            for i in range(3):
                if j < 0:
                    ends[c, 0, i] = start[c, i]
                    ends[c, 1, i] = end[c, i]
                else:
                    ends[c, 0, i] = pos[j, i]
                    ends[c, 1, i] = pos[j, i]
                    for k in range(3):
                        ends[c, 0, i] += rot[j, i, k] * start[c, k]
                        ends[c, 1, i] += rot[j, i, k] * end[c, k]
        for m in range(len(pairs)):
            a, b = pairs[m, 0], pairs[m, 1]
            gap = _between(ends[a, 0], ends[a, 1], ends[b, 0], ends[b, 1])
            out[s, m] = gap - radius[a] - radius[b]
        for m in range(len(grounded)):
            c = grounded[m]
            low = min(ends[c, 0, 2], ends[c, 1, 2])
            out[s, len(pairs) + m] = low - radius[c] - floor
        for m in range(len(blocked)):
            c = blocked[m, 0]
            gap = _from_box(ends[c, 0], ends[c, 1], boxes[blocked[m, 1]])
            out[s, len(pairs) + len(grounded) + m] = gap - radius[c]
