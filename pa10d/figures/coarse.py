"""A mesh with no more triangles than can be seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triangles = NDArray[np.uint32]

FINEST, COARSEST = 256, 4  # cells along the longest side of the body


def coarser(vertices: Array, triangles: Triangles, most: int) -> tuple[Array, Triangles]:
    """vertices (v, 3) m, triangles (t, 3): the vertices of a grid's cell become their mean, and
    what falls into a line is dropped, until at most ``most`` triangles are left (Rossignac and
    Borrel 1993). A body that has no more comes back as it is."""
    cells = FINEST
    left = triangles
    points = vertices
    while len(left) > most and cells >= COARSEST:
        points, left = _clustered(vertices, triangles, cells)
        cells = cells * 3 // 4
    return points, left


def _clustered(vertices: Array, triangles: Triangles, cells: int) -> tuple[Array, Triangles]:
    low = vertices.min(axis=0)
    size = float((vertices.max(axis=0) - low).max()) or 1.0
    place = np.floor((vertices - low) / size * cells).astype(np.int64)
    key = (place[:, 0] * (cells + 1) + place[:, 1]) * (cells + 1) + place[:, 2]
    _, member, count = np.unique(key, return_inverse=True, return_counts=True)
    means = np.column_stack([np.bincount(member, vertices[:, k]) for k in range(3)])
    kept = member[triangles]
    whole = (kept[:, 0] != kept[:, 1]) & (kept[:, 1] != kept[:, 2]) & (kept[:, 0] != kept[:, 2])
    return means / count[:, None], kept[whole].astype(np.uint32)
