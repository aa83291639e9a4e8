"""What builds and measurements come to, as a user has them: methods, checkpoints, memory, errors measured, real meshes.
Usage: test_builds.py PTET [unittest options]

Real meshes are looked for in the folder that PTET_DATA names (default: shared/data beside the source tree)."""
import json
import math
import os
import pathlib
import resource
import signal
import subprocess
import sys
import time

sys.dont_write_bytecode = True  # leaves the source tree as it is
import case  # noqa: E402
import meshes  # noqa: E402
from case import Case, program  # noqa: E402

FIXTURES = pathlib.Path(__file__).resolve().parents[1] / "fixtures"
DATA = pathlib.Path(os.environ.get("PTET_DATA") or
                    pathlib.Path(__file__).resolve().parents[3] / "shared" / "data")

METHODS = {  # predict, evaluate
    "exact": ("exact", "exact"), "LN": ("local", "none"), "GN": ("gradient", "none"), "QN": ("quadric", "none"),
    "BF": ("simulate", "vertices"), "BFS": ("simulate", "samples"), "staadt-gross": ("weighted-sum", "none"),
    "trotts": ("per-tet", "none"),
}


class Checkpoints(Case):
    def interrupted(self, *arguments, name=signal.SIGTERM):
        """Starts a build that keeps checkpoints, and sends it the signal once they get smaller: the first rounds on a
        grid measure much and take nothing, and what is taken needs no measurements any more."""
        checkpoint = self.folder / "b.ckpt"
        with subprocess.Popen([program(), "build", "grid.vtu", "--checkpoint", checkpoint.name, "--checkpoint-every", "0",
                               *arguments], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
            size = largest = 0
            while size >= largest and run.poll() is None:
                time.sleep(0.001)
                size = checkpoint.stat().st_size if checkpoint.exists() else 0
                largest = max(largest, size)
            run.send_signal(name)
            out, err = run.communicate(timeout=120)
        self.assertEqual((run.returncode, out), (130, b""), err)
        self.assertIn(b"ptet: interrupted; what was done is in 'b.ckpt'", err)
        self.assertIn(b"--resume", err)
        self.assertEqual(self.files(), ["b.ckpt", "grid.vtu"])

    def test_a_build_goes_on_after_a_signal(self):
        self.grid(12)
        self.ptet("build", "grid.vtu", "-o", "whole.ptet", "-q")
        whole = (self.folder / "whole.ptet").read_bytes()
        (self.folder / "whole.ptet").unlink()
        for name in [signal.SIGTERM, signal.SIGINT]:
            with self.subTest(signal=name):
                self.interrupted(name=name)
                report = self.json("build", "grid.vtu", "--checkpoint", "b.ckpt", "--resume", "--threads", "1")
                self.assertGreater(report["resumed_records"], 0)
                self.assertGreater(report["checkpoints"]["bytes"], 0)
                self.assertEqual(self.files(), ["grid.ptet", "grid.vtu"])
                self.assertEqual((self.folder / "grid.ptet").read_bytes(), whole)
                (self.folder / "grid.ptet").unlink()

    def test_a_full_disk_takes_nothing_that_was_kept(self):
        self.grid(12)
        self.interrupted()
        kept = (self.folder / "b.ckpt").read_bytes()
        full = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))}
        resume = ["build", "grid.vtu", "--checkpoint", "b.ckpt", "--checkpoint-every", "0", "--resume", "-q"]
        done = self.ptet(*resume, code=6, **full)
        self.assertIn("what was done before is in 'b.ckpt'", done.stderr)
        self.assertEqual((self.folder / "b.ckpt").read_bytes(), kept)
        self.assertEqual(self.files(), ["b.ckpt", "grid.vtu"])
        self.ptet(*resume)

    def test_what_does_not_fit_is_refused(self):
        self.grid(12)
        self.interrupted()
        kept = (self.folder / "b.ckpt").read_bytes()
        resume = ["build", "grid.vtu", "--checkpoint", "b.ckpt", "--resume"]
        self.refused(2, *resume, "--max-star", "40", says=["max-star 64", "40"])
        self.refused(2, *resume, "--field", "bumpy", says=["field"])
        self.refused(2, "build", "grid.vtu", "--checkpoint", "b.ckpt", says=["there already", "--resume"])
        self.refused(6, "build", "grid.vtu", "--checkpoint", "c.ckpt", "--resume", says=["c.ckpt"])
        self.refused(2, "build", "grid.vtu", "--resume", says=["--resume", "--checkpoint FILE"])
        self.refused(2, "build", "grid.vtu", "--checkpoint-every", "5m", says=["--checkpoint FILE"])
        for bad in ["", "5d", "-1", "x", "inf"]:
            self.refused(2, "build", "grid.vtu", "--checkpoint", "c.ckpt", f"--checkpoint-every={bad}",
                         says=["--checkpoint-every"])
        self.refused(2, "build", "grid.vtu", "--checkpoint", "grid.vtu", says=["input"])
        self.refused(2, "build", "grid.vtu", "--checkpoint", "grid.ptet", says=["output"])
        self.grid(11)
        self.refused(2, *resume, says=["another mesh"])
        self.grid(12)
        for damaged in [kept[:-1], kept[:10], kept[:300] + b"x" + kept[301:], b"", b"what is this"]:
            (self.folder / "b.ckpt").write_bytes(damaged)
            self.refused(4, *resume, says=["b.ckpt", "cannot be used"])
        self.assertEqual(self.files(), ["b.ckpt", "grid.vtu"])


