#!/usr/bin/env python3
"""Measures ptet on meshes, given or generated, beside VTK's filter in the same run: a table, a CSV and plots.

    bench.py [MESH.vtu ...] [--generate KIND:TETS ...] [--out FOLDER] [--before bench.csv]

KIND is cube or ball (see generate_mesh --help), TETS a number such as 500k or 2M. Needs a build with
-DPTET_BUILD_BENCH=ON (packages libbenchmark-dev, python3-matplotlib, python3-zstandard) and VTK's Python modules
(python3-vtk9). Times are processor times, medians of the runs; the machine may be busy with other things.

  vtx left       vertices of the coarsest mesh
  QN s, us/col   `ptet build --method QN --threads 1`: user and system seconds, reading and writing included; and
                 microseconds a collapse
  B/tet          its peak resident memory, in bytes for each tet of the input
  of VTK         QN s / VTK's seconds: vtkUnstructuredGridQuadricDecimation of the same mesh and its first field, to 2%
                 of its tets, the filter alone
  exact s, B/tet `ptet build` as it is by default, exact errors included, all cores: processor seconds and peak
  exact wall     and by the clock
  of VTU         the QN file with all its levels, beside a VTU of the input: zlib, 32-bit ids, types as they are
  of zstd        likewise beside the input's raw arrays with 32-bit ids, each compressed by zstd -19
  open+1% s      a new process: open the file and cut at a field error of 1%; processor time
  decode         million tets a second on one core: opening, checking and decoding the file in memory, and its full mesh
  cut            likewise of a cut at a field error of 1% from a file that is decoded
  max, RMS       errors at equal tet counts, those of VTK's mesh of 10%: exact maximum and RMS of the first field by
                 `ptet measure`, ptet's (default build where there is one, else QN) as a fraction of VTK's

With --before, a table of ratios of this run's figures to those of an earlier bench.csv follows, for meshes in both.
"""

import argparse
import csv
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

import zstandard
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter

PROGRAMS = ("ptet", "cut_bench", "vtk_decimate", "generate_mesh")
PEER_LEFT = 0.02   # part of the tets that VTK's filter is timed to
ERRORS_AT = 0.1    # and that errors are compared at


def say(text):
    print(f"bench.py: {text}", file=sys.stderr, flush=True)


def run(command):
    """Standard output, processor seconds, wall seconds and peak resident bytes of a process."""
    with tempfile.TemporaryFile() as out:
        before = os.times().elapsed
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out)
        _, status, usage = os.wait4(child.pid, 0)
        wall = os.times().elapsed - before
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            sys.exit(f"bench.py: exit code {child.returncode} of: {' '.join(command)}")
        out.seek(0)
        return out.read().decode(), usage.ru_utime + usage.ru_stime, wall, usage.ru_maxrss * 1024


def read(mesh):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(mesh)
    reader.Update()
    return reader.GetOutput()


def vtu_bytes(grid, folder):
    """Size of the mesh as VTU, raw appended, zlib, 32-bit ids and headers."""
    path = os.path.join(folder, "reference.vtu")
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetFileName(path)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToZLib()
    writer.SetHeaderTypeToUInt32()
    writer.SetIdTypeToInt32()
    writer.Write()
    size = os.path.getsize(path)
    os.remove(path)
    return size


