#!/usr/bin/env python3
"""The table of Cignoni et al. 2000 (Table 1) on meshes of your own, for every method, beside VTK's filter.

    paper.py [MESH[:FIELD] ...]

A MESH is a file, or the name of one in the folder PTET_DATA; without any, all that are there. The default FIELD is the
first floating-point point array. For each mesh and percentage, VTK's vtkUnstructuredGridQuadricDecimation goes first;
then every method gives a cut of at most as many tets, from one build a method, and `ptet measure` judges them all.

Writes paper.txt (the table), paper.csv (all that was measured), MESH.png (error against tets) and MESH-walk.png (the
walk in error space, section 4.3) into the output folder, anew after each mesh, and after Ctrl-C. What fails or takes
too long is named in the table, and the rest goes on. Needs vtk_decimate (-DPTET_BUILD_BENCH=ON) and Matplotlib
(python3-matplotlib).
"""

import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

METHODS = ["exact", "LN", "GN", "QN", "BF", "BFS", "staadt-gross", "trotts"]
WITH_OBJECTIVE = {"exact", "BF", "BFS"}
EVALUATED_EXACTLY = {"exact"}
ADDS_UP = {"LN", "GN", "trotts"}  # what they believe of the domain: sums, which come to the usual limit early
OBJECTIVES = ["both", "max", "rms"]
PEER = "VTK"
COARSEST = "0.5%"   # of the vertices: where builds stop
GROUPS_A_LINE = 3
NO_DISTANCE = 1e-6  # % of the diagonal: bounds of a distance that may be 0 go no lower than a tenth of it
NOT_RUN = "not run"
NEARLY = 1.01       # a cut with more tets than this times what was asked for is not compared

COLUMNS = ["mesh", "field", "percent", "method", "asked_tets", "tets", "tets_percent", "vertices", "vertices_percent",
           "max_percent", "rms_percent", "outside_max_percent", "hausdorff_percent", "hausdorff_lower_percent", "valid",
           "seconds", "stated_max_percent", "stated_rms_percent", "stated_domain_percent", "stated_to_measured_max",
           "stated_to_measured_rms", "stated_to_measured_hausdorff", "note"]


class Failed(Exception):
    """A program failed or took too long; says which."""


def say(text):
    print(f"paper.py: {text}", file=sys.stderr, flush=True)


def run_json(command, timeout):
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8",
                              timeout=timeout, check=False)
    except subprocess.TimeoutExpired as late:
        raise Failed(f"over {timeout:g} s") from late
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise Failed(lines[-1])
    try:
        return json.loads(done.stdout)
    except ValueError as wrong:
        raise Failed(f"{os.path.basename(command[0])} printed no JSON") from wrong


def ratio(part, whole):
    return part / whole if part is not None and whole else None


def percent(part, whole):
    share = ratio(part, whole)
    return None if share is None else 100 * share


def distance_of(row):
    """The upper bound, or 0 where that is all it can tell."""
    bound = row["hausdorff_percent"]
    return 0 if bound is not None and bound < NO_DISTANCE else bound


VALUES = [lambda row: row["max_percent"], lambda row: row["rms_percent"], distance_of]


class Mesh:
    """A mesh, its field and what `ptet info` says of them."""

    def __init__(self, argument, ptet, timeout):
        path, _, field = argument.partition(":")
        if not os.path.exists(path):
            in_data = os.path.join(os.environ.get("PTET_DATA", ""), path + ("" if path.endswith(".vtu") else ".vtu"))
            if not os.path.exists(in_data):
                raise Failed(f"there is no mesh '{path}', nor '{in_data}'; PTET_DATA names the folder of meshes")
            path = in_data
        self.path, self.name = path, pathlib.Path(path).stem
        info = run_json([ptet, "info", path, "--json"], timeout)
        self.vertices, self.tets = info["vertices"], info["tets"]
        names = [f["name"] for f in info["fields"]]
        floating = [f["name"] for f in info["fields"] if f["type"].startswith("float")]
        if field and field not in names:
            raise Failed(f"{path} has no point array '{field}'; it has: {', '.join(names)}")
        if not field and not floating:
            raise Failed(f"{path} has no floating-point array; name one as {path}:FIELD")
        self.field = field or floating[0]