class Memory(Case):
    def test_what_a_build_takes_was_foreseen(self):
        points, tets = meshes.grid(22)  # 64 thousand tets: the program itself is no more than half of it
        fields = meshes.wave(points)
        # Smooth: all measured collapses wait for one another.
        fields["flow"] = ("Float64", [(math.sin(6 * x), math.cos(4 * y), x * y) for x, y, _ in points])
        meshes.vtu(self.folder / "grid.vtu", points, tets, fields)
        for arguments in [["--method", "QN"], ["--method", "QN", "--keep-order"],
                          ["--threads", "2", "--target-vertices", "40%"], ["--threads", "2"],
                          ["--field", "smooth", "--evaluate", "vertices", "--threads", "1"]]:
            with self.subTest(arguments):
                report = self.json("build", "grid.vtu", *arguments)
                peak, foreseen = report["peak_memory_bytes"], report["foreseen_memory_bytes"]
                self.assertEqual(report["peak_memory_bytes_per_tet"], peak / report["input"]["tets"])
                self.assertGreater(peak, 200 * report["input"]["tets"])
                if b"__asan_init" in pathlib.Path(program()).read_bytes():
                    continue  # there is more than the program asks for
                self.assertLessEqual(peak, foreseen)
                self.assertLessEqual(foreseen, 1.3 * peak + 40e6)  # the program and its libraries do not grow

    def test_what_many_fields_and_threads_take_was_foreseen(self):
        points, tets = meshes.grid(16)
        fields = {f"f{i}": ("Float64", [math.sin(i + x) * y + z for x, y, z in points]) for i in range(50)}
        meshes.vtu(self.folder / "many.vtu", points, tets, fields)
        for threads in "1", "8":
            report = self.json("build", "many.vtu", "--method", "QN", "--threads", threads)
            if b"__asan_init" in pathlib.Path(program()).read_bytes():
                continue
            self.assertLessEqual(report["peak_memory_bytes"], 1.05 * report["foreseen_memory_bytes"])

    def test_pieces_of_a_file_are_welded_where_that_is_asked_for(self):
        points, tets = meshes.grid(6)
        sides = [[t for t in tets if (sum(points[v][0] for v in t) < 2) == left] for left in (True, False)]
        for name, side in zip(("left", "right"), sides):
            used = sorted({v for tet in side for v in tet})
            place = {v: i for i, v in enumerate(used)}
            at = [points[v] for v in used]
            meshes.vtu(self.folder / f"{name}.vtu", at, [[place[v] for v in tet] for tet in side], meshes.wave(at))
        (self.folder / "both.pvtu").write_text(
            '<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="LittleEndian"><PUnstructuredGrid GhostLevel="0">'
            '<PPointData><PDataArray type="Float64" Name="smooth"/><PDataArray type="Float32" Name="bumpy"/></PPointData>'
            '<PPoints><PDataArray type="Float64" Name="Points" NumberOfComponents="3"/></PPoints>'
            '<Piece Source="left.vtu"/><Piece Source="right.vtu"/></PUnstructuredGrid></VTKFile>', encoding="ascii")
        meshes.vtu(self.folder / "one.vtu", points, tets, meshes.wave(points))
        quick = ["--method", "QN", "--target-vertices", "20%"]
        apart = self.json("build", "both.pvtu", *quick, "-o", "apart.ptet")
        welded = self.json("build", "both.pvtu", *quick, "--weld", "-o", "welded.ptet")
        self.assertEqual((apart["weld"], welded["weld"]), (False, True))
        self.assertGreater(apart["input"]["vertices"], len(points))
        self.assertEqual(welded["input"]["vertices"], len(points))
        self.assertEqual(welded["base"]["vertices"], math.ceil(0.2 * len(points)))
        self.assertEqual(welded["input"]["bytes"],
                         sum((self.folder / name).stat().st_size for name in ("both.pvtu", "left.vtu", "right.vtu")))
        self.assertTrue(any("points were welded" in note for note in welded["notes"]))
        for original in ("both.pvtu", "one.vtu"):
            self.assertTrue(self.json("verify", "welded.ptet", "--original", original)["ok"])
        self.ptet("verify", "apart.ptet", "--original", "one.vtu", code=4)
        self.ptet("build", "both.pvtu", *quick, "--weld", "--keep-order", "--pieces", "2", "-o", "kept.ptet")
        verified = self.json("verify", "kept.ptet", "--original", "both.pvtu")
        self.assertTrue(verified["ok"])
        self.assertTrue(any("as in the build" in note and "welded" in note for note in verified["notes"]))
        self.assertFalse(any("byte for byte" in note for note in verified["notes"]))
        with open(self.folder / "right.vtu", "ab") as piece:
            piece.write(b"\n")
        verified = self.json("verify", "kept.ptet", "--original", "both.pvtu")
        self.assertTrue(verified["ok"])
        self.assertTrue(any("byte for byte" in note for note in verified["notes"]))
        # The pieces are input, too.
        piece = (self.folder / "left.vtu").read_bytes()
        self.refused(2, "build", "both.pvtu", *quick, "--force", "-o", "left.vtu", says=["left.vtu", "a piece of"])
        self.refused(2, "build", "both.pvtu", *quick, "-o", "x.ptet", "--checkpoint", "right.vtu", says="a piece of")
        self.refused(2, "extract", "welded.ptet", "--tets", "50%", "-o", "left.vtu", says="a piece of")
        self.refused(2, "measure", "both.pvtu", "one.vtu", "--errors", "left.vtu", says="a piece of")
        self.refused(2, "measure", "one.vtu", "both.pvtu", "--errors", "left.vtu", says="a piece of")
        self.assertEqual((self.folder / "left.vtu").read_bytes(), piece)
        self.ptet("extract", "welded.ptet", "--tets", "50%", "-o", "half.vtu")
        topologies = [self.json("measure", "both.pvtu", "half.vtu", *flag)["original"]["validity"]["components"]
                      for flag in ([], ["--weld"])]
        self.assertEqual(topologies, [2, 1])

    def test_what_rounding_has_set_apart_is_welded_within_a_distance(self):
        points, tets = meshes.grid(6)
        sides = [[t for t in tets if (sum(points[v][0] for v in t) < 2) == left] for left in (True, False)]
        at, joined = [], []
        for move, side in zip((0, 1e-15), sides):
            used = sorted({v for tet in side for v in tet})
            place = {v: len(at) + i for i, v in enumerate(used)}
            at += [tuple(x + move for x in points[v]) for v in used]
            joined += [[place[v] for v in tet] for tet in side]
        meshes.vtu(self.folder / "parts.vtu", at, joined, meshes.wave(at))
        quick = ["--method", "QN", "--target-vertices", "20%"]
        told = self.json("info", "parts.vtu")
        near = [finding for finding in told["findings"] if finding["code"] == "near-points"]
        self.assertEqual([finding["count"] for finding in near], [len(at) - len(points)])
        apart = self.json("build", "parts.vtu", *quick, "--weld", "-o", "apart.ptet")
        self.assertEqual(apart["input"]["vertices"], len(at))
        self.assertTrue(any("--weld-within" in note for note in apart["notes"]))
        for within in "1e-10%", "1e-12":
            welded = self.json("build", "parts.vtu", *quick, "--weld-within", within, "--keep-order", "--force",
                               "-o", "welded.ptet")
            self.assertTrue(welded["weld"])
            self.assertEqual(welded["input"]["vertices"], len(points))
            self.assertEqual(welded["base"]["vertices"], math.ceil(0.2 * len(points)))
            self.assertFalse(any("--weld-within" in note for note in welded["notes"]))
            verified = self.json("verify", "welded.ptet", "--original", "parts.vtu")
            self.assertTrue(verified["ok"])
            self.assertTrue(any("nearly the same place" in note for note in verified["notes"]))
        meshes.vtu(self.folder / "tiny.vtu", [(1e-12 * x, 1e-12 * y, 1e-12 * z) for x, y, z in at], joined,
                   meshes.wave(at))
        other = json.loads(self.ptet("verify", "welded.ptet", "--original", "tiny.vtu", "--json", code=4).stdout)
        self.assertTrue(any("cannot be welded as in the build" in wrong for wrong in other["wrong"]), other["wrong"])
        self.ptet("extract", "welded.ptet", "--tets", "50%", "-o", "half.vtu")
        topologies = [self.json("measure", "parts.vtu", "half.vtu", *flag)["original"]["validity"]["components"]
                      for flag in (["--weld"], ["--weld-within", "1e-12"])]
        self.assertEqual(topologies, [2, 1])
        self.refused(2, "build", "parts.vtu", *quick, "--weld-within", "1%", "-o", "x.ptet",
                     says="within a thousandth of the diagonal")
        self.refused(2, "build", "parts.vtu", *quick, "--weld-within", "near", "-o", "x.ptet", says="--weld-within 'near'")

    def test_a_limit_is_kept_before_it_is_passed(self):
        self.grid(16)
        self.ptet("build", "grid.vtu", "-q")
        whole = (self.folder / "grid.ptet").read_bytes()
        self.ptet("build", "grid.vtu", "-q", "--memory-limit", "64GiB")
        self.assertEqual((self.folder / "grid.ptet").read_bytes(), whole)
        (self.folder / "grid.ptet").unlink()
        # The head of the file is enough; then the counts of the mesh, before anything is made of it.
        self.refused(5, "build", "grid.vtu", "--memory-limit", "1M", says=["reading 24,576 cells", "the limit is 1,000,000"])
        self.refused(5, "build", "grid.vtu", "--memory-limit", "40M", "--threads", "2",
                     says=["24576 tets", "is foreseen to take", "the limit is 40 MB"])
        self.assertEqual(self.files(), ["grid.vtu"])

    def test_a_limit_is_for_every_format(self):
        for name in ["vtk_42_all.vtk", "vtk_51_all.vtk", "meshio_42.vtk", "two_blocks.ex2", "two_pieces.pvtu",
                     "meshio_ascii.vtu", "meshio_lzma.vtu", "vtk_appended_base64_lz4.vtu"]:
            mesh = FIXTURES / name
            with self.subTest(name):
                self.ptet("build", mesh, "-o", "a.ptet", "-q")
                self.ptet("build", mesh, "-o", "b.ptet", "-q", "--memory-limit", "64GiB")
                self.assertEqual((self.folder / "a.ptet").read_bytes(), (self.folder / "b.ptet").read_bytes())
                self.refused(5, "build", mesh, "-o", "c.ptet", "--memory-limit", "100",
                             says=[f"{name}: reading ", "the limit is 100"])
                self.assertEqual(self.files(), ["a.ptet", "b.ptet"])

    def test_cells_that_become_several_tets_are_foreseen(self):
        # A hexahedron has eight ids where it is read, and gives six tets.
        points = [(x, y, z) for z in range(21) for y in range(21) for x in range(21)]
        corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
        cells = [tuple(x + dx + 21 * (y + dy + 21 * (z + dz)) for dx, dy, dz in corners)
                 for z in range(20) for y in range(20) for x in range(20)]
        with open(self.folder / "hexes.vtk", "w", encoding="ascii") as file:
            rows = ["# vtk DataFile Version 4.2", "hexahedra", "ASCII", "DATASET UNSTRUCTURED_GRID",
                    f"POINTS {len(points)} float", *[f"{x} {y} {z}" for x, y, z in points],
                    f"CELLS {len(cells)} {9 * len(cells)}", *["8 " + " ".join(map(str, cell)) for cell in cells],
                    f"CELL_TYPES {len(cells)}", *["12"] * len(cells)]
            file.write("\n".join(rows) + "\n")
        self.refused(5, "build", "hexes.vtk", "--memory-limit", str(8000 * (5 * 16 + 8 * 4) + 12 * len(points)),
                     says="reading 8,000 cells")


