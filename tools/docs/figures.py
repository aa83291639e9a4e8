#!/usr/bin/env python3
"""Makes the figures of errors.md: one drawn, two measured.

    figures.py MESH.vtu --field NAME [--ptet build/ptet] [--out tools/docs]

overlap.png    where the difference of two piecewise linear fields can be largest, in the plane
promises.png   what files state of their meshes, against what `ptet measure` finds: a file built by exact errors, and one
               that looked at removed vertices only
where.png      the original cut open, coloured by how far a mesh within 2% of the range is from it

Needs NumPy and matplotlib (Debian: python3-numpy, python3-matplotlib), and for where.png what tools/python/picture.py
needs.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

TOOLS = pathlib.Path(__file__).resolve().parent.parent
INK, FINE, COARSE, POINT = "#212429", "#9aa5b1", "#0061bf", "#c8402f"
BOUNDS = ("0.5%", "1%", "2%", "4%", "8%", "16%")

plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": INK})


def run(command):
    """Standard output of `command`, which must succeed."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"figures.py: {command[0]} {command[1]} ended with {done.returncode}")
    return done.stdout


def crossing(a, b, c, d):
    """Where the segments ab and cd cross, or None."""
    r, s = b - a, d - c
    area = r[0] * s[1] - r[1] * s[0]
    if abs(area) < 1e-12:
        return None
    t = ((c - a)[0] * s[1] - (c - a)[1] * s[0]) / area
    u = ((c - a)[0] * r[1] - (c - a)[1] * r[0]) / area
    return a + t * r if 0 < t < 1 and 0 < u < 1 else None


def draw_overlap(path):
    """One coarse triangle over a fine triangulation: inside it, the corners of the common pieces."""
    random = np.random.default_rng(4)
    grid = np.array([(x, y) for y in range(5) for x in range(5)], float)
    inner = [i for i, (x, y) in enumerate(grid) if 0 < x < 4 and 0 < y < 4]
    grid[inner] += random.uniform(-0.28, 0.28, (len(inner), 2))
    edges = set()
    for y in range(4):
        for x in range(4):
            i = 5 * y + x
            edges |= {(i, i + 1), (i, i + 5), (i + 1, i + 6), (i + 5, i + 6), (i, i + 6)}
    triangle = np.array([grid[1], grid[14], grid[21]])
    sides = [(triangle[i], triangle[(i + 1) % 3]) for i in range(3)]

    def inside(p):
        signs = [np.sign((b - a)[0] * (p - a)[1] - (b - a)[1] * (p - a)[0]) for a, b in sides]
        return min(signs) > 0 or max(signs) < 0

    figure, axes = plt.subplots(figsize=(4.6, 4.2))
    for i, j in sorted(edges):
        axes.plot(*grid[[i, j]].T, color=FINE, lw=0.9, zorder=1)
    axes.fill(*triangle.T, facecolor=COARSE, alpha=0.10, zorder=0)
    axes.plot(*triangle[[0, 1, 2, 0]].T, color=COARSE, lw=2, zorder=2)
    kept = np.array([p for p in grid if inside(p)])
    crossings = [crossing(grid[i], grid[j], a, b) for i, j in sorted(edges) for a, b in sides]
    crossings = np.array([p for p in crossings if p is not None])
    axes.plot(*kept.T, "o", color=POINT, ms=6, zorder=3, label="removed vertex")
    axes.plot(*crossings.T, "s", mfc="white", mec=POINT, ms=5, zorder=3, label="fine edge crosses coarse side")
    axes.plot(*triangle.T, "o", color=COARSE, ms=7, zorder=4, label="vertex that stays: difference 0")
    axes.set_aspect("equal")
    axes.axis("off")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.02), frameon=False, fontsize=9)
    figure.savefig(path, dpi=110, bbox_inches="tight")


def stated_and_measured(ptet, mesh, field, build_options, folder):
    """For each bound: what the file states of its mesh, and what is measured, in % of the field's range."""
    file, cut = folder / "levels.ptet", folder / "cut.vtu"
    run([ptet, "build", mesh, "-o", file, "--field", field, *build_options])
    rows = []
    for bound in BOUNDS:
        report = json.loads(run([ptet, "extract", file, "-o", cut, "--field-error", bound, "--json"]))
        measured = json.loads(run([ptet, "measure", mesh, cut, "--field", field, "--json"]))
        span = measured["ranges"][field]
        errors = report["achieved"]["field_error"][field], measured["inside"]["fields"][field]["max"]
        rows.append([100 * error / span for error in errors])
    return np.array(rows)


def draw_promises(ptet, mesh, field, path):
    figure, axes = plt.subplots(figsize=(5.2, 4.4))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        exact = stated_and_measured(ptet, mesh, field, [], folder)
        vertices = stated_and_measured(ptet, mesh, field, ["--method", "QN", "--evaluate", "vertices"], folder)
    limits = np.array([0.3, 30])
    axes.fill_between(limits, limits, 100, color=POINT, alpha=0.08, lw=0)
    axes.plot(limits, limits, color=INK, lw=0.8)
    axes.plot(*vertices.T, "s--", color=POINT, ms=6, lw=1, label="seen at removed vertices (--evaluate vertices)")
    axes.plot(*exact.T, "o-", color=COARSE, ms=6, lw=1, label="exact (default)")
    axes.text(0.36, 17, "worse than stated", color=POINT, fontsize=9)
    axes.set(xscale="log", yscale="log", xlim=limits, ylim=limits, xlabel="error that the file states, % of the range",
             ylabel="error that is there, % of the range")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axes.legend(loc="lower right", frameon=False, fontsize=9)
    axes.set_title(f"{mesh.stem}, {field}", fontsize=10, color=INK)
    figure.savefig(path, dpi=110, bbox_inches="tight")
    for kind, rows in (("exact", exact), ("vertices", vertices)):
        print(f"{kind}: measured / stated", " ".join(f"{m / s:.3f}" for s, m in rows))


def draw_where(ptet, mesh, field, clip, path):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        file, cut, errors = folder / "levels.ptet", folder / "cut.vtu", folder / f"{mesh.stem}.vtu"
        run([ptet, "build", mesh, "-o", file, "--field", field])
        run([ptet, "extract", file, "-o", cut, "--field-error", "2%"])
        run([ptet, "measure", mesh, cut, "--field", field, "--errors", errors])
        title = f"|{field} of the mesh within 2% - {field} of the original|"
        run(["xvfb-run", "-a", "/usr/bin/python3", TOOLS / "python" / "picture.py", errors, "--field", f"{field} error",
             "--clip", clip, "--title", title, "--size", "900x560", "-o", path])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=pathlib.Path)
    parser.add_argument("--field", required=True)
    parser.add_argument("--clip", default="y:1.7", help="where where.png is cut open, as for picture.py (default: %(default)s)")
    parser.add_argument("--ptet", type=pathlib.Path, default=TOOLS.parent / "build" / "ptet")
    parser.add_argument("--out", type=pathlib.Path, default=TOOLS / "docs")
    options = parser.parse_args()
    draw_overlap(options.out / "overlap.png")
    draw_promises(options.ptet, options.mesh, options.field, options.out / "promises.png")
    draw_where(options.ptet, options.mesh, options.field, options.clip, options.out / "where.png")


if __name__ == "__main__":
    main()