class Paper:
    def __init__(self, options):
        self.options = options
        self.ptet, self.vtk = (os.path.join(options.build, name) for name in ("ptet", "vtk_decimate"))
        self.rows = []
        self.meshes = []
        self.walks = {}  # mesh name -> walk, vertices
        self.methods = []  # label, name, objective
        for name in options.methods:
            for objective in options.objectives if name in WITH_OBJECTIVE else ["both"]:
                self.methods.append((name if objective == "both" else f"{name}-{objective}", name, objective))
        self.labels = [PEER] + [label for label, _, _ in self.methods]

    def run(self, mesh, folder):
        self.meshes.append(mesh)
        say(f"{mesh.name}, {mesh.field}: {mesh.tets} tets")
        cut = os.path.join(folder, "cut.vtu")
        rows = {label: [self.add(mesh, share, label) for share in self.options.fractions] for label in self.labels}
        for number, row in enumerate(rows[PEER]):
            share = row["percent"]
            try:
                done = run_json([self.vtk, mesh.path, str(share / 100), mesh.field, "-o", cut], self.options.timeout)
                row["seconds"] = done["seconds"]
                self.measure(mesh, cut, row)
            except Failed as why:
                row["note"] = f"{why}"  # the cuts are still worth having
            for label in self.labels[1:]:
                rows[label][number]["asked_tets"] = row["tets"] or row["asked_tets"]
        say(f"  {PEER}")
        for label, name, objective in self.methods:
            self.run_method(mesh, name, objective, rows[label], folder)

    def run_method(self, mesh, name, objective, rows, folder):
        file, cut = os.path.join(folder, "build.ptet"), os.path.join(folder, "cut.vtu")
        label = rows[0]["method"]
        order = ["--objective", objective] if name in WITH_OBJECTIVE else []
        limit = ["--max-domain-error", "100%"] if name in ADDS_UP else []
        try:
            build = run_json([self.ptet, "build", mesh.path, "-o", file, "--field", mesh.field, "--method", name,
                              *order, *limit, "--target-vertices", COARSEST, "--json"], self.options.timeout)
        except Failed as why:
            say(f"  {label}: {why}")
            for row in rows:
                row["note"] = f"build: {why}"
            return
        say(f"  {label}: {build['seconds']:.1f} s")
        if name in EVALUATED_EXACTLY and mesh.name not in self.walks:
            self.walks[mesh.name] = (label, build)
        for row in rows:
            row["seconds"] = build["seconds"]
            try:
                extracted = run_json([self.ptet, "extract", file, "-o", cut, "--tets", str(row["asked_tets"]),
                                      "--json"], self.options.timeout)
                stated = extracted["achieved"] if name in EVALUATED_EXACTLY else None
                self.measure(mesh, cut, row, stated)
            except Failed as why:
                row["note"] = f"{why}"

    def add(self, mesh, share, label):
        row = dict.fromkeys(COLUMNS)
        row.update(mesh=mesh.name, field=mesh.field, percent=share, method=label, note=NOT_RUN,
                   asked_tets=round(mesh.tets * share / 100))
        self.rows.append(row)
        return row

    def measure(self, mesh, cut, row, stated=None):
        report = run_json([self.ptet, "measure", mesh.path, cut, "--field", mesh.field, "--json"],
                          self.options.timeout)
        inside = report["inside"]["fields"][mesh.field]
        outside = report["outside"]["fields"].get(mesh.field)
        distance = report["hausdorff"]["symmetric"]
        validity = report["simplified"]["validity"]
        row.update(tets=report["simplified"]["tets"], vertices=report["simplified"]["vertices"],
                   max_percent=inside["max_percent"], rms_percent=inside["rms_percent"],
                   outside_max_percent=outside["max_percent"] if outside else None,
                   hausdorff_percent=distance["upper_percent"], hausdorff_lower_percent=distance["lower_percent"],
                   valid=validity["valid"])
        row["note"] = ""
        row["tets_percent"] = percent(row["tets"], mesh.tets)
        row["vertices_percent"] = percent(row["vertices"], mesh.vertices)
        if row["asked_tets"] and row["tets"] > NEARLY * row["asked_tets"]:
            row["note"] = "coarsest mesh"
        if stated:
            field_range, diagonal = report["ranges"][mesh.field], report["hausdorff"]["diagonal"]
            row["stated_max_percent"] = percent(stated["field_error"][mesh.field], field_range)
            row["stated_domain_percent"] = percent(stated["domain_error"], diagonal)
            if stated.get("rms_error"):
                row["stated_rms_percent"] = percent(stated["rms_error"][mesh.field], field_range)
            row["stated_to_measured_max"] = ratio(row["stated_max_percent"], row["max_percent"])
            row["stated_to_measured_rms"] = ratio(row["stated_rms_percent"], row["rms_percent"])
            row["stated_to_measured_hausdorff"] = ratio(row["stated_domain_percent"], distance_of(row))

    def write(self):
        out = pathlib.Path(self.options.out)
        with open(out / "paper.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            for row in self.rows:
                writer.writerow({key: f"{value:.6g}" if isinstance(value, float) else value
                                 for key, value in row.items()})
        (out / "paper.txt").write_text(Table(self).text(), encoding="utf-8")
        mesh = self.meshes[-1]
        plot_errors(out / f"{mesh.name}.png", mesh, self)
        if mesh.name in self.walks:
            plot_walk(out / f"{mesh.name}-walk.png", mesh, *self.walks[mesh.name])


def figure(value):
    """Three digits, in at most six characters."""
    if value is None:
        return "-"
    if value == 0:
        return "0"
    return f"{value:.2g}" if value < 0.001 else f"{value:.{max(0, 2 - math.floor(math.log10(value)))}f}"


class Table:
    """The text: a block a mesh, rows of percentages, groups of columns a method."""

    def __init__(self, paper):
        self.paper = paper
        self.at = {(row["mesh"], row["percent"], row["method"]): row for row in paper.rows}
        self.lines = []

    def text(self):
        self.lines = [
            "Errors at equal tet counts. VTK: vtkUnstructuredGridQuadricDecimation; the others: ptet build --method",
            "max, RMS   exact, where both domains overlap, % of the field's range",
            "Haus       Hausdorff distance of the boundaries, both ways, upper bound, % of the diagonal",
            "vtx        vertices, % of the original's",
            "s          seconds: VTK of this reduction, the others of one build for all rows",
            "!          not valid: tets turned or flat, or a boundary that is no manifold or meets itself",
            ">          more tets than asked for: the coarsest mesh of the build; not in the means",
        ]
        for mesh in self.paper.meshes:
            self.block(mesh)
        self.stated()
        self.summary()
        return "\n".join(line.rstrip() for line in self.lines) + "\n"

    def block(self, mesh):
        self.lines += ["", "", f"{mesh.name}, {mesh.field}: {mesh.vertices} vertices, {mesh.tets} tets"]
        notes = []
        labels = self.paper.labels
        for first in range(0, len(labels), GROUPS_A_LINE):
            group = labels[first:first + GROUPS_A_LINE]
            self.lines += ["", " " * 13 + "".join(f" | {label:<32}" for label in group),
                           f"{'%':>4} {'tets':>8}" +
                           "".join(f" | {'vtx':>5} {'max':>6} {'RMS':>6} {'Haus':>5}   {'s':>4}" for _ in group)]
            for number, share in enumerate(self.paper.options.fractions):
                asked = self.at[mesh.name, share, PEER]["tets"] or self.at[mesh.name, share, PEER]["asked_tets"]
                line = f"{share:>4g} {asked:>8}"
                for label in group:
                    row = self.at[mesh.name, share, label]
                    line += " | " + self.cells(row, number == 0 or label == PEER)
                    note = f"{label}: {row['note']}"
                    if row["max_percent"] is None and note not in notes:
                        notes.append(note)
                self.lines.append(line)
        self.lines += [f"  no figures: {note}" for note in notes]

    @staticmethod
    def cells(row, with_time):
        if row["max_percent"] is None:
            return f"{'no figures':<32}"
        mark = ("" if row["valid"] else "!") + (">" if row["note"] else "")
        seconds = figure(row["seconds"])[:4].rstrip(".") if with_time else ""
        if with_time and row["seconds"] >= 10:
            seconds = f"{row['seconds']:.0f}"
        return (f"{figure(row['vertices_percent']):>5} {figure(row['max_percent']):>6} "
                f"{figure(row['rms_percent']):>6} {figure(distance_of(row)):>5}{mark:<2} {seconds:>4}")

    def compared(self, label, value):
        """Ratios to VTK, where both have figures at equal tet counts."""
        ratios = []
        for row in self.paper.rows:
            peer = self.at[row["mesh"], row["percent"], PEER]
            if row["method"] == label and not row["note"] and value(row) and value(peer):
                ratios.append(value(row) / value(peer))
        return ratios

    def stated(self):
        labels = [label for label, name, _ in self.paper.methods if name in EVALUATED_EXACTLY]
        for label in labels:
            self.lines += ["", "", f"{label}: stated by the file / measured (max, RMS, Hausdorff)", ""]
            for mesh in self.paper.meshes:
                line = f"{mesh.name:<14}"
                for share in self.paper.options.fractions:
                    row = self.at[mesh.name, share, label]
                    figures = [row[f"stated_to_measured_{what}"] for what in ("max", "rms", "hausdorff")]
                    line += f" | {share:>3g}% " + " ".join("   -" if x is None else f"{x:.2f}" for x in figures)
                self.lines.append(line)

    def summary(self):
        self.lines += ["", "", "Geometric means of the ratio to VTK at equal tet counts (below 1: better than VTK);",
                       "rows where one of the two is 0 are left out", "",
                       f"{'':<14}{'max':>8}{'RMS':>8}{'Haus':>8}{'of':>5}{'valid':>9}"]
        for label in self.paper.labels:
            rows = [row for row in self.paper.rows if row["method"] == label and row["max_percent"] is not None]
            cells = f"{label:<14}"
            for value in VALUES:
                ratios = self.compared(label, value)
                mean = math.exp(sum(map(math.log, ratios)) / len(ratios)) if ratios else None
                cells += f"{figure(mean):>8}"
            count = len(self.compared(label, VALUES[0]))
            self.lines.append(cells + f"{count:>5}{sum(bool(row['valid']) for row in rows):>4} of {len(rows)}")


COLOURS = ["#0b62c4", "#e07b00", "#2a9d3a", "#c72c2c", "#8a4fc0", "#7c5644", "#d668b0", "#12a3b0", "#9a9a1e", "#5a5a5a"]
MARKERS = "osD^vP*Xhd"


def plot_errors(path, mesh, paper):
    panels = [("max_percent", "exact maximum"), ("rms_percent", "RMS")]
    if not all(any(row[key] for row in paper.rows if row["mesh"] == mesh.name) for key, _ in panels):
        return  # nothing came out, or no error: nothing to draw on a logarithmic scale
    plt = pyplot()
    drawing, axes = plt.subplots(1, 2, figsize=(9.6, 4.2), layout="constrained")
    for panel, (key, title) in zip(axes, panels):
        for number, label in enumerate(paper.labels):
            rows = [row for row in paper.rows if row["mesh"] == mesh.name and row["method"] == label and row[key]]
            if not rows:
                continue
            peer = label == PEER
            style = {"color": "black", "marker": "s", "linestyle": "--", "linewidth": 1.8} if peer else {
                "color": COLOURS[(number - 1) % len(COLOURS)], "marker": MARKERS[(number - 1) % len(MARKERS)],
                "linewidth": 2.2 if label.startswith("exact") else 1.1}
            panel.loglog([row["tets"] for row in rows], [row[key] for row in rows], label=label, markersize=4.5,
                         zorder=4 if peer or label.startswith("exact") else 3, **style)
        panel.set_xlabel("tets")
        panel.set_ylabel(f"{title}, % of the range")
        panel.grid(True, which="major", color="#dddddd", linewidth=0.7)
        panel.spines[["top", "right"]].set_visible(False)
        plain_ticks(panel.yaxis, (1, 2, 5))
        ticks = sorted({round(mesh.tets * share / 100) for share in paper.options.fractions})
        panel.set_xticks(ticks, [f"{tick:,}" for tick in ticks])
        panel.xaxis.set_minor_locator(plt.NullLocator())
    axes[1].legend(loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
    drawing.suptitle(f"{mesh.name}, {mesh.field}: field error at equal tet counts", fontsize=11)
    drawing.savefig(path, dpi=100)
    plt.close(drawing)


def plot_walk(path, mesh, label, build):
    """Domain error against field error as the build goes, and the square that holds both so far."""
    walk = build.get("walk")
    if not walk:
        return
    plt = pyplot()
    domain = [100 * step["domain_error"] for step in walk]
    field = [100 * step["field_error"] for step in walk]
    share = [percent(step["vertices"], build["input"]["vertices"]) for step in walk]
    seen = [x for x in domain + field if x > 0]
    if not seen:
        return
    low = 10 ** math.floor(math.log10(max(min(seen), max(seen) / 1000)))
    high = 1.6 * max(seen)
    drawing, panel = plt.subplots(figsize=(6.2, 5.2), layout="constrained")
    panel.plot([max(x, low) for x in domain], [max(y, low) for y in field], color="#0b62c4", linewidth=1.2, zorder=3)
    for mark in (50, 20, 10, 5, 2, 1):
        at = next((i for i, left in enumerate(share) if left <= mark), None)
        side = max(domain[at], field[at]) if at is not None else 0
        if side <= low:
            continue
        panel.plot([low, side, side], [side, side, low], color="#999999", linewidth=0.9, zorder=2)
        panel.plot(max(domain[at], low), max(field[at], low), "o", color="#0b62c4", markersize=5, zorder=4)
        panel.annotate(f"{mark}% of the vertices", (side, side), textcoords="offset points", xytext=(4, -8),
                       fontsize=8, color="#444444", annotation_clip=False, zorder=5,
                       bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5})
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlim(low, high)
    panel.set_ylim(low, high)
    panel.set_aspect("equal")
    plain_ticks(panel.xaxis)
    plain_ticks(panel.yaxis)
    panel.set_xlabel("largest domain error so far, % of the diagonal (0: on the axis)")
    panel.set_ylabel("largest field error so far, % of the range")
    panel.spines[["top", "right"]].set_visible(False)
    panel.set_title(f"{mesh.name}, {mesh.field}, method {label}: the walk in error space\n"
                    f"and the square that has grown around it", fontsize=10)
    drawing.savefig(path, dpi=100)
    plt.close(drawing)


def plain_ticks(axis, steps=(1,)):
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
    axis.set_major_locator(LogLocator(subs=steps))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def pyplot():
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    return plt


def some_of(known):
    def parse(text):
        names = text.split(",")
        for name in names:
            if name not in known:
                raise argparse.ArgumentTypeError(f"'{name}' is none of {', '.join(known)}")
        return list(dict.fromkeys(names))
    return parse


def percentages(text):
    try:
        shares = [float(part) for part in text.split(",")]
    except ValueError as wrong:
        raise argparse.ArgumentTypeError("numbers with commas") from wrong
    if not all(0 < share < 100 for share in shares):
        raise argparse.ArgumentTypeError("between 0 and 100")
    return sorted(set(shares), reverse=True)


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="*", metavar="MESH[:FIELD]")
    parser.add_argument("--meshes", default="", metavar="M,...", help="the same, with commas")
    parser.add_argument("--methods", type=some_of(METHODS), default=METHODS, metavar="M,...",
                        help=f"default: {','.join(METHODS)}")
    parser.add_argument("--objectives", "--objective", type=some_of(OBJECTIVES), default=["both"], metavar="O,...",
                        help="of exact, BF and BFS: both, max, rms (default: both)")
    parser.add_argument("--fractions", type=percentages, default=[50.0, 20.0, 10.0, 5.0, 2.0], metavar="P,...",
                        help="percent of the tets (default: 50,20,10,5,2)")
    parser.add_argument("--out", default="paper", metavar="FOLDER", help="for the results (default: paper)")
    parser.add_argument("--build", default="build", metavar="BUILD", help="folder with the programs (default: build)")
    parser.add_argument("--timeout", type=float, default=600, metavar="S",
                        help="seconds that one build, cut or measurement may take (default: 600)")
    options = parser.parse_args()
    options.mesh += [name for name in options.meshes.split(",") if name]
    if not options.mesh:
        data = os.environ.get("PTET_DATA")
        if not data:
            sys.exit("paper.py: no mesh: name some, or the folder that holds them in PTET_DATA")
        options.mesh = sorted(str(path) for path in pathlib.Path(data).glob("*.vtu"))
        if not options.mesh:
            sys.exit(f"paper.py: no .vtu in '{data}' (PTET_DATA)")
    for name in ("ptet", "vtk_decimate"):
        if not os.access(os.path.join(options.build, name), os.X_OK):
            sys.exit(f"paper.py: no {name} in '{options.build}'; build with -DPTET_BUILD_BENCH=ON, or name the folder "
                     f"with --build")
    try:
        pyplot()
    except ImportError:
        sys.exit("paper.py: no Matplotlib (Debian: python3-matplotlib)")
    return options


def main():
    options = parse_options()
    paper = Paper(options)
    try:
        meshes = [Mesh(argument, paper.ptet, options.timeout) for argument in options.mesh]
    except Failed as why:
        sys.exit(f"paper.py: {why}")
    os.makedirs(options.out, exist_ok=True)
    for mesh in meshes:
        try:
            with tempfile.TemporaryDirectory() as folder:
                paper.run(mesh, folder)
        finally:
            paper.write()  # what there is, after Ctrl-C too
    print((pathlib.Path(options.out) / "paper.txt").read_text(encoding="utf-8"), end="")
    if any(row["max_percent"] is None for row in paper.rows):
        sys.exit(1)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        say("interrupted")
        sys.exit(130)