class Asked(Case):
    """What goes in and out, as the user names it."""

    def test_a_mesh_is_not_the_name_of_a_file_of_levels(self):
        points, tets = meshes.grid(2)
        meshes.vtu(self.folder / "fine.vtu", points, tets, meshes.wave(points))
        self.refused(2, "build", "fine.vtu", "-o", "coarse.vtu", says=["coarse.vtu", ".ptet", "--force"])
        self.assertEqual(self.files(), ["fine.vtu"])
        self.ptet("build", "fine.vtu", "-o", "coarse.vtu", "--method", "QN", "--force")
        self.assertIn("coarse.vtu", self.files())

    def test_values_that_only_cells_have_are_asked_for_at_the_points(self):
        points, tets = meshes.grid(2)
        whole = pathlib.Path(meshes.vtu(self.folder / "points.vtu", points, tets, {"p": ("Float32", [0.5] * 27)}))
        values = ('<CellData><DataArray type="Float32" Name="T" format="ascii">' + "1 " * len(tets) +
                  "</DataArray></CellData>\n")
        text = whole.read_text(encoding="ascii").replace("</PointData>\n", "</PointData>\n" + values)
        (self.folder / "both.vtu").write_text(text, encoding="ascii")
        before, after = text.split("<PointData>")[0], text.split("</PointData>")[1]
        (self.folder / "cells.vtu").write_text(before + after, encoding="ascii")
        self.refused(2, "build", "both.vtu", "--field", "T", says=["only cells", "'T'", "Cell Data to Point Data"])
        self.refused(2, "build", "both.vtu", "--field", "U", says=["there is no point array 'U'", "'p'"])
        said = "only cells have values: give them to the points first"
        self.assertNotIn(said, self.ptet("build", "both.vtu").stdout)
        self.assertIn(said, self.ptet("build", "cells.vtu").stdout)
        self.assertIn("cell array 'T' is not carried", self.json("info", "both.vtu")["notes"])


