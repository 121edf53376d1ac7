"""Joints of many samples side by side, for kernels that work on LANES of them at once.

Every helper is one loop over the lanes that writes to one array, which the compiler turns into
vector instructions (it gives up where more arrays might overlap). No helper unpacks an array as a
whole: its length would be checked, and each call with it.

Compiled kernels are kept by the file that they stand in: who changes this one touches those that
import it.
"""

from __future__ import annotations

import numba
import numpy as np

LANES = 64  # samples that are worked on at once: what a joint needs of them fits the nearest cache


@numba.njit(cache=True, nogil=True)
def turning(fixed, axis, prismatic, out, ahead):
    """A joint's rotation, column by column (c, 3, 3): what stays, what goes with the cosine and
    what with the sine of its angle (Rodrigues); and its axis in the parent's frame."""
    for r in range(3):
        u, v, w = fixed[r, 0], fixed[r, 1], fixed[r, 2]
        x, y, z = axis[0], axis[1], axis[2]
        along = u * x + v * y + w * z
        ahead[r] = along
        across = (v * z - w * y, w * x - u * z, u * y - v * x)
        for c in range(3):
            out[c, 0, r] = fixed[r, c] if prismatic else along * axis[c]
            out[c, 1, r] = 0.0 if prismatic else fixed[r, c] - along * axis[c]
            out[c, 2, r] = 0.0 if prismatic else across[c]


@numba.njit(cache=True, nogil=True)
def read_joint(q, dq, ddq, start, lanes, j, prismatic, out):
    """A joint's cosine, sine, slide, rate and acceleration."""
    for k in range(lanes):
        out[3, k], out[4, k] = dq[start + k, j], ddq[start + k, j]
        angle = q[start + k, j]
        if prismatic:
            out[0, k], out[1, k], out[2, k] = 0.0, 0.0, angle
        else:
            out[0, k], out[1, k], out[2, k] = np.cos(angle), np.sin(angle), 0.0


@numba.njit(cache=True, nogil=True)
def column(turning, joint, lanes, out):
    """One column of a joint's rotation."""
    a, b, c = turning[0, 0], turning[0, 1], turning[0, 2]
    d, e, f = turning[1, 0], turning[1, 1], turning[1, 2]
    g, h, i = turning[2, 0], turning[2, 1], turning[2, 2]
    for k in range(lanes):
        cosine, sine = joint[0, k], joint[1, k]
        out[0, k] = a + cosine * d + sine * g
        out[1, k] = b + cosine * e + sine * h
        out[2, k] = c + cosine * f + sine * i


@numba.njit(cache=True, nogil=True)
def arm(offset, ahead, joint, lanes, out):
    """From the parent's origin to the link's, in the parent's frame."""
    a, b, c = offset[0], offset[1], offset[2]
    x, y, z = ahead[0], ahead[1], ahead[2]
    for k in range(lanes):
        slide = joint[2, k]
        out[0, k], out[1, k], out[2, k] = a + x * slide, b + y * slide, c + z * slide
