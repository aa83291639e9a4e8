#!/usr/bin/env python3
"""How the error of a mesh falls with its size: a plot of everything that one file can give.

    error_against_size.py [MESH.vtu | FILE.ptet] [--field NAME] [-o error_against_size.png]

Without a file a mesh is made up. The cells marked # %% can be run one by one in an editor that knows notebooks.
"""
# %% What to look at
import argparse
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from example_mesh import load

import ptet

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("file", nargs="?")
parser.add_argument("--field")
parser.add_argument("-o", "--output", default="error_against_size.png")
options = parser.parse_args()

data = load(options.file, govern=options.field)
info = data.info
if not info.governing:
    sys.exit("no field of the file has errors: build it with one")
field = options.field or info.governing[0]
scale = info.field(field).range
print(data)

# %% By size: the best mesh for so many vertices
sizes = np.unique(np.geomspace(max(info.base_vertices, 2), info.vertices, 24).astype(int))
cuts = [data.extract(budget=ptet.Budget(vertices=int(size))) for size in sizes]
coarse = [cut for cut in cuts if cut.field_error[field] > 0]
if not coarse:
    raise SystemExit(f"{field} has no error at any size, as a constant has none: name another with --field")
tets = [len(cut.tets) for cut in coarse]
greatest = [cut.field_error[field] / scale for cut in coarse]
mean = [cut.rms_error[field] / scale for cut in coarse if cut.rms_error]

# %% By error: the coarsest mesh within a bound, and how near to it the mesh comes
bounds = np.geomspace(max(min(greatest), 1e-4), max(greatest), 16)
within = [data.extract(error={field: bound * scale}) for bound in bounds]

# %% The plots
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
left.loglog(tets, greatest, "o-", color="#c0392b", label="greatest error, anywhere")
if mean:
    left.loglog(tets, mean, "s-", color="#2c5f8a", label="root mean square")
left.axvline(info.tets, color="0.6", linestyle=":")
left.annotate("original ", (info.tets, 1), xycoords=("data", "axes fraction"), ha="right", va="top", color="0.4")
left.set(xlabel="tetrahedra", ylabel=f"error of {field}, part of its range", title="Error against size")
left.legend(loc="lower left")
right.plot(bounds * 100, [len(cut.tets) for cut in within], "o-", color="#c0392b")
right.set(xscale="log", yscale="log", xlabel=f"error of {field} asked for, % of its range", ylabel="tetrahedra",
          title="Tetrahedra that a bound needs")
for axes in (left, right):
    axes.grid(True, which="both", color="0.92")
    axes.set_axisbelow(True)
figure.savefig(options.output, dpi=130)
print(f"wrote {options.output}")