def zstd_bytes(grid):
    """Of positions, point arrays and the ids of cells, each by itself."""
    data = grid.GetPointData()
    arrays = [vtk_to_numpy(grid.GetPoints().GetData())]
    arrays += [vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())]
    arrays.append(vtk_to_numpy(grid.GetCells().GetConnectivityArray()).astype("int32"))
    return sum(len(zstandard.ZstdCompressor(level=19).compress(array.tobytes())) for array in arrays)


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.ptet, self.cut_bench, self.vtk, self.generator = (os.path.join(options.build, n) for n in PROGRAMS)
        self.fields = [part for name in options.field for part in ("--field", name)]

    def generate(self, what):
        kind, _, tets = what.partition(":")
        path = os.path.join(self.folder, f"{kind}_{tets}.vtu")
        run([self.generator, kind, "--tets", tets, "-o", path])
        return path

    def build(self, mesh, file, *method):
        out, seconds, wall, peak = run([self.ptet, "build", mesh, "-o", file, "--json", "--force", *method,
                                        *self.fields])
        return json.loads(out), seconds, wall, peak

    def measure(self, mesh):
        file = os.path.join(self.folder, "qn.ptet")
        builds = [self.build(mesh, file, "--threads", "1", "--method", "QN") for _ in range(self.options.runs)]
        report = builds[0][0]
        vertices, tets = report["input"]["vertices"], report["input"]["tets"]
        seconds = statistics.median(b[1] for b in builds)
        file_bytes = os.path.getsize(file)
        row = {
            "mesh": os.path.splitext(os.path.basename(mesh))[0], "vertices": vertices, "tets": tets,
            "base_vertices": report["base"]["vertices"], "records": report["records"],
            "qn_seconds": seconds, "qn_us_per_collapse": 1e6 * seconds / max(1, report["records"]),
            "qn_wall": statistics.median(b[2] for b in builds),
            "qn_loop_wall_us_per_collapse": statistics.median(
                1e6 * b[0]["collapse_seconds"] / max(1, b[0]["records"]) for b in builds),
            "qn_peak_bytes_per_tet": statistics.median(b[3] for b in builds) / tets,
            "file_bytes": file_bytes, "bytes_per_vertex": file_bytes / vertices,
        }
        self.measure_reading(file, row)
        self.measure_size(mesh, row)
        if tets <= self.options.exact_up_to:
            file = os.path.join(self.folder, "exact.ptet")
            _, row["exact_seconds"], row["exact_wall"], peak = self.build(mesh, file)
            row["exact_peak_bytes_per_tet"] = peak / tets
            row["exact_file_bytes"] = os.path.getsize(file)
        if not self.options.no_peer:
            self.measure_peer(mesh, file, row)
        return row

    def measure_reading(self, file, row):
        row["open_and_cut_seconds"] = statistics.median(
            run([self.ptet, "extract", file, "--field-error", "1%", "--json"])[1] for _ in range(self.options.runs))
        out = run([self.cut_bench, file, "--benchmark_format=json", "--benchmark_min_time=0.2",
                   "--benchmark_filter=decode the whole file|whole mesh|field error 1%$"])[0]
        for name, key in (("decode the whole file", "decode"), ("whole mesh", "whole_mesh"), ("field error 1%", "cut")):
            rates = [b["items_per_second"] for b in json.loads(out)["benchmarks"] if b["name"].split("/")[0] == name]
            row[f"{key}_tets_per_second"] = rates[0]

    def measure_size(self, mesh, row):
        grid = read(mesh)
        row["vtu_bytes"] = vtu_bytes(grid, self.folder)
        row["ratio_to_vtu"] = row["file_bytes"] / row["vtu_bytes"]
        if row["tets"] <= self.options.zstd_up_to:
            row["zstd_bytes"] = zstd_bytes(grid)
            row["ratio_to_zstd"] = row["file_bytes"] / row["zstd_bytes"]

    def measure_peer(self, mesh, file, row):
        field = self.options.field[:1]
        peers = [json.loads(run([self.vtk, mesh, str(PEER_LEFT), *field])[0]) for _ in range(self.options.runs)]
        row["vtk_seconds"] = statistics.median(p["processor_seconds"] for p in peers)
        row["vtk_tets"] = peers[0]["tets"]
        row["qn_of_vtk"] = row["qn_seconds"] / row["vtk_seconds"]
        if row["tets"] > self.options.errors_up_to:
            return
        cut = os.path.join(self.folder, "cut.vtu")
        tets = json.loads(run([self.vtk, mesh, str(ERRORS_AT), *field, "-o", cut])[0])["tets"]
        theirs = self.errors(mesh, cut)
        run([self.ptet, "extract", file, "--tets", str(tets), "-o", cut, "--json"])
        ours = self.errors(mesh, cut)
        for key in ("max", "rms"):
            row[f"vtk_{key}_percent"], row[f"{key}_percent"] = theirs[f"{key}_percent"], ours[f"{key}_percent"]
            if theirs[f"{key}_percent"]:
                row[f"{key}_of_vtk"] = ours[f"{key}_percent"] / theirs[f"{key}_percent"]

    def errors(self, mesh, cut):
        field = self.options.field[0] if self.options.field else read(cut).GetPointData().GetArrayName(0)
        out = run([self.ptet, "measure", mesh, cut, "--field", field, "--json"])[0]
        return json.loads(out)["inside"]["fields"][field]


def shown(row, key, form="{:.2f}", scale=1.0):
    value = row.get(key)
    return "-" if value in (None, "") else form.format(scale * float(value))