class Methods(Case):
    def built(self, *arguments):
        """The report of a build of the grid; the file's own word on how it was built must be the same."""
        report = self.json("build", "grid.vtu", *arguments)
        self.ptet("verify", "grid.ptet", "--original", "grid.vtu")
        options = self.json("info", "grid.ptet")["manifest"]["options"]
        self.assertEqual((options["predict"], options["evaluate"], options.get("objective")),
                         (report["predict"], report["evaluate"], report["objective"]))
        return report

    def test_all_by_name(self):
        self.grid(5)
        built = set()
        for method, ways in METHODS.items():
            with self.subTest(method):
                report = self.built("--method", method)
                self.assertEqual((report["method"], report["predict"], report["evaluate"]), (method, *ways))
                simulates = ways[0] in ("exact", "simulate")
                self.assertEqual(report["objective"], "both" if simulates else None)
                self.assertEqual(report["simulations"] > 0, simulates)
                self.assertEqual(report["exact_evaluations"] > 0, method == "exact")
                self.assertGreater(report["records"], 100)
                self.assertIn(f"{method}: predict {ways[0]}, evaluate {ways[1]}",
                              self.ptet("build", "grid.vtu", "--method", method).stdout)
                built.add((self.folder / "grid.ptet").read_bytes())
        self.assertEqual(len(built), len(METHODS))

    def test_exact_is_the_default(self):
        self.grid(4)
        self.assertEqual(self.built()["method"], "exact")
        default = (self.folder / "grid.ptet").read_bytes()
        for arguments in [["--method", "exact"], ["--predict", "exact"], ["--evaluate", "exact"],
                          ["--objective", "both"]]:
            self.built(*arguments)
            self.assertEqual((self.folder / "grid.ptet").read_bytes(), default)

    def test_objectives(self):
        self.grid(8)
        for method in ["exact", "BF"]:
            files = set()
            for objective in ["max", "rms", "both"]:
                self.assertEqual(self.built("--method", method, "--objective", objective)["objective"], objective)
                files.add((self.folder / "grid.ptet").read_bytes())
            self.assertEqual(len(files), 3)

    def test_the_two_axes(self):
        self.grid(4)
        for predict in ["local", "gradient", "quadric", "simulate", "weighted-sum", "per-tet"]:
            report = self.built("--predict", predict)
            self.assertEqual((report["predict"], report["evaluate"], report["method"]), (predict, "exact", None))
        # An evaluation by itself goes with quadrics, for ours measures everywhere.
        for evaluate in ["none", "vertices", "samples"]:
            report = self.built("--evaluate", evaluate)
            self.assertEqual((report["predict"], report["evaluate"]), ("quadric", evaluate))
            self.assertEqual(report["method"], "QN" if evaluate == "none" else None)
        report = self.built("--method", "BF", "--evaluate", "samples")
        self.assertEqual(report["method"], "BFS")
        report = self.built("--method", "LN", "--evaluate", "exact")
        self.assertEqual((report["predict"], report["evaluate"]), ("local", "exact"))

    def test_what_is_refused(self):
        self.grid(2)
        names = {"--method": METHODS, "--objective": ["max", "rms", "both"],
                 "--predict": [predict for predict, _ in METHODS.values()],
                 "--evaluate": ["exact", "samples", "vertices", "none"]}
        for option, known in names.items():
            for wrong in ["", "nope", "EXACT", "ex"]:
                with self.subTest(option=option, wrong=wrong):
                    self.refused(2, "build", "grid.vtu", option, wrong,
                                 says=[option, f"'{wrong}'", *(f"'{name}'" for name in known)])
        for evaluate in ["none", "vertices", "samples"]:
            for chosen in ["--method", "--predict"]:
                self.refused(2, "build", "grid.vtu", chosen, "exact", "--evaluate", evaluate,
                             says=["--evaluate exact", "--predict"])
        self.refused(2, "build", "grid.vtu", "--method", "BF", "--predict", "exact", says="--evaluate exact")
        for chosen in [["--method", "QN"], ["--evaluate", "none"], ["--predict", "gradient"]]:
            self.refused(2, "build", "grid.vtu", "--objective", "rms", *chosen, says=["--objective", "BFS"])
        self.assertEqual(self.files(), ["grid.vtu"])


