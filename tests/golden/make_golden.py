#!/usr/bin/env python3
"""Builds the golden .ptet files of this folder anew: make_golden.py PTET [FOLDER], with the data folder in PTET_DATA.

Files of a released version stay as they are and are read for ever, so this is for files of a version that is not
released yet, and for new ones. The inputs are made here but for real.ptet, a corner of fire_ug.vtu (the temperature and
velocities of a fire in a room).
"""
import itertools
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE.parent / "cli"))
import meshes  # noqa: E402


def carve(n, keep):
    """The unit cube's grid of n x n x n cells, without those of which keep(x, y, z of the centre) is false."""
    points, tets = meshes.grid(n)
    kept = [t for i, t in enumerate(tets)
            if keep(*((c + 0.5) / n for c in (i // 6 // n // n, i // 6 // n % n, i // 6 % n)))]
    return renumber(points, kept)


def renumber(points, tets):
    used = {v: i for i, v in enumerate(sorted({v for tet in tets for v in tet}))}
    return [points[v] for v in used], [[used[v] for v in tet] for tet in tets]


def join(*parts):
    points, tets = [], []
    for more, others in parts:
        tets += [[v + len(points) for v in tet] for tet in others]
        points += more
    return points, tets


def weld(points, tets):
    first = {}
    names = [first.setdefault(point, i) for i, point in enumerate(points)]
    return renumber(points, [[names[v] for v in tet] for tet in tets])


def bend(points):
    """Away from the grid, so that hardly two coordinates are the same."""
    return [(x + 0.07 * math.sin(3 * y + z), y * (1 + 0.1 * math.cos(2 * x)), z + 0.05 * x * y * math.exp(z))
            for x, y, z in points]


def single(values):
    return np.asarray(values, dtype="f4").tolist()


def tiny():
    points, tets = meshes.grid(2)
    return points, tets, {"f": ("Float32", single([x + 2 * y * z for x, y, z in points]))}


def fields():
    """Every type, vectors, more than four components, decimal numbers, floats whose lowest bits are 0, and values that are not finite."""
    points, tets = meshes.grid(4)
    number = range(len(points))
    wave = [math.sin(5 * x) * math.cos(4 * y) + z * z for x, y, z in points]
    fields = {
        "wave": ("Float32", single(wave)),
        "flow": ("Float32", [tuple(single((y - z, math.sin(6 * x) + z, x * y))) for x, y, z in points]),
        "price": ("Float64", [round(10 * w, 2) for w in wave]),
        "stress": ("Float64", [tuple(w * (i + 1) + x**i for i in range(6)) for w, (x, _, _) in zip(wave, points)]),
        "narrow": ("Float64", [1 / 3 if i == 50 else w if i % 2 else -w for i, w in zip(number, single(wave))]),
        "coarse": ("Float32", [round(37 * w) / 64 for w in wave]),
        "holes": ("Float32", [float("nan") if i % 7 == 3 else float("inf") if i % 11 == 5 else -0.0 if i % 5 == 0
                              else w for i, w in zip(number, single(wave))]),
    }
    for bits in (8, 16, 32, 64):
        most = 2**(bits - 1) - 1
        fields[f"int{bits}"] = (f"Int{bits}", [int(np.clip(w / 3, -1, 1) * most * 0.999) for w in wave])
        fields[f"uint{bits}"] = (f"UInt{bits}", [2 * most + 1 - i * (most // 200 + 1) % most for i in number])
    return points, tets, fields


def double():
    points, tets = meshes.grid(5)
    points = bend(points)
    return points, tets, {"density": ("Float64", [math.exp(x - y * y) * math.sin(7 * z) for x, y, z in points])}


def pinched():
    """Cubes that share an edge, cubes that share a vertex, one apart, and points of no tet."""
    points, tets = weld(*join(meshes.grid(3), meshes.grid(3, (1.0, 1.0, 0.0)), meshes.grid(2, (2.0, 2.0, 1.0)),
                              meshes.grid(2, (4.0, 0.0, 0.0))))
    points = [(-1.0, -1.0, 0.5)] + points + [(9.0, 9.0, 9.0), (0.1, 0.2, 0.3)]
    tets = [[v + 1 for v in tet] for tet in tets]
    return points, tets, {"f": ("Float32", single([x * x - y * z for x, y, z in points]))}


def sheets(n=6):
    """Two waved sheets of one layer of cells, a small gap apart, joined along one side: the boundaries of different
    levels would cross, so there are records with other parents."""
    points, tets = carve(n, lambda x, y, z: z * n < 3 and (x * n < 1 or int(z * n) != 1))
    height = (0, 2, 3, 5)
    points = [(10 * n * x + 2 * math.sin(30 * n * x + 10 * n * y), 10 * n * y + 2 * math.sin(10 * n * x - 20 * n * y),
               height[round(n * z)] + 20 * math.sin(n * x / 2) * math.cos(n * y / 2.6)) for x, y, z in points]
    return points, tets, {"f": ("Float64", [x * y + z for x, y, z in points])}


def ordered():
    """Points and cells in an order that is nobody's, corners in any, some cells inverted, points of no cell: all of that
    is kept."""
    points, tets = meshes.grid(3)
    points = [(5.0, 5.0, 5.0)] + points[::-1] + [(-1.0, 2.0, 0.5)]
    orders = list(itertools.permutations(range(4)))
    tets = [[len(points) - 2 - tets[i * 37 % len(tets)][k] for k in orders[i * 7 % 24]] for i in range(len(tets))]
    return points, tets, {"f": ("Float64", [x + math.sin(4 * y) * z for x, y, z in points])}


def real(ptet, work):
    """What lies around the fire in fire_ug, its hexahedra split as ptet does."""
    source = pathlib.Path(os.environ["PTET_DATA"], "fire_ug.vtu").resolve()
    subprocess.run([ptet, "build", source, "-o", "whole.ptet", "-q", "--method", "QN"], cwd=work, check=True)
    subprocess.run([ptet, "extract", "whole.ptet", "-o", "whole.vtu"], cwd=work, check=True, stdout=subprocess.DEVNULL)
    positions, arrays, tets = meshes.read_vtu(pathlib.Path(work, "whole.vtu"))
    centres = positions[tets].mean(axis=1)
    near = tets[np.linalg.norm(centres - (0.2, 1.75, 0.25), axis=1) < 0.9]
    points, near = renumber(list(range(len(positions))), near.tolist())
    return (positions[points].tolist(), near,
            {name: ("Float32", list(map(tuple, values[points].reshape(len(points), -1).tolist())))
             for name, values in arrays.items()})


GOLDEN = {  # how the mesh is made, the type of its positions, and the options of ptet build
    "tiny": (tiny, "Float32", []),
    "fields": (fields, "Float32", ["--field", "wave", "--field", "flow"]),
    "double": (double, "Float64", []),
    "no_squared_errors": (double, "Float64", ["--method", "QN", "--evaluate", "vertices"]),
    "pinched": (pinched, "Float32", []),
    "sheets": (sheets, "Float64", ["--max-domain-error", "100%"]),
    "ordered": (ordered, "Float64", ["--keep-order"]),
    "real": (real, "Float32", ["--field", "t", "--field", "speed", "--max-domain-error", "20%"]),
}


def main():
    ptet = pathlib.Path(sys.argv[1]).resolve()
    folder = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else HERE).resolve()
    for name, (make, precision, options) in GOLDEN.items():
        with tempfile.TemporaryDirectory() as work:
            points, tets, arrays = make(ptet, work) if make is real else make()
            meshes.vtu(pathlib.Path(work, name + ".vtu"), points, tets, arrays, precision=precision)
            subprocess.run([ptet, "build", name + ".vtu", "-o", folder / (name + ".ptet"), "--quiet",
                            "--target-vertices", "5%", *options], cwd=work, check=True)


if __name__ == "__main__":
    main()
