"""What the tests share: a mesh, and brute-force checks that know nothing of the library.

The environment says where things are: PYTHONPATH the package, PTET_CLI the program, PTET_CUT the program made of cut.c.
"""
import functools
import gc
import pathlib
import sys

sys.dont_write_bytecode = True  # leaves the source tree as it is
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))

import numpy as np  # noqa: E402
import meshes  # noqa: E402
import ptet  # noqa: E402

UNIT = 8  # cells along an edge of the cube


@functools.lru_cache(maxsize=None)
def cube(n=UNIT):
    """points (float32), tets (int64) and fields of the unit cube in n^3 cells: smooth, bumpy, a vector, numbers that do
    not govern."""
    points, tets = meshes.grid(n)
    points = np.array(points, np.float32)
    x, y, z = points.T.astype(np.float64)
    fields = {
        "t": (np.sin(4 * x) * y + z).astype(np.float32),
        "flow": np.stack([y - 0.5, 0.5 - x, z * z], axis=1),
        "number": np.arange(len(points), dtype=np.uint16),
    }
    return points, np.array(tets, np.int64), fields


@functools.lru_cache(maxsize=None)
def built(n=UNIT):
    """The bytes of the cube's file."""
    return bytes(ptet.build(*cube(n)).data)


def volumes(points, tets):
    """Six times the signed volume of each tet."""
    a, b, c, d = (points[tets[:, i]].astype(np.float64) for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)


def rows_as_set(rows):
    return {tuple(row) for row in np.sort(np.asarray(rows, np.int64), axis=1).tolist()}


def check_mesh(case, points, tets, boundary_faces, volume=1.0):
    """A conforming mesh of the unit cube, and its boundary turned outward."""
    case.assertLess(int(tets.max()), len(points))
    case.assertGreater(volumes(points, tets).min(), 0)
    case.assertAlmostEqual(volumes(points, tets).sum() / 6, volume, places=5)
    # Faces of a positive tet, seen counter-clockwise from outside it.
    faces = np.concatenate([tets[:, list(corners)] for corners in ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))])
    key, inverse, count = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    case.assertLessEqual(count.max(), 2)
    case.assertEqual(len(key), len(rows_as_set(faces)))
    once = faces[count[np.ravel(inverse)] == 1]

    def turned(rows):  # the least corner first, the sense kept
        first = np.argmin(rows, axis=1)
        return {tuple(np.roll(row, -at).tolist()) for row, at in zip(rows.astype(np.int64), first)}

    case.assertEqual(turned(once), turned(boundary_faces))


def largest_error(points, tets, values, at, wanted):
    """Largest difference at the points `at` between the mesh's field and the values wanted there; every point must lie
    in some tet."""
    corners = points[tets].astype(np.float64)
    matrix = np.linalg.inv(np.transpose(corners[:, 1:] - corners[:, :1], (0, 2, 1)))
    values = values.reshape(len(points), -1).astype(np.float64)
    wanted = wanted.reshape(len(at), -1)
    worst = 0.0
    for point, value in zip(at.astype(np.float64), wanted):
        weights = np.einsum("tij,tj->ti", matrix, point - corners[:, 0])
        weights = np.concatenate([1 - weights.sum(axis=1, keepdims=True), weights], axis=1)
        tet = int(np.argmax(weights.min(axis=1)))
        if weights[tet].min() < -1e-6:
            raise AssertionError(f"no tet holds {point}")
        worst = max(worst, float(np.linalg.norm(weights[tet] @ values[tets[tet]] - value)))
    return worst


def resident_bytes():
    gc.collect()
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096