class Measure(Case):
    """ORIGINAL is a cube of side 1 with 6 x 6 x 6 cells; SIMPLIFIED is what each test makes of it."""

    def cube(self, name, n, fields, origin=(0.0, 0.0, 0.0), turned=()):
        points, tets = meshes.grid(n, origin)
        for t in turned:
            tets[t] = [tets[t][i] for i in (1, 0, 2, 3)]
        meshes.vtu(self.folder / name, points, tets, fields(points))

    @staticmethod
    def quadratic(points):
        return {"q": ("Float64", [x * x for x, _, _ in points]),
                "flow": ("Float32", [(x, 2 * y, z) for x, y, z in points])}

    def test_quadratic_field_on_a_coarser_grid(self):
        self.cube("fine.vtu", 8, self.quadratic)
        self.cube("coarse.vtu", 2, self.quadratic)
        report = self.json("measure", "fine.vtu", "coarse.vtu")
        # x^2 interpolated over cells of 1/2 and of 1/8: apart most in the middle of the large ones, by (1/4)^2.
        inside = report["inside"]["fields"]
        self.assertAlmostEqual(inside["q"]["max"], 1 / 16, delta=1e-12)
        self.assertAlmostEqual(inside["q"]["max_percent"], 100 / 16, delta=1e-9)
        # The two are a parabola's chords; the square of their difference, integrated cell by cell in x.
        def chord(x, h):
            low = min(int(x / h), round(1 / h) - 1) * h
            return low * low + (x - low) * (2 * low + h)
        knots = [i / 8 for i in range(9)]
        square = sum((b - a) / 3 * (f * f + f * g + g * g) for a, b in zip(knots, knots[1:])
                     for f, g in [(chord(a, 0.5) - a * a, chord(b, 0.5) - b * b)])
        self.assertAlmostEqual(inside["q"]["rms"], square ** 0.5, delta=1e-12)
        self.assertLess(inside["flow"]["max"], 1e-7)
        self.assertAlmostEqual(report["ranges"]["flow"], 6 ** 0.5, delta=1e-6)
        self.assertAlmostEqual(report["overlap"]["volume"], 1, delta=1e-12)
        self.assertEqual(report["outside"]["vertices"] + report["outside"]["points"], 0)
        self.assertLess(report["hausdorff"]["symmetric"]["upper"], 1e-8)
        self.assertTrue(report["simplified"]["validity"]["valid"])
        self.assertEqual(report["simplified"]["validity"]["euler_characteristic"], 1)
        text = self.ptet("measure", "fine.vtu", "coarse.vtu", "--field", "q").stdout
        for word in ["6.25%", "exact", "Euler characteristic 1", "manifold"]:
            self.assertIn(word, text)
        self.assertNotIn("flow", text)

    def test_samples(self):
        self.cube("fine.vtu", 6, self.quadratic)
        self.cube("coarse.vtu", 2, self.quadratic)
        exact = self.json("measure", "fine.vtu", "coarse.vtu", "--exact")["inside"]["fields"]["q"]
        runs = [self.json("measure", "fine.vtu", "coarse.vtu", "--samples", 20000, "--seed", seed, "--threads", threads)
                for seed, threads in [(1, 1), (1, 3), (2, 1)]]
        found = [run["inside"]["fields"]["q"] for run in runs]
        self.assertEqual(found[0], found[1])
        self.assertNotEqual(found[0], found[2])
        self.assertEqual(runs[0]["inside"]["points"], 20000)
        self.assertLessEqual(found[0]["max"], exact["max"] + 1e-12)
        self.assertAlmostEqual(found[0]["rms"], exact["rms"], delta=0.02 * exact["rms"])

    def test_a_shifted_mesh(self):
        self.cube("fine.vtu", 4, self.quadratic)
        self.cube("shifted.vtu", 4, self.quadratic, origin=(0.25, 0.0, 0.0))
        report = self.json("measure", "fine.vtu", "shifted.vtu", "--field", "q")
        self.assertAlmostEqual(report["overlap"]["volume"], 0.75, delta=1e-12)
        self.assertEqual(report["outside"]["vertices"], 25)
        self.assertAlmostEqual(report["outside"]["fields"]["q"]["max"], 1 / 16, delta=1e-12)  # (1/4)^2 against 0
        for way in ["original_to_simplified", "simplified_to_original", "symmetric"]:
            bounds = report["hausdorff"][way]
            self.assertLessEqual(bounds["lower"], 0.25 + 1e-12)
            self.assertGreaterEqual(bounds["upper"], 0.25 - 1e-12)
            self.assertLessEqual(bounds["upper"], 1.0101 * bounds["lower"])

    def test_rms_and_volume_of_what_is_covered(self):
        """A ball loses volume. What is stated of what is left is what `measure` finds, which looks at meshes alone."""
        points, tets = meshes.grid(10)
        centred = [[2 * x - 1 for x in p] for p in points]
        points = [[x * max(map(abs, p)) / max(math.dist(p, (0, 0, 0)), 1e-9) for x in p] for p in centred]
        meshes.vtu(self.folder / "ball.vtu", points, tets, self.quadratic(points))
        self.ptet("build", "ball.vtu", "-o", "ball.ptet")
        info = self.json("info", "ball.ptet")
        least = 1.0
        for request in (["--vertices", "1"], ["--vertices", "120"], ["--vertices", "50%"], ["--field-error", "2%"],
                        ["--vertices", "30", "--focus", "sphere:0.9,0,0,0.3"]):
            with self.subTest(request):
                achieved = self.json("extract", "ball.ptet", "-o", "part.vtu", *request)["achieved"]
                report = self.json("measure", "ball.vtu", "part.vtu")
                covered = report["overlap"]["volume"] / report["original"]["volume"]
                self.assertLessEqual(achieved["covered"], covered + 1e-9)
                self.assertGreaterEqual(achieved["covered"], covered - 0.1 * (1 - covered) - 0.005)
                least = min(least, covered)
                for name, found in report["inside"]["fields"].items():
                    self.assertGreaterEqual(achieved["rms_error"][name], found["rms"] * (1 - 1e-6))
                    self.assertLessEqual(achieved["rms_error"][name], 1.1 * found["rms"])
        self.assertLess(least, 0.95)
        base = self.json("extract", "ball.ptet", "--vertices", "1")["achieved"]
        self.assertEqual(info["base_covered"], base["covered"])
        self.assertIn("of the volume uncovered by the base", self.ptet("info", "ball.ptet").stdout)
        self.assertIn("of the volume uncovered", self.ptet("extract", "ball.ptet", "--vertices", "1").stdout)
        whole = self.ptet("extract", "ball.ptet")
        self.assertNotIn("uncovered", whole.stdout)
        self.assertEqual(self.json("extract", "ball.ptet")["achieved"]["covered"], 1)
        self.ptet("build", "ball.vtu", "-o", "seen.ptet", "--method", "QN", "--evaluate", "vertices")
        self.assertIsNone(self.json("extract", "seen.ptet", "--vertices", "50")["achieved"]["covered"])

    def test_what_reading_made_of_the_files_is_said(self):
        pieces = FIXTURES / "two_pieces.pvtu"
        for note in self.json("measure", pieces, pieces)["notes"]:
            self.assertNotIn("not carried", note)
        for command in (["measure", pieces, pieces], ["verify", "pieces.ptet", "--original", pieces]):
            if command[0] == "verify":
                self.ptet("build", pieces, "-o", "pieces.ptet", "--quiet")
            self.assertIn("skipped 1 ghost cell", self.ptet(*command).stdout)

    def test_defects_are_counted(self):
        self.cube("fine.vtu", 2, self.quadratic)
        self.cube("turned.vtu", 2, self.quadratic, turned=[3, 5])
        validity = self.json("measure", "fine.vtu", "turned.vtu")["simplified"]["validity"]
        self.assertFalse(validity["valid"])
        self.assertEqual(validity["inverted_tets"], 2)
        self.cube("mirrored.vtu", 2, self.quadratic, turned=range(48))  # all of them: another convention
        mirrored = self.json("measure", "fine.vtu", "mirrored.vtu")
        self.assertTrue(mirrored["simplified"]["validity"]["valid"])
        self.assertIn("convention", mirrored["notes"][0])
        self.assertLess(mirrored["inside"]["fields"]["q"]["max"], 1e-12)
        points, tets = meshes.grid(2)
        meshes.vtu(self.folder / "lonely.vtu", [*points, (7.0, 7.0, 7.0)], tets)
        notes = self.json("measure", "fine.vtu", "lonely.vtu")["notes"]
        self.assertIn("1 vertex of 'lonely.vtu' is in no tet: counted, but not compared", notes)
        meshes.vtu(self.folder / "crossed.vtu", [*points, *((x + 0.3, y + 0.3, z + 0.3) for x, y, z in points)],
                   [*tets, *([v + len(points) for v in tet] for tet in tets)])
        report = self.json("measure", "fine.vtu", "crossed.vtu")
        self.assertGreater(report["simplified"]["validity"]["boundary_self_intersections"], 0)
        self.assertEqual(report["simplified"]["validity"]["components"], 2)
        self.assertIn("no floating-point field", report["notes"][0])
        self.assertFalse(any("intersects itself" in note for note in report["notes"]))
        report = self.json("measure", "crossed.vtu", "fine.vtu")
        self.assertTrue(any("intersects itself" in note for note in report["notes"]))
        folded = [(0.9, 0.3, 0.3) if tuple(p) == (0.5, 0.5, 0.5) else p for p in points]
        meshes.vtu(self.folder / "folded.vtu", folded, tets)
        report = self.json("measure", "folded.vtu", "fine.vtu")
        self.assertEqual(report["original"]["validity"]["boundary_self_intersections"], 0)
        self.assertIsNone(report["original"]["validity"]["overlapping_tets"])
        self.assertEqual(report["simplified"]["validity"]["overlapping_tets"], 0)
        self.assertTrue(any("folded over one another" in note for note in report["notes"]))
        self.assertIn("not looked for", self.ptet("measure", "fine.vtu", "folded.vtu").stdout)
        meshes.vtu(self.folder / "nested.vtu", [*points, *((x / 4 + 0.3, y / 4 + 0.3, z / 4 + 0.3) for x, y, z in points)],
                   [*tets, *([v + len(points) for v in tet] for tet in tets)])
        report = self.json("measure", "nested.vtu", "fine.vtu")
        self.assertEqual(report["original"]["validity"]["boundary_self_intersections"], 0)
        self.assertGreater(report["original"]["validity"]["overlapping_tets"], 0)
        self.assertFalse(report["original"]["validity"]["valid"])
        self.assertTrue(any("reach into one another" in note for note in report["notes"]))

    def test_files_say_that_their_original_overlaps(self):
        points, tets = meshes.grid(4)
        shifted = [(x / 2 + 0.3, y / 2 + 0.3, z / 2 + 0.3) for x, y, z in points]
        twice = [*tets, *([v + len(points) for v in tet] for tet in tets)]
        folded = [(0.9, 0.3, 0.3) if tuple(p) == (0.5, 0.5, 0.5) else p for p in points]
        crossed = [(x / 2 + 0.7, y / 2 + 0.7, z / 2 + 0.7) for x, y, z in points]
        for name, of_points, of_tets, overlaps in [("plain", points, tets, False), ("folded", folded, tets, True),
                                                   ("nested", [*points, *shifted], twice, True),
                                                   ("crossed", [*points, *crossed], twice, True)]:
            with self.subTest(name):
                meshes.vtu(self.folder / f"{name}.vtu", of_points, of_tets, meshes.wave(of_points))
                self.ptet("build", f"{name}.vtu", "-q")
                self.assertEqual(self.json("info", f"{name}.ptet")["overlaps_itself"], overlaps)
                report = self.json("extract", f"{name}.ptet", "--vertices", "50%")
                self.assertEqual(report["achieved"]["overlaps_itself"], overlaps)
                self.assertEqual(any("lie in one another" in note for note in report["notes"]), overlaps)
                self.assertEqual(self.json("extract", f"{name}.ptet")["notes"], [])  # the original has no error
                self.assertEqual("  note" in self.ptet("extract", f"{name}.ptet", "--vertices", "50%").stdout, overlaps)
                self.assertTrue(self.json("verify", f"{name}.ptet")["ok"])

    def test_errors_as_a_mesh(self):
        self.cube("fine.vtu", 4, self.quadratic)
        self.cube("coarse.vtu", 2, self.quadratic)
        self.ptet("measure", "fine.vtu", "coarse.vtu", "--errors", "errors.vtu")
        fields = {field["name"]: field for field in self.json("info", "errors.vtu")["fields"]}
        self.assertAlmostEqual(fields["q error"]["max"], 1 / 16, delta=1e-12)
        self.assertEqual(fields["q error"]["min"], 0)
        self.assertIn("flow error", fields)
        # What the mesh has by such a name stays.
        self.ptet("measure", "errors.vtu", "coarse.vtu", "--field", "q", "--errors", "again.vtu")
        again = {field["name"]: field for field in self.json("info", "again.vtu")["fields"]}
        self.assertEqual(again["q error"], fields["q error"])
        self.assertEqual(again["q error 2"]["max"], fields["q error"]["max"])
        self.refused(2, "measure", "fine.vtu", "coarse.vtu", "--errors", "errors.vtk", says=".vtu")
        self.refused(2, "measure", "fine.vtu", "coarse.vtu", "--errors", "fine.vtu", says="fine.vtu")
        self.refused(2, "measure", "fine.vtu", "coarse.vtu", "--errors", "coarse.vtu", says="coarse.vtu")
        self.refused(2, "measure", "fine.vtu", "coarse.vtu", "--errors", "e.vtu", "--samples", 9, says="--errors")
        self.assertEqual(self.files(), ["again.vtu", "coarse.vtu", "errors.vtu", "fine.vtu"])
        meshes.vtu(self.folder / "bare.vtu", *meshes.grid(2))
        self.refused(3, "measure", "fine.vtu", "bare.vtu", "--errors", "e.vtu", says="no errors to write")
        self.assertNotIn("e.vtu", self.files())

    def test_integers_beyond_what_a_double_holds_are_compared_as_integers(self):
        points, tets = meshes.grid(3)
        for vtk_type, base in (("Int64", 2**60), ("UInt64", 2**63 + 2**60), ("Int64", 1_700_000_000 * 10**9)):
            values = [base + round(50 * x * x + 20 * y * z) for x, y, z in points]
            meshes.vtu(self.folder / "ids.vtu", points, tets, {"n": (vtk_type, values)})
            values[21] += 7
            meshes.vtu(self.folder / "off.vtu", points, tets, {"n": (vtk_type, values)})
            field = self.json("measure", "ids.vtu", "off.vtu", "--field", "n")["inside"]["fields"]["n"]
            self.assertAlmostEqual(field["max"], 7)
            self.ptet("build", "ids.vtu", "-o", "ids.ptet", "--quiet")
            self.ptet("extract", "ids.ptet", "-o", "cut.vtu", "--field-error", "0")
            field = self.json("measure", "ids.vtu", "cut.vtu", "--field", "n")["inside"]["fields"]["n"]
            self.assertLess(field["max"], 1e-9)
        values[21] += 2**53
        meshes.vtu(self.folder / "off.vtu", points, tets, {"n": (vtk_type, values)})
        self.refused(3, "measure", "ids.vtu", "off.vtu", "--field", "n", says="2^53")
        self.refused(3, "build", "off.vtu", "-o", "off.ptet", says="2^53")
        said = self.ptet("info", "off.vtu").stdout
        self.assertIn("the values of 'n' range over more than can be measured", said)
        self.assertIn("verdict   cannot be built from: there is no field whose errors can be measured", said)
        self.assertFalse(self.json("info", "off.vtu")["buildable"])

    def test_a_field_that_cannot_govern_is_said_to_be_one_only_where_it_would(self):
        points, tets = meshes.grid(3)
        wide = ("Int64", [0, 2**53] + [7] * (len(points) - 2))
        apart = ("Float64", [-1.7e308, 1.7e308] + [0.0] * (len(points) - 2))
        meshes.vtu(self.folder / "two.vtu", points, tets, {"n": wide, "f": ("Float64", [x for x, y, z in points])})
        self.assertIn("  verdict   can be built from\n", self.ptet("info", "two.vtu").stdout)
        fields = self.json("info", "two.vtu")["fields"]
        self.assertEqual([(f["governs_by_default"], f["can_govern"]) for f in fields], [(False, False), (True, True)])
        self.ptet("build", "two.vtu", "-o", "two.ptet", "--quiet")
        meshes.vtu(self.folder / "apart.vtu", points, tets, {"f": apart, "n": wide, "g": ("Float32", [0.5] * len(points))})
        self.assertIn("if --field names others than 'f'\n", self.ptet("info", "apart.vtu").stdout)
        self.refused(3, "build", "apart.vtu", "-o", "apart.ptet", says="passes what a double can hold")

    def test_one_field_is_not_compared_with_two(self):
        points, tets = meshes.grid(2)
        fields = {name: ("Float64", [x + i * y for x, y, z in points]) for i, name in enumerate("ab")}
        meshes.vtu(self.folder / "ab.vtu", points, tets, fields)
        self.refused(2, "measure", "ab.vtu", "ab.vtu", "--field", "a", "--field", "a=b", says=["'a'", "'b'"])
        self.ptet("measure", "ab.vtu", "ab.vtu", "--field", "a", "--field", "a")
        flat = [(x, y, 0.0) for x, y, z in points]
        meshes.vtu(self.folder / "flat.vtu", flat, tets, fields)
        self.refused(3, "measure", "ab.vtu", "flat.vtu", says="'flat.vtu' has no volume")

    def test_what_cannot_be_compared(self):
        self.cube("fine.vtu", 2, self.quadratic)
        self.cube("far.vtu", 2, self.quadratic, origin=(3.0, 0.0, 0.0))
        self.cube("other.vtu", 2, lambda points: {"scalars": ("Float64", [x * x for x, _, _ in points]),
                                                  "flow": ("Float32", [x for x, _, _ in points])})
        for extra in [[], ["--samples", 50]]:
            self.refused(3, "measure", "fine.vtu", "far.vtu", *extra, says=["overlap", "(3, 0, 0) to (4, 1, 1)"])
        self.refused(2, "measure", "fine.vtu", "other.vtu", "--field", "p", says=["'p'", "'q' and 'flow'"])
        self.refused(2, "measure", "fine.vtu", "other.vtu", "--field", "q", says=["'q'", "other.vtu", "'scalars'"])
        self.refused(3, "measure", "fine.vtu", "other.vtu", "--field", "flow", says=["3 components", "and 1"])
        self.refused(2, "measure", "fine.vtu", "fine.vtu", "--samples", 5, "--exact", says="--exact")
        for option, values in {"--samples": ["0", "-1", "x", "1%"], "--seed": ["-1", "x"], "--threads": ["-1"],
                               "--tolerance": ["0%", "1", "nan%", "-1%"]}.items():
            for value in values:
                with self.subTest(option=option, value=value):
                    self.refused(2, "measure", "fine.vtu", "fine.vtu", f"{option}={value}", says=option)
        self.refused(6, "measure", "fine.vtu", "missing.vtu", says="missing.vtu")
        report = self.json("measure", "fine.vtu", "other.vtu", "--field", "q=scalars")
        self.assertEqual(report["inside"]["fields"]["q"]["max"], 0)
        self.assertIn("flow", self.json("measure", "fine.vtu", "other.vtu")["notes"][0])