COLUMNS = [
    ("mesh", lambda r: r["mesh"]),
    ("tets", lambda r: f"{int(r['tets']):,}"),
    ("vtx left", lambda r: f"{100 * int(r['base_vertices']) / int(r['vertices']):.1f}%"),
    ("QN s", lambda r: shown(r, "qn_seconds")),
    ("us/col", lambda r: shown(r, "qn_us_per_collapse", "{:.1f}")),
    ("B/tet", lambda r: shown(r, "qn_peak_bytes_per_tet", "{:.0f}")),
    ("VTK s", lambda r: shown(r, "vtk_seconds")),
    ("of VTK", lambda r: shown(r, "qn_of_vtk")),
    ("exact s", lambda r: shown(r, "exact_seconds", "{:.1f}")),
    ("wall", lambda r: shown(r, "exact_wall", "{:.1f}")),
    ("B/tet", lambda r: shown(r, "exact_peak_bytes_per_tet", "{:.0f}")),
    ("file B", lambda r: f"{int(r['file_bytes']):,}"),
    ("B/vtx", lambda r: shown(r, "bytes_per_vertex", "{:.1f}")),
    ("of VTU", lambda r: shown(r, "ratio_to_vtu", "{:.3f}")),
    ("of zstd", lambda r: shown(r, "ratio_to_zstd", "{:.3f}")),
    ("open+1% s", lambda r: shown(r, "open_and_cut_seconds")),
    ("decode", lambda r: shown(r, "decode_tets_per_second", "{:.1f}", 1e-6)),
    ("cut", lambda r: shown(r, "cut_tets_per_second", "{:.1f}", 1e-6)),
    ("max", lambda r: shown(r, "max_of_vtk")),
    ("RMS", lambda r: shown(r, "rms_of_vtk")),
]
#: What is compared with an earlier run, and what counts as better.
COMPARED = [("qn_seconds", "QN s"), ("qn_us_per_collapse", "us/col"), ("qn_peak_bytes_per_tet", "QN B/tet"),
            ("exact_seconds", "exact s"), ("exact_peak_bytes_per_tet", "exact B/tet"), ("file_bytes", "file B"),
            ("open_and_cut_seconds", "open+1% s"), ("decode_tets_per_second", "decode"), ("cut_tets_per_second", "cut"),
            ("vtk_seconds", "VTK s")]
SUMMARISED = [("qn_of_vtk", "QN / VTK"), ("ratio_to_vtu", "of VTU"), ("ratio_to_zstd", "of zstd"),
              ("max_of_vtk", "max"), ("rms_of_vtk", "RMS")]


def aligned(cells):
    widths = [max(len(line[i]) for line in cells) for i in range(len(cells[0]))]
    lines = []
    for number, line in enumerate(cells):
        lines.append("| " + " | ".join(cell.ljust(w) if i == 0 else cell.rjust(w)
                                       for i, (cell, w) in enumerate(zip(line, widths))) + " |")
        if number == 0:
            lines.append("|" + "|".join("-" * (w + 1) + (":" if i else "-") for i, w in enumerate(widths)) + "|")
    return "\n".join(lines) + "\n"


