"""What a focus costs: the tets of an answer against those that nobody could do without.

  least = original tets that meet the box + tets of the background mesh that do not

Usage: focus.py --ptet build/ptet [--boxes N] [--seed N] FILE.ptet ...

For boxes of 1%, 5% and 20% of the volume of the bounding box, placed at random where the mesh is, and backgrounds of 20%
and of 5% of the vertices (an error bound whose mesh has so many), it prints answer / least: the geometric mean over the
boxes, and over the meshes. It runs the program and reads the meshes that it writes; needs numpy and VTK's Python module.
"""
import argparse
import json
import math
import pathlib
import random
import subprocess
import tempfile

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

SIZES = [0.01, 0.05, 0.20]  # of the volume of the bounding box
BACKGROUNDS = [0.20, 0.05]  # of the vertices


def extract(ptet, file, *options):
    done = subprocess.run([ptet, "extract", file, "--json", *options], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def corners(path):
    """The corners of each tet: tets x 4 x 3."""
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    mesh = reader.GetOutput()
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    return points[vtk_to_numpy(mesh.GetCells().GetConnectivityArray()).reshape(-1, 4)]


def meet(tets, low, high):
    """Which tets meet the box, by separating axes: those of the box, the tet's faces, and pairs of their edges."""
    apart = (tets.min(axis=1) > high).any(axis=1) | (tets.max(axis=1) < low).any(axis=1)
    near = numpy.flatnonzero(~apart)
    tets = tets[near]
    inside = numpy.ones(len(tets), dtype=bool)
    centre, half = (low + high) / 2, (high - low) / 2
    pairs = [(i, j) for i in range(4) for j in range(i + 1, 4)]
    edges = [tets[:, j] - tets[:, i] for i, j in pairs]
    axes = [numpy.cross(edges[a], edges[b]) for a, b in [(0, 1), (0, 2), (1, 2), (3, 4)]]
    axes += [numpy.cross(edge, axis) for edge in edges for axis in numpy.eye(3)]
    for axis in axes:
        at = ((tets - centre) * axis[:, None, :]).sum(axis=2)
        reach = (numpy.abs(axis) * half).sum(axis=1)
        inside &= ~((at.min(axis=1) > reach) | (at.max(axis=1) < -reach))
    found = numpy.zeros(len(apart), dtype=bool)
    found[near[inside]] = True
    return found


def background(ptet, file, share):
    """The bound on all errors, in percent of their scales, whose mesh has at most that share of the vertices."""
    vertices = json.loads(subprocess.run([ptet, "info", file, "--json"], stdout=subprocess.PIPE,
                                         check=True).stdout)["vertices"]
    fine, coarse = 1e-6, 1000.0
    while coarse / fine > 1.02:
        middle = math.sqrt(fine * coarse)
        if extract(ptet, file, *bounds(middle))["vertices"] > share * vertices:
            fine = middle
        else:
            coarse = middle
    return coarse


def bounds(percent):
    return ["--field-error", f"{percent!r}%", "--domain-error", f"{percent!r}%"]


def cost(ptet, file, boxes, seed, folder):
    """Rows of background, share of the volume, geometric mean and greatest of answer / least."""
    path = folder / "mesh.vtu"
    extract(ptet, file, "-o", str(path))
    whole = corners(path)
    low, high = whole.reshape(-1, 3).min(axis=0), whole.reshape(-1, 3).max(axis=0)
    rng = random.Random(seed)
    middles = [whole[rng.randrange(len(whole))].mean(axis=0) for _ in range(boxes)]
    for share in BACKGROUNDS:
        percent = background(ptet, file, share)
        extract(ptet, file, *bounds(percent), "-o", str(path))
        behind = corners(path)
        for size in SIZES:
            ratios = []
            for middle in middles:
                half = (high - low) / 2 * size ** (1 / 3)
                centre = numpy.clip(middle, low + half, high - half)
                a, b = centre - half, centre + half
                box = "box:" + ",".join(repr(float(x)) for x in [*a, *b])
                answer = extract(ptet, file, "--focus", box, *bounds(percent))["tets"]
                least = int(meet(whole, a, b).sum()) + int((~meet(behind, a, b)).sum())
                ratios.append(answer / least)
            yield share, size, ratios


def mean(ratios):
    return math.exp(sum(map(math.log, ratios)) / len(ratios))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE.ptet")
    parser.add_argument("--ptet", default="build/ptet", help="the program (build/ptet)")
    parser.add_argument("--boxes", type=int, default=5, help="of each size (5)")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    print(f"{'mesh':16} {'background':>10} " + " ".join(f"{f'{size:.0%} box':>8}" for size in SIZES))
    means = {}
    for file in arguments.files:
        rows = {}
        with tempfile.TemporaryDirectory() as folder:
            for share, size, ratios in cost(arguments.ptet, file, arguments.boxes, arguments.seed,
                                            pathlib.Path(folder)):
                rows.setdefault(share, []).append(mean(ratios))
                means.setdefault((share, size), []).append(mean(ratios))
        for share, row in rows.items():
            print(f"{pathlib.Path(file).stem:16} {share:>10.0%} " + " ".join(f"{ratio:8.3f}" for ratio in row), flush=True)
    for share in BACKGROUNDS:
        print(f"{'all':16} {share:>10.0%} " + " ".join(f"{mean(means[share, size]):8.3f}" for size in SIZES))


if __name__ == "__main__":
    main()
