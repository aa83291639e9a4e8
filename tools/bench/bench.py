#!/usr/bin/env python3
"""Measures ptet on meshes and prints a table; medians of several runs.

    bench.py MESH.vtu [MESH.vtu ...]

Needs a build with -DPTET_BUILD_BENCH=ON (package libbenchmark-dev) and VTK's Python modules (python3-vtk9). What the
columns are:

  to vtx         vertices of the coarsest mesh
  build s        wall time of `ptet build --threads 1 --method QN --evaluate vertices`, reading and writing included
  exact s        wall time of `ptet build` as it is by default, exact errors included, all cores
  kcollapses/s   of the collapse loop alone, one thread, in thousands
  B/tet peak     largest resident memory of that process, per tet of the input
  file B, B/vtx  the .ptet file with all its levels, per vertex of the input
  of VTU         the same, beside the VTU of the input with zlib and 32-bit ids
  open+1% s      a new process: open the file and cut at a field error of 1%
  cut Mtets/s    the whole mesh, and a field error of 1%, from a file in memory, in million tets a second
  VTK s, to tets the peer: vtkUnstructuredGridQuadricDecimation of the same mesh, asked for 2% of its tets
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter

PROGRAMS = ("ptet", "cut_bench", "vtk_decimate")


def run(command):
    """Standard output, wall time in seconds, and peak resident bytes of a process."""
    with tempfile.TemporaryFile() as out:
        start = time.monotonic()
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out)
        _, status, usage = os.wait4(child.pid, 0)
        seconds = time.monotonic() - start
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            sys.exit(f"bench.py: exit code {child.returncode} of: {' '.join(command)}")
        out.seek(0)
        return out.read().decode(), seconds, usage.ru_maxrss * 1024


def vtu_bytes(mesh, folder):
    """Size of the mesh as VTU, raw appended, zlib, 32-bit ids and headers."""
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(mesh)
    path = os.path.join(folder, "reference.vtu")
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputConnection(reader.GetOutputPort())
    writer.SetFileName(path)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToZLib()
    writer.SetHeaderTypeToUInt32()
    writer.SetIdTypeToInt32()
    writer.Write()
    return os.path.getsize(path)


def measure(mesh, options, folder):
    ptet, cut_bench, vtk_decimate = (os.path.join(options.build, name) for name in PROGRAMS)
    file = os.path.join(folder, "bench.ptet")
    fields = [part for name in options.field for part in ("--field", name)]

    builds = []
    for _ in range(options.runs):
        out, seconds, peak = run([ptet, "build", mesh, "-o", file, "--threads", "1", "--method", "QN", "--evaluate",
                                  "vertices", "--json", "--force", *fields])
        builds.append((seconds, peak, json.loads(out)))
    report = builds[0][2]
    _, exact_seconds, _ = run([ptet, "build", mesh, "-o", file, "--json", "--force", *fields])
    vertices, tets = report["input"]["vertices"], report["input"]["tets"]

    opens = [json.loads(run([ptet, "extract", file, "--field-error", "1%", "--json"])[0]) for _ in range(options.runs)]
    out, _, _ = run([cut_bench, file, "--benchmark_format=json", f"--benchmark_repetitions={options.runs}",
                     "--benchmark_report_aggregates_only=true"])
    cuts = {row["run_name"]: row["items_per_second"] for row in json.loads(out)["benchmarks"]
            if row.get("aggregate_name", "median") == "median"}
    if options.no_peer:
        peer = None
    else:
        peers = [json.loads(run([vtk_decimate, mesh, "0.02"])[0]) for _ in range(options.runs)]
        peer = {"seconds": statistics.median(p["seconds"] for p in peers), "tets": peers[0]["tets"]}

    file_bytes = os.path.getsize(file)
    return {
        "mesh": os.path.splitext(os.path.basename(mesh))[0],
        "vertices": vertices,
        "tets": tets,
        "base_vertices": report["base"]["vertices"],
        "build_seconds": statistics.median(seconds for seconds, _, _ in builds),
        "collapses_per_second": statistics.median(r["collapses_per_second"] for _, _, r in builds),
        "exact_seconds": exact_seconds,
        "peak_bytes_per_tet": statistics.median(peak for _, peak, _ in builds) / tets,
        "file_bytes": file_bytes,
        "bytes_per_vertex": file_bytes / vertices,
        "ratio_to_vtu": file_bytes / vtu_bytes(mesh, folder),
        "open_and_cut_seconds": statistics.median(r["seconds"] for r in opens),
        "cut_tets_per_second": cuts,
        "vtk_decimation": peer,
    }


COLUMNS = [
    ("mesh", lambda r: r["mesh"]),
    ("tets", lambda r: f"{r['tets']:,}"),
    ("to vtx", lambda r: f"{100 * r['base_vertices'] / r['vertices']:.1f}%"),
    ("build s", lambda r: f"{r['build_seconds']:.2f}"),
    ("kcollapses/s", lambda r: f"{r['collapses_per_second'] / 1e3:.1f}"),
    ("exact s", lambda r: f"{r['exact_seconds']:.1f}"),
    ("B/tet peak", lambda r: f"{r['peak_bytes_per_tet']:.0f}"),
    ("file B", lambda r: f"{r['file_bytes']:,}"),
    ("B/vtx", lambda r: f"{r['bytes_per_vertex']:.1f}"),
    ("of VTU", lambda r: f"{r['ratio_to_vtu']:.3f}"),
    ("open+1% s", lambda r: f"{r['open_and_cut_seconds']:.3f}"),
    ("cut Mtets/s", lambda r: f"{r['cut_tets_per_second']['whole mesh'] / 1e6:.1f}, "
                              f"{r['cut_tets_per_second']['field error 1%'] / 1e6:.1f}"),
    ("VTK s", lambda r: "-" if r["vtk_decimation"] is None else f"{r['vtk_decimation']['seconds']:.2f}"),
    ("VTK to tets", lambda r: "-" if r["vtk_decimation"] is None
                              else f"{100 * r['vtk_decimation']['tets'] / r['tets']:.1f}%"),
]


def print_table(rows):
    cells = [[title for title, _ in COLUMNS]] + [[show(row) for _, show in COLUMNS] for row in rows]
    widths = [max(len(line[i]) for line in cells) for i in range(len(COLUMNS))]
    for number, line in enumerate(cells):
        print("| " + " | ".join(cell.ljust(w) if i == 0 else cell.rjust(w)
                                for i, (cell, w) in enumerate(zip(line, widths))) + " |")
        if number == 0:
            print("|" + "|".join("-" * (w + 1) + (":" if i else "-") for i, w in enumerate(widths)) + "|")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="+")
    parser.add_argument("--build", default="build", help="folder with the programs (default: build)")
    parser.add_argument("--field", action="append", default=[], help="governing field (repeatable; default: ptet's)")
    parser.add_argument("--runs", type=int, default=3, help="medians of so many runs (default: 3)")
    parser.add_argument("--no-peer", action="store_true", help="leave out VTK's filter")
    parser.add_argument("--json", action="store_true", help="one JSON object a mesh, instead of the table")
    options = parser.parse_args()
    if options.runs < 1:
        parser.error("--runs: at least 1")
    for name in PROGRAMS:
        if not os.access(os.path.join(options.build, name), os.X_OK):
            sys.exit(f"bench.py: no {name} in {options.build}; build with -DPTET_BUILD_BENCH=ON")

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for mesh in options.mesh:
            print(f"bench.py: {mesh}", file=sys.stderr)
            rows.append(measure(mesh, options, folder))
            if options.json:
                print(json.dumps(rows[-1]), flush=True)
    if not options.json:
        print_table(rows)


if __name__ == "__main__":
    main()