def geometric_mean(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def table(rows):
    text = aligned([[title for title, _ in COLUMNS]] + [[show(row) for _, show in COLUMNS] for row in rows])
    means = []
    for key, title in SUMMARISED:
        values = [float(row[key]) for row in rows if row.get(key)]
        if len(values) > 1:
            means.append(f"{title} {geometric_mean(values):.3f} (of {len(values)})")
    if means:
        text += "\nGeometric means: " + ", ".join(means) + "\n"
    return text


def comparison(rows, before):
    earlier = {row["mesh"]: row for row in before}
    cells = [["now / before"] + [title for _, title in COMPARED]]
    for row in rows:
        old = earlier.get(row["mesh"])
        if old is None:
            continue
        ratios = [float(row[key]) / float(old[key]) if row.get(key) and old.get(key) else None for key, _ in COMPARED]
        cells.append([row["mesh"]] + ["-" if ratio is None else f"{ratio:.2f}" for ratio in ratios])
    return aligned(cells) if len(cells) > 1 else "No mesh is in the earlier run.\n"


def plot(path, rows, before):
    """Against the number of tets: what should not depend on it, and what should grow with it."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    panels = [
        ("processor time a collapse, us (QN)", [("qn_us_per_collapse", 1, "QN, 1 thread")]),
        ("peak memory, bytes a tet", [("qn_peak_bytes_per_tet", 1, "QN"), ("exact_peak_bytes_per_tet", 1, "default")]),
        ("processor seconds", [("qn_seconds", 1, "QN"), ("exact_seconds", 1, "default"),
                               ("vtk_seconds", 1, "VTK to 2%")]),
        ("file, bytes a tet", [("file_bytes", None, ".ptet"), ("vtu_bytes", None, "zlib VTU"),
                               ("zstd_bytes", None, "zstd -19")]),
        ("million tets a second, one core", [("decode_tets_per_second", 1e-6, "decode"),
                                             ("cut_tets_per_second", 1e-6, "cut at 1%")]),
        ("error at VTK's 10% of the tets, % of the range",
         [("max_percent", 1, "max"), ("vtk_max_percent", 1, "VTK max"), ("rms_percent", 1, "RMS"),
          ("vtk_rms_percent", 1, "VTK RMS")]),
    ]
    colours = ["#0b62c4", "#e07b00", "#2a9d3a", "#c72c2c"]
    kinds = sorted({kind_of(row) for row in rows})
    drawing, axes = plt.subplots(2, 3, figsize=(13.5, 7.6), layout="constrained")
    for panel, (title, series) in zip(axes.flat, panels):
        for colour, (key, scale, label) in zip(colours, series):
            for number, kind in enumerate(kinds):
                for source, style, alpha in ((before, ":", 0.5), (rows, "-", 1.0)):
                    points = sorted((int(r["tets"]), float(r[key]) * (scale or 1 / int(r["tets"])))
                                    for r in source if kind_of(r) == kind and r.get(key))
                    if not points:
                        continue
                    line = style if kind != "given" else "none"
                    panel.plot([x for x, _ in points], [y for _, y in points], color=colour, alpha=alpha,
                               linestyle=line, marker="os^Dv"[number % 5], markersize=4.5,
                               label=f"{label}, {kind}" + (" (before)" if source is before else ""))
        panel.set_visible(panel.has_data())
        panel.set_xscale("log")
        if title.startswith(("processor seconds", "error")):
            panel.set_yscale("log")
        else:
            panel.set_ylim(0, 1.05 * panel.dataLim.y1 if panel.has_data() else 1)
        panel.set_xlabel("tets")
        panel.set_title(title, fontsize=10)
        panel.grid(True, color="#dddddd", linewidth=0.7)
        panel.spines[["top", "right"]].set_visible(False)
        if panel.has_data():
            panel.legend(fontsize=7, frameon=False)
    drawing.savefig(path, dpi=100)
    plt.close(drawing)


def kind_of(row):
    kind = row["mesh"].split("_")[0]
    return kind if kind in ("cube", "ball") else "given"


def write(out, rows, before):
    keys = list(dict.fromkeys(key for row in rows for key in row))
    with open(os.path.join(out, "bench.csv"), "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, keys, lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()})
    text = table(rows) + ("\n" + comparison(rows, before) if before else "")
    with open(os.path.join(out, "bench.txt"), "w", encoding="utf-8") as file:
        file.write(text)
    plot(os.path.join(out, "bench.png"), rows, before)
    return text


def tet_count(text):
    scale = {"k": 1e3, "M": 1e6}.get(text[-1:], 1)
    return float(text[:-1] if scale > 1 else text) * scale


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="*")
    parser.add_argument("--generate", action="append", default=[], metavar="KIND:TETS",
                        help="a generated mesh (repeatable), such as ball:2M")
    parser.add_argument("--build", default="build", help="folder with the programs (default: build)")
    parser.add_argument("--field", action="append", default=[], help="governing field (repeatable; default: ptet's)")
    parser.add_argument("--runs", type=int, default=3, help="medians of so many runs (default: 3)")
    parser.add_argument("--exact-up-to", type=tet_count, default=math.inf, metavar="TETS",
                        help="the default build for meshes of at most so many tets")
    parser.add_argument("--errors-up-to", type=tet_count, default=math.inf, metavar="TETS", help="likewise for errors")
    parser.add_argument("--zstd-up-to", type=tet_count, default=math.inf, metavar="TETS", help="likewise for zstd -19")
    parser.add_argument("--no-peer", action="store_true", help="leave out VTK's filter, and errors beside it")
    parser.add_argument("--before", metavar="CSV", help="bench.csv of an earlier run, to compare with")
    parser.add_argument("--out", metavar="FOLDER", help="where bench.csv, bench.txt and bench.png go")
    parser.add_argument("--work", metavar="FOLDER", help="for temporary files, some 200 bytes a tet")
    options = parser.parse_args()
    if options.runs < 1:
        parser.error("--runs: at least 1")
    if not options.mesh and not options.generate:
        parser.error("a mesh, or --generate KIND:TETS, is wanted")
    for name in PROGRAMS:
        if not os.access(os.path.join(options.build, name), os.X_OK):
            sys.exit(f"bench.py: no {name} in {options.build}; build with -DPTET_BUILD_BENCH=ON")
    before = []
    if options.before:
        with open(options.before, newline="", encoding="utf-8") as file:
            before = list(csv.DictReader(file))
    if options.out:
        os.makedirs(options.out, exist_ok=True)

    rows = []
    with tempfile.TemporaryDirectory(dir=options.work) as folder:
        bench = Bench(options, folder)
        for given, mesh in [(True, m) for m in options.mesh] + [(False, g) for g in options.generate]:
            say(mesh)
            path = mesh if given else bench.generate(mesh)
            rows.append(bench.measure(path))
            if not given:
                os.remove(path)
            if options.out:
                write(options.out, rows, before)  # anew after each mesh, so that a long run loses nothing
    print(table(rows), end="")
    if before:
        print("\n" + comparison(rows, before), end="")


if __name__ == "__main__":
    main()