class RealMeshes(Case):
    def mesh(self, name):
        path = DATA / name
        if not path.exists():
            self.skipTest(f"{path} is not there; PTET_DATA names the folder of the real meshes")
        return path

    def test_from_mesh_to_levels_and_back(self):
        fire = self.mesh("fire_ug.vtu")
        report = self.json("build", fire, "-o", "fire.ptet")
        self.assertTrue(self.json("verify", "fire.ptet", "--original", fire)["ok"])
        for options in [["--field-error", "1%"], ["--vertices", "5%"], ["--tets", "2000"],
                        ["--field-error", "5%", "--focus", "sphere:0,0,0,1"]]:
            with self.subTest(options):
                extracted = self.json("extract", "fire.ptet", *options, "-o", "out.vtu")
                info = self.json("info", "out.vtu")
                self.assertEqual((info["vertices"], info["tets"]), (extracted["vertices"], extracted["tets"]))
                self.assertEqual([f["code"] for f in info["findings"] if f["severity"] != "note"], [])
        self.assertEqual(self.json("extract", "fire.ptet")["tets"], report["input"]["tets"])

    def test_an_interrupt_leaves_nothing_behind(self):
        # The large one is being read by then, the other's edges collapse.
        for mesh, name, after in [("motorbike", signal.SIGINT, 0.2), ("bluntfin", signal.SIGINT, 0.8),
                                  ("bluntfin", signal.SIGTERM, 2.0)]:
            original = self.mesh(f"{mesh}.vtu")
            with self.subTest(signal=name, after=after):
                with subprocess.Popen([program(), "build", str(original), "-o", "m.ptet"], cwd=self.folder,
                                      stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
                    time.sleep(after)
                    run.send_signal(name)
                    sent = time.monotonic()
                    out, err = run.communicate(timeout=120)
                self.assertEqual(run.returncode, 130, err)
                self.assertLess(time.monotonic() - sent, 60)
                self.assertEqual((out, err), (b"", b"ptet: interrupted; nothing was written\n"))
                self.assertEqual(self.files(), [])

    def test_an_interrupted_measure_leaves_nothing_behind(self):
        motorbike = self.mesh("motorbike.vtu")
        for after in [0.5, 8.0]:
            with self.subTest(after=after):
                with subprocess.Popen([program(), "measure", str(motorbike), str(motorbike), "--errors", "e.vtu"],
                                      cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
                    time.sleep(after)
                    run.send_signal(signal.SIGINT)
                    out, err = run.communicate(timeout=120)
                self.assertEqual((run.returncode, out), (130, b""), err)
                self.assertEqual(err, b"ptet: interrupted; nothing was written\n")
                self.assertEqual(self.files(), [])

    def test_a_second_interrupt_kills_at_once(self):
        motorbike = self.mesh("motorbike.vtu")
        with subprocess.Popen([program(), "build", str(motorbike), "-o", "m.ptet"], cwd=self.folder,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
            time.sleep(1.0)
            run.send_signal(signal.SIGINT)
            time.sleep(0.1)
            run.send_signal(signal.SIGINT)
            self.assertIn(run.wait(timeout=10), (-signal.SIGINT, 130))


if __name__ == "__main__":
    case.main()
