"""What a user types, with the output and exit code it must have. Usage: test_cli.py PTET [unittest options]

Real meshes are looked for in the folder that PTET_DATA names (default: shared/data beside the source tree)."""
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True  # leaves the source tree as it is
import meshes  # noqa: E402

PTET = None
DATA = pathlib.Path(os.environ.get("PTET_DATA") or
                    pathlib.Path(__file__).resolve().parents[3] / "shared" / "data")

METHODS = {  # predict, evaluate
    "exact": ("exact", "exact"), "LN": ("local", "none"), "GN": ("gradient", "none"), "QN": ("quadric", "none"),
    "BF": ("simulate", "vertices"), "BFS": ("simulate", "samples"), "staadt-gross": ("weighted-sum", "none"),
    "trotts": ("per-tet", "none"),
}
COMMANDS = {
    "build": ["--output", "--field", "--max-field-error", "--max-domain-error", "--target-vertices", "--min-quality",
              "--method", "--objective", "--predict", "--evaluate", "--max-star", "--pieces", "--threads",
              "--memory-limit", "--checkpoint", "--checkpoint-every", "--resume", "--force", "--json", "--quiet"],
    "extract": ["--output", "--field-error", "--domain-error", "--tets", "--vertices", "--bytes", "--milliseconds",
                "--focus", "--focus-error", "--focus-falloff", "--isovalue", "--values", "--view", "--pixels",
                "--outside", "--errors", "--salvage", "--json"],
    "info": ["--levels", "--json"],
    "measure": ["--field", "--exact", "--samples", "--seed", "--tolerance", "--threads", "--errors", "--json"],
    "verify": ["--original", "--samples", "--json"],
    "dump": ["--annotate"],
}


class Case(unittest.TestCase):
    """A test with a folder of its own, in which the program runs."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ptet-cli-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def ptet(self, *arguments, code=0, **options):
        options.setdefault("stdout", subprocess.PIPE)
        done = subprocess.run([PTET, *map(str, arguments)], cwd=self.folder, stderr=subprocess.PIPE,
                              encoding="utf-8", timeout=600, check=False, **options)
        self.assertEqual(done.returncode, code, f"ptet {arguments}\n{done.stdout}\n{done.stderr}")
        return done

    def refused(self, code, *arguments, says=()):
        """The program ends with `code`, nothing on stdout and one line on stderr that holds all of `says`."""
        done = self.ptet(*arguments, code=code)
        self.assertEqual(done.stdout, "")
        self.assertTrue(done.stderr.startswith("ptet: error: "), done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        for text in [says] if isinstance(says, str) else says:
            self.assertIn(text, done.stderr)
        return done

    def json(self, *arguments):
        return json.loads(self.ptet(*arguments, "--json").stdout)

    def files(self):
        return sorted(path.name for path in self.folder.iterdir())

    def grid(self, n=6, name="grid.vtu"):
        points, tets = meshes.grid(n)
        return meshes.vtu(self.folder / name, points, tets, meshes.wave(points))

    def built_grid(self, n=6):
        self.grid(n)
        self.ptet("build", "grid.vtu", "--quiet")
        return self.folder / "grid.ptet"


class Help(Case):
    def test_every_command_names_its_options(self):
        for command, options in COMMANDS.items():
            with self.subTest(command):
                text = self.ptet(command, "--help").stdout
                for option in options:
                    self.assertIn(option, text)
                self.assertIn("Examples:", text)
                self.assertEqual(self.ptet("help", command).stdout, text)

    def test_program(self):
        text = self.ptet("--help").stdout
        self.assertEqual(self.ptet("help").stdout, text)
        for word in [*COMMANDS, "Exit codes", "130"]:
            self.assertIn(word, text)
        self.assertRegex(self.ptet("--version").stdout, r"^ptet \d+\.\d+\.\d+\n$")

    def test_no_command_is_a_usage_error(self):
        done = self.ptet(code=2)
        self.assertEqual(done.stdout, "")
        self.assertIn("Usage:", done.stderr)

    def test_unknown_command(self):
        self.refused(2, "simplify", says=["simplify", "'build'"])
        self.refused(2, "help", "simplify", says=["simplify", "'build'"])


class Usage(Case):
    def test_values_are_refused_by_the_option_that_has_them(self):
        bound = ["", "nan", "NaN%", "inf", "-1", "-0", "1e999", "1%%", "%", "x", "1,5x", "0x10", " 1"]
        cases = {
            "build": {"--max-field-error": [*bound, "=1", "smooth=", "smooth=-1", "smooth=1,", "1,2", "a=1,a=2"],
                      "--max-domain-error": bound, "--target-vertices": ["", "-1", "1.5", "101%", "nan", "-1%"],
                      "--min-quality": ["", "-1", "nan", "2"], "--max-star": ["", "3", "-1", "x"],
                      "--threads": ["", "-1", "1.5", "99999999999"], "--pieces": ["", "0", "-1", "x", "65537"],
                      "--memory-limit": ["", "-1", "1.5", "G", "8T", "-8G"]},
            "extract": {"--field-error": [*bound, "=1", "smooth=nan", "1%,2%"], "--domain-error": bound,
                        "--tets": ["", "-1", "1.5", "101%"], "--vertices": ["", "-1", "inf"],
                        "--focus": ["", "box", "box:1,2,3", "box:1,0,0,0,1,1", "box:0,0,0,1,1,nan",
                                    "box:0,0,0,1,1,1,1", "sphere:0,0,0,-1", "sphere:0,0,0,inf", "cone:0,0,0,1",
                                    "box:0,,0,1,1,1", "half:1,0,0", "half:0,0,0,1", "obox:0,0,0,1,0,0,0,1,0",
                                    "obox:0,0,0,1,0,0,1,1,0,1", "obox:0,0,0,1,0,0,2,0,0,1",
                                    "obox:0,0,0,1,0,0,0,1,0,-1"],
                        "--focus-error": bound, "--focus-falloff": bound, "--bytes": ["", "-1", "1.5", "xMB", "-1kB"],
                        "--milliseconds": ["", "-1", "nan", "1%"],
                        "--isovalue": ["", "1", "=1", "smooth=", "smooth=nan", "smooth=1..2"],
                        "--values": ["", "smooth", "smooth=1", "=1..2", "smooth=2..1", "smooth=a..b"],
                        "--view": ["", "eye=0,0,0", "eye=0,0,0:at=0,0,0", "eye=0,0:at=1,1,1", "eye=0,0,0:at=1,1,nan",
                                   "eye=0,0,0:at=1,1,1:angle=180", "eye=0,0,0:at=1,1,1:size=100",
                                   "eye=0,0,0:at=1,1,1:size=0x5", "eye=0,0,0:at=1,1,1:zoom=2",
                                   "eye=0,0,0:eye=0,0,0:at=1,1,1"],
                        "--pixels": ["", "-1", "nan"], "--outside": ["", "0.5", "-1", "inf"]},
        }
        needed = {"--focus-error": ["--focus", "sphere:0,0,0,1"], "--focus-falloff": ["--focus", "sphere:0,0,0,1"],
                  "--pixels": ["--view", "eye=0,0,-9:at=0,0,0"], "--outside": ["--view", "eye=0,0,-9:at=0,0,0"]}
        self.built_grid(2)
        for command, options in cases.items():
            for option, values in options.items():
                for value in values:
                    with self.subTest(command=command, option=option, value=value):
                        more = needed.get(option, [])
                        file = "grid.vtu" if command == "build" else "grid.ptet"
                        self.refused(2, command, file, "-o" if command == "build" else "--json",
                                     *(["x.ptet"] if command == "build" else []), *more, option, value, says=option)
        self.assertEqual(self.files(), ["grid.ptet", "grid.vtu"])

    def test_missing_and_doubled(self):
        self.refused(2, "build", says="IN")
        self.refused(2, "extract", "a.ptet", "--tets", says="--tets")
        self.refused(2, "extract", "a.ptet", "--tets", "1", "--tets", "2", says="--tets")
        self.refused(2, "extract", "a.ptet", "b.ptet", says="b.ptet")
        self.refused(2, "info", "a.ptet", "--nope", says="--nope")

    def test_options_that_need_another(self):
        self.built_grid(2)
        self.refused(2, "extract", "grid.ptet", "--focus-error", "1%", says="--focus")
        self.refused(2, "extract", "grid.ptet", "--focus-falloff", "1%", says="--focus")
        self.refused(2, "extract", "grid.ptet", "--pixels", "1", says="--view")
        self.refused(2, "extract", "grid.ptet", "--outside", "2", says="--view")
        ball = ["--focus", "sphere:0,0,0,1"]
        self.refused(2, "extract", "grid.ptet", *ball, *ball, *ball, "--focus-error", "1%", "--focus-error", "2%",
                     says=["--focus-error", "3"])
        self.refused(2, "extract", "grid.ptet", "--view", "eye=0,0,0:at=1,0,0:up=2,0,0", says="up")
        self.refused(2, "extract", "grid.ptet", "--errors", says="--errors")
        self.refused(2, "extract", "grid.ptet", "--errors", "-o", "a.stl", says="--errors")
        self.refused(2, "extract", "grid.ptet", "-o", "a.png", says=["a.png", ".vtu", ".stl"])
        self.refused(2, "info", "grid.vtu", "--levels", says="--levels")

    def test_unknown_fields_are_answered_with_the_known(self):
        self.built_grid(2)
        known = ["'nope'", "'smooth'", "'bumpy'"]
        self.refused(2, "build", "grid.vtu", "-o", "x.ptet", "--field", "nope", says=known)
        self.refused(2, "build", "grid.vtu", "-o", "x.ptet", "--max-field-error", "nope=1%", says=known)
        self.refused(2, "extract", "grid.ptet", "--field-error", "nope=1%", says=known)
        self.refused(2, "extract", "grid.ptet", "--isovalue", "nope=1", says=known)
        self.refused(2, "extract", "grid.ptet", "--values", "nope=1..2", says=known)
        self.ptet("build", "grid.vtu", "-o", "one.ptet", "--field", "smooth", "--quiet")
        self.refused(2, "extract", "one.ptet", "--field-error", "bumpy=1%", says=["'bumpy'", "'smooth'"])


class BadInput(Case):
    def test_paths(self):
        (self.folder / "folder").mkdir()
        self.grid(2)
        for command in ["build", "extract", "info", "verify", "dump"]:
            with self.subTest(command):
                self.refused(6, command, "missing.vtu", says="missing.vtu")
                self.refused(6, command, "folder", says="folder")
        self.refused(6, "build", "grid.vtu", "-o", "folder", says="folder")
        self.refused(6, "build", "grid.vtu", "-o", "nowhere/x.ptet", says="nowhere")
        self.refused(6, "build", "grid.vtu", "-o", "/dev/null", says="/dev/null")
        self.assertEqual(self.files(), ["folder", "grid.vtu"])

    def test_nan_in_a_field(self):
        points, tets = meshes.grid(3)
        fields = meshes.wave(points)
        fields["bumpy"][1][7] = float("nan")
        meshes.vtu(self.folder / "nan.vtu", points, tets, fields)
        self.refused(3, "build", "nan.vtu", says=["bumpy", "7"])
        # Where it does not govern it is carried along, bit for bit.
        self.ptet("build", "nan.vtu", "--field", "smooth")
        self.ptet("verify", "nan.ptet", "--original", "nan.vtu")

    def test_nan_in_a_position(self):
        points, tets = meshes.grid(2)
        points[5] = (0.0, float("nan"), 0.0)
        meshes.vtu(self.folder / "nan.vtu", points, tets, {"u": ("Float64", [0.0] * len(points))})
        self.refused(3, "build", "nan.vtu", says="5")
        self.assertFalse(self.json("info", "nan.vtu")["buildable"])

    def test_empty_mesh(self):
        meshes.vtu(self.folder / "empty.vtu", [], [])
        self.refused(3, "build", "empty.vtu", says="empty.vtu")

    def test_triangle_mesh(self):
        points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
        meshes.vtu(self.folder / "flat.vtu", points, [[0, 1, 2]], {"u": ("Float32", [1.0, 2.0, 3.0])},
                   meshes.TRIANGLE)
        self.refused(3, "build", "flat.vtu", says="flat.vtu")
        self.refused(3, "info", "flat.vtu", says="flat.vtu")

    def test_garbage(self):
        (self.folder / "noise.vtu").write_bytes(random.Random(1).randbytes(4096))
        (self.folder / "noise.ptet").write_bytes(random.Random(2).randbytes(4096))
        (self.folder / "empty.ptet").write_bytes(b"")
        self.refused(3, "build", "noise.vtu", says="noise.vtu")
        self.refused(3, "info", "noise.vtu", says="noise.vtu")
        for command in ["extract", "info", "verify", "dump"]:
            self.refused(4, command, "noise.ptet")
            self.refused(4, command, "empty.ptet")

    def test_a_ptet_file_is_no_input_for_a_build(self):
        self.built_grid(2)
        self.refused(3, "build", "grid.ptet", "-o", "x.ptet", says="extract")

    def test_a_mesh_without_fields(self):
        points, tets = meshes.grid(3)
        meshes.vtu(self.folder / "bare.vtu", points, tets)
        self.ptet("build", "bare.vtu")
        self.ptet("verify", "bare.ptet", "--original", "bare.vtu")
        self.refused(2, "extract", "bare.ptet", "--field-error", "1%", says="--field-error")

    def test_one_tet(self):
        points, tets = meshes.SINGLE_TET
        meshes.vtu(self.folder / "one.vtu", points, tets, {"u": ("Float64", [0.0, 1.0, 2.0, 3.0])})
        self.assertEqual(self.json("build", "one.vtu")["records"], 0)
        self.ptet("verify", "one.ptet", "--original", "one.vtu")
        extracted = self.json("extract", "one.ptet", "-o", "again.vtu")
        self.assertEqual((extracted["vertices"], extracted["tets"], extracted["limited_by"]), (4, 1, "nothing"))

    def test_disconnected_pieces(self):
        points, tets = meshes.grid(4)
        more, others = meshes.grid(3, origin=(5.0, 0.0, 0.0))
        tets += [[v + len(points) for v in tet] for tet in others]
        points += more
        meshes.vtu(self.folder / "two.vtu", points, tets, meshes.wave(points))
        self.assertEqual(self.json("info", "two.vtu")["components"], 2)
        self.ptet("build", "two.vtu")
        self.ptet("verify", "two.ptet", "--original", "two.vtu")
        self.ptet("extract", "two.ptet", "--vertices", "10%", "-o", "coarse.vtu")
        self.assertEqual(self.json("info", "coarse.vtu")["components"], 2)

    def test_inverted_tets_are_turned_and_said(self):
        points, tets = meshes.grid(3)
        for tet in tets[::5]:
            tet[0], tet[1] = tet[1], tet[0]
        meshes.vtu(self.folder / "inverted.vtu", points, tets, meshes.wave(points))
        self.assertIn("inverted-tets", [f["code"] for f in self.json("info", "inverted.vtu")["findings"]])
        self.assertTrue(self.json("build", "inverted.vtu")["notes"])
        found = self.json("verify", "inverted.ptet", "--original", "inverted.vtu")
        self.assertTrue(found["ok"])
        self.assertIn("turned", " ".join(found["notes"]))


class Files(Case):
    def test_output_is_replaced_only_when_it_is_meant(self):
        self.grid(3)
        self.ptet("build", "grid.vtu", "--quiet")
        before = (self.folder / "grid.ptet").read_bytes()
        self.ptet("build", "grid.vtu", "--quiet", "--field", "smooth")
        self.assertNotEqual((self.folder / "grid.ptet").read_bytes(), before)
        (self.folder / "notes.txt").write_text("keep me")
        self.refused(2, "build", "grid.vtu", "-o", "notes.txt", says=["notes.txt", "--force"])
        self.assertEqual((self.folder / "notes.txt").read_text(), "keep me")
        self.ptet("build", "grid.vtu", "-o", "notes.txt", "--force", "--quiet")
        self.ptet("verify", "notes.txt")
        self.refused(2, "build", "grid.vtu", "-o", "./grid.vtu", "--force", says="input")
        self.assertEqual(self.files(), ["grid.ptet", "grid.vtu", "notes.txt"])

    def test_a_link_stays_a_link(self):
        self.grid(2)
        (self.folder / "elsewhere").mkdir()
        (self.folder / "elsewhere" / "real.ptet").write_bytes(b"")
        (self.folder / "grid.ptet").symlink_to("elsewhere/real.ptet")
        self.ptet("build", "grid.vtu", "--quiet")
        self.assertTrue((self.folder / "grid.ptet").is_symlink())
        self.ptet("verify", "elsewhere/real.ptet")

    def test_same_bytes_on_any_number_of_threads(self):
        self.grid(8)
        for threads in [1, 2, 5]:
            self.ptet("build", "grid.vtu", "-o", f"{threads}.ptet", "--threads", threads, "--quiet")
        self.assertEqual((self.folder / "1.ptet").read_bytes(), (self.folder / "2.ptet").read_bytes())
        self.assertEqual((self.folder / "1.ptet").read_bytes(), (self.folder / "5.ptet").read_bytes())

    def test_full_disk(self):
        self.grid(10)
        small = self.folder / "small"
        small.mkdir()
        if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", str(small)],
                                               stderr=subprocess.DEVNULL, check=False).returncode != 0:
            self.skipTest("needs the right to mount a small tmpfs")
        self.addCleanup(subprocess.run, ["umount", str(small)], check=True)
        self.refused(6, "build", "grid.vtu", "-o", "small/x.ptet", says=["small/x.ptet", "No space left"])
        self.ptet("build", "grid.vtu", "--quiet")
        for ending in ["vtu", "vtk", "stl", "ply", "obj", "off"]:
            self.refused(6, "extract", "grid.ptet", "-o", f"small/x.{ending}", says=f"small/x.{ending}")
        self.assertEqual(list(small.iterdir()), [])

    def test_standard_output_that_cannot_be_written(self):
        self.built_grid(3)
        for arguments in [["info", "grid.ptet"], ["extract", "grid.ptet", "--json"], ["dump", "grid.ptet"],
                          ["--help"]]:
            with self.subTest(arguments), open("/dev/full", "w", encoding="ascii") as full:
                self.assertIn("standard output", self.ptet(*arguments, code=6, stdout=full).stderr)
        closed = subprocess.run(f"{PTET} info grid.ptet >&-", shell=True, cwd=self.folder, stderr=subprocess.PIPE,
                                encoding="utf-8", check=False)
        self.assertEqual(closed.returncode, 6, closed.stderr)

    def test_a_reader_that_goes_away(self):
        self.built_grid(6)
        done = subprocess.run(f"{PTET} dump --annotate grid.ptet | head -n 1", shell=True, cwd=self.folder,
                              capture_output=True, encoding="utf-8", check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_damage(self):
        whole = self.built_grid(4).read_bytes()
        damaged = self.folder / "damaged.ptet"
        rng = random.Random(3)
        for length in [1, 7, 8, 100, len(whole) // 2, len(whole) - 1, *(rng.randrange(len(whole)) for _ in range(20))]:
            with self.subTest(length=length):
                damaged.write_bytes(whole[:length])
                self.refused(4, "extract", damaged.name)
                self.refused(4, "info", damaged.name)
        for bit in (rng.randrange(8 * len(whole)) for _ in range(100)):
            with self.subTest(bit=bit):
                data = bytearray(whole)
                data[bit // 8] ^= 1 << bit % 8
                damaged.write_bytes(data)
                self.assertIn("error", self.ptet("verify", damaged.name, code=4).stderr)
        damaged.write_bytes(whole + b"\0")
        self.ptet("verify", damaged.name, code=4)

    def test_salvage(self):
        whole = self.built_grid(4)
        data = bytearray(whole.read_bytes())
        blocks = [line for line in self.ptet("dump", whole.name).stdout.splitlines() if line.startswith("block ")]
        offset = int(blocks[-1].split("bytes ")[1].split()[0])
        data[offset + 3] ^= 1
        damaged = self.folder / "damaged.ptet"
        damaged.write_bytes(data)
        self.refused(4, "extract", damaged.name, "-o", "out.vtu", says=["block ", f"at byte {offset}", "--salvage"])
        self.assertFalse((self.folder / "out.vtu").exists())
        done = self.ptet("extract", damaged.name, "--salvage", "--json", "-o", "out.vtu", code=4)
        self.assertIn("coarser than asked", done.stderr)
        self.assertTrue((self.folder / "out.vtu").exists())
        report = json.loads(done.stdout)
        self.assertEqual((report["complete"], report["limited_by"]), (False, "unreadable"))
        self.assertEqual([failure["byte_offset"] for failure in report["failures"]], [offset])
        full = json.loads(self.ptet("extract", whole.name, "--salvage", "--json").stdout)
        self.assertEqual((full["complete"], full["failures"]), (True, []))
        self.assertLess(report["tets"], full["tets"])


class Reports(Case):
    def test_build(self):
        self.grid(8)
        report = self.json("build", "grid.vtu", "--target-vertices", "20%")
        self.assertEqual(report["input"]["vertices"], 729)
        self.assertEqual(report["input"]["tets"], 3072)
        self.assertEqual(report["output"], "grid.ptet")
        self.assertEqual(report["base"]["vertices"] + report["records"], 729)
        self.assertEqual(report["collapses"]["accepted"], report["records"])
        self.assertEqual(set(report["field_error"]), {"smooth", "bumpy"})
        self.assertEqual(report["file_bytes"], (self.folder / "grid.ptet").stat().st_size)
        if report["stopped_by"] == "target":
            self.assertLessEqual(report["base"]["vertices"], 145)
        for key in ["rounds", "depth", "domain_error", "bytes_per_vertex", "seconds", "collapses_per_second", "notes"]:
            self.assertIn(key, report)
        walk = report["walk"]
        self.assertEqual((len(walk), walk[-1]["vertices"]), (report["rounds"], report["base"]["vertices"]))
        info = self.json("info", "grid.ptet")
        shares = [report["field_error"][field["name"]] / field["range"] for field in info["fields"]]
        self.assertAlmostEqual(walk[-1]["field_error"], max(shares))
        self.assertAlmostEqual(walk[-1]["domain_error"], report["domain_error"] / info["diagonal"])
        for step, after in zip(walk, walk[1:]):
            self.assertGreater(step["vertices"], after["vertices"])
            for error in ["field_error", "domain_error"]:
                self.assertLessEqual(step[error], after[error])

    def test_a_whole_percentage_is_not_a_count(self):
        self.grid(4)
        self.assertEqual(self.json("build", "grid.vtu", "--target-vertices", "100%")["records"], 0)

    def test_max_field_error_holds(self):
        self.grid(8)
        free = self.json("build", "grid.vtu", "-o", "free.ptet")
        held = self.json("build", "grid.vtu", "-o", "held.ptet", "--max-field-error", "5%,bumpy=0.01")
        self.assertLessEqual(held["field_error"]["bumpy"], 0.01)
        self.assertLessEqual(held["field_error"]["smooth"], 0.05 * 4)
        self.assertGreater(free["field_error"]["bumpy"], 0.01)

    def test_human_reports(self):
        self.grid(6)
        self.assertIn("base", self.ptet("build", "grid.vtu").stdout)
        self.assertEqual(self.ptet("build", "grid.vtu", "--quiet").stdout, "")
        text = self.ptet("extract", "grid.ptet", "--field-error", "1%", "--focus", "box:0,0,0,1,1,.2").stdout
        for word in ["asked", "achieved", "smooth", "domain", "focus", "limited", "bytes"]:
            self.assertIn(word, text)
        self.assertIn("level", self.ptet("info", "grid.ptet", "--levels").stdout)
        self.assertIn("sound", self.ptet("verify", "grid.ptet").stdout)

    def test_where_an_extraction_is_fine(self):
        self.built_grid(8)
        whole = self.json("extract", "grid.ptet")["tets"]
        coarse = self.json("extract", "grid.ptet", "--field-error", "40%")["tets"]

        graded = self.json("extract", "grid.ptet", "--focus", "half:1,0,0,0.1", "--focus",
                           "obox:.8,.8,.8,.1,.1,0,.1,-.1,0,.1", "--focus-error", "0%", "--focus-error", "5%", "--focus-falloff", "200%")
        self.assertEqual(graded["limited_by"], "focus")
        self.assertEqual([sorted(focus) for focus in graded["asked"]["focus"]],
                         [["error", "falloff", "half_space"], ["error", "falloff", "oriented_box"]])
        self.assertEqual(graded["asked"]["focus"][0]["error"], {"smooth": 0, "bumpy": 0})
        first, second = graded["achieved"]["in_focus"]
        self.assertEqual(first, {"field_error": {"smooth": 0, "bumpy": 0}, "domain_error": 0})
        for field, error in second["field_error"].items():
            self.assertLessEqual(error, graded["asked"]["focus"][1]["error"][field])
        self.assertTrue(coarse <= graded["tets"] < whole)

        iso = self.json("extract", "grid.ptet", "--field-error", "smooth=2%", "--isovalue", "smooth=0.1")
        band = self.json("extract", "grid.ptet", "--field-error", "smooth=2%", "--values", "smooth=..0.1")
        everywhere = self.json("extract", "grid.ptet", "--field-error", "smooth=2%")
        self.assertEqual(iso["asked"]["values"], [{"field": "smooth", "min": 0.1, "max": 0.1}])
        self.assertEqual(band["asked"]["values"], [{"field": "smooth", "min": None, "max": 0.1}])
        self.assertLessEqual(iso["achieved"]["at_values"][0]["field_error"]["smooth"],
                             iso["asked"]["field_error"]["smooth"])
        self.assertTrue(iso["tets"] <= band["tets"] <= everywhere["tets"])

        camera = ["--view", "eye=.5,.5,.5:at=.5,.5,2:up=0,1,0:angle=60:size=640x480", "--field-error", "1%"]
        narrow = self.json("extract", "grid.ptet", *camera)
        graded = self.json("extract", "grid.ptet", *camera, "--outside", "10", "--pixels", "2")
        everywhere = self.json("extract", "grid.ptet", "--field-error", "1%", "--domain-error", "0")
        self.assertTrue(narrow["tets"] <= everywhere["tets"] and graded["tets"] <= everywhere["tets"])
        self.assertEqual(graded["asked"]["view"]["size"], [640, 480])
        self.assertAlmostEqual(graded["asked"]["view"]["angle"], 60)
        self.assertIsNone(narrow["asked"]["view"]["outside"])
        self.assertLessEqual(graded["achieved"]["in_view"]["pixels"], 2)

        text = self.ptet("extract", "grid.ptet", *camera, "--isovalue", "smooth=0.1").stdout
        for word in ["in the view", "pixels", "smooth = 0.1", "nothing outside"]:
            self.assertIn(word, text)

    def test_budgets(self):
        self.built_grid(8)
        for size, most in [("20kB", 20000), ("0.03MB", 30000), ("40000", 40000)]:
            report = self.json("extract", "grid.ptet", "--bytes", size)
            self.assertEqual((report["asked"]["bytes"], report["limited_by"]), (most, "budget"))
            # Points are three numbers of 8 bytes at most, the two fields one each.
            self.assertLessEqual(16 * report["tets"] + 5 * 4 * report["vertices"], most)
            self.assertGreater(16 * report["tets"] + (5 * 8 + 24) * report["vertices"], most / 2)
        base = self.json("info", "grid.ptet")["base"]
        stopped = self.json("extract", "grid.ptet", "--milliseconds", "0")
        self.assertEqual((stopped["tets"], stopped["limited_by"]), (base["tets"], "time"))
        patient = self.json("extract", "grid.ptet", "--milliseconds", "1e6")
        self.assertEqual(patient["limited_by"], "nothing")

    def test_info_of_a_mesh(self):
        self.grid(4)
        report = self.json("info", "grid.vtu")
        expected = {"kind": "mesh", "vertices": 125, "tets": 384, "components": 1, "boundary_components": 1,
                    "euler_characteristic": 1, "boundary_euler_characteristic": 2, "boundary_faces": 192,
                    "boundary_vertices": 98, "buildable": True}
        self.assertEqual({key: report[key] for key in expected}, expected)
        self.assertAlmostEqual(report["volume"], 1)
        self.assertAlmostEqual(report["boundary_area"], 6)

    def test_info_of_a_ptet_file(self):
        self.built_grid(6)
        report = self.json("info", "grid.ptet", "--levels")
        self.assertEqual((report["kind"], report["vertices"], report["tets"]), ("ptet", 343, 1296))
        self.assertEqual([field["name"] for field in report["fields"]], ["smooth", "bumpy"])
        for level in report["levels"]:
            percent = f"{100 * level['error']!r}%"
            extracted = self.json("extract", "grid.ptet", "--field-error", percent, "--domain-error", percent)
            self.assertEqual((extracted["vertices"], extracted["tets"]), (level["vertices"], level["tets"]), percent)

    def test_extract(self):
        self.built_grid(8)
        report = self.json("extract", "grid.ptet", "--field-error", "10%,bumpy=0.02", "--domain-error", "1%")
        self.assertEqual(set(report), {"asked", "achieved", "vertices", "tets", "bytes_read", "read_requests", "seconds",
                                       "limited_by", "complete", "failures", "output"})
        self.assertIsNone(report["output"])
        self.assertEqual(report["limited_by"], "error")
        asked, achieved = report["asked"], report["achieved"]
        self.assertAlmostEqual(asked["field_error"]["smooth"], 0.4)
        self.assertEqual(asked["field_error"]["bumpy"], 0.02)
        self.assertAlmostEqual(asked["domain_error"], 0.01 * 3 ** 0.5)
        for field, bound in asked["field_error"].items():
            self.assertLessEqual(achieved["field_error"][field], bound)
        self.assertLessEqual(achieved["domain_error"], asked["domain_error"])
        self.assertEqual(set(achieved), {"field_error", "domain_error", "rms_error"})
        self.assertLess(report["vertices"], 729)

    def test_budgets(self):
        self.built_grid(8)
        for option, key, limit in [("--tets", "tets", 1500), ("--vertices", "vertices", 200)]:
            report = self.json("extract", "grid.ptet", option, limit)
            self.assertLessEqual(report[key], limit)
            self.assertEqual(report["limited_by"], "budget")
        self.assertLessEqual(self.json("extract", "grid.ptet", "--vertices", "30%")["vertices"], 218)
        self.assertEqual(self.json("extract", "grid.ptet", "--vertices", "100%")["vertices"], 729)

    def test_outputs(self):
        self.built_grid(6)
        for ending in ["vtu", "vtk", "obj", "ply", "stl", "off"]:
            with self.subTest(ending):
                report = self.json("extract", "grid.ptet", "--field-error", "2%", "-o", f"out.{ending}")
                self.assertEqual(report["output"], f"out.{ending}")
                self.assertGreater((self.folder / f"out.{ending}").stat().st_size, 100)
        self.assertEqual(self.json("info", "out.vtu")["vertices"], report["vertices"])
        self.ptet("extract", "grid.ptet", "--field-error", "2%", "--errors", "-o", "errors.vtu")
        header = (self.folder / "errors.vtu").read_bytes()
        for field in [b"error of smooth", b"error of bumpy"]:
            self.assertIn(field, header)
        self.assertEqual(self.json("verify", "grid.ptet", "--original", "grid.vtu")["ok"], True)

    def test_the_original_comes_back(self):
        self.built_grid(6)
        self.ptet("extract", "grid.ptet", "-o", "full.vtu")
        self.assertTrue(self.json("verify", "grid.ptet", "--original", "full.vtu")["ok"])

    def test_verify_sees_what_differs(self):
        self.built_grid(4)
        points, tets = meshes.grid(4)

        def wrong(points, tets, fields):
            meshes.vtu(self.folder / "other.vtu", points, tets, fields)
            done = self.ptet("verify", "grid.ptet", "--original", "other.vtu", "--json", code=4)
            self.assertFalse(json.loads(done.stdout)["ok"])
            return " ".join(json.loads(done.stdout)["wrong"])

        fields = meshes.wave(points)
        fields["bumpy"][1][60] += 2e-7
        self.assertIn("1 vertex of the original not in the file", wrong(points, tets, fields))
        self.assertIn("'extra'", wrong(points, tets, {**meshes.wave(points), "extra": ("Int32", [1] * len(points))}))
        self.assertIn("1 tet after full refinement", wrong(points, tets[1:], meshes.wave(points)))
        self.assertIn("missing", wrong(points, [*tets[:-1], [0, 1, 30, 120]], meshes.wave(points)))
        moved = [*points[:-1], (1.0, 1.0, 1.0 + 2 ** -52)]
        self.assertIn("vertex", wrong(moved, tets, meshes.wave(points)))


    def test_verify_lists_all_that_it_finds(self):
        data = bytearray(self.built_grid(6).read_bytes())
        blocks = [int(line.split("bytes ")[1].split()[0]) for line in self.ptet("dump", "grid.ptet").stdout.splitlines()
                  if line.startswith("block ")]
        for offset in [12, blocks[-1] + 3, blocks[0] + 3]:  # a reserved field, under a header hash that is wrong then
            data[offset] ^= 1
        (self.folder / "damaged.ptet").write_bytes(data)
        done = self.ptet("verify", "damaged.ptet", code=4)
        for word in ["reserved is 1", "header's hash", "block 0", f"block {len(blocks) - 1}", "4 findings"]:
            self.assertIn(word, done.stdout)
        self.assertIn("4 findings", done.stderr)
        report = json.loads(self.ptet("verify", "damaged.ptet", "--json", "--original", "grid.vtu", code=4).stdout)
        self.assertEqual((report["ok"], report["wrong_count"], len(report["findings"])), (False, 4, 4))
        self.assertEqual(sorted(f["block"] for f in report["findings"] if f["block"] is not None),
                         [0, len(blocks) - 1])
        self.assertTrue(any("not compared" in note for note in report["notes"]))

    def test_verify_measures_errors(self):
        self.built_grid(6)
        errors = self.json("verify", "grid.ptet", "--samples", "all")["stated_errors"]
        self.assertEqual(errors["records"], self.json("info", "grid.ptet")["records"])
        self.assertTrue(errors["are_bounds"])
        self.assertEqual({e["above"] for e in errors["by_name"].values()}, {0})
        self.assertEqual(self.json("verify", "grid.ptet", "--samples", "7")["stated_errors"]["records"], 7)
        self.refused(2, "verify", "grid.ptet", "--samples", "0", says="--samples")
        self.ptet("build", "grid.vtu", "--method", "LN", "-o", "ln.ptet", "-q")
        errors = self.json("verify", "ln.ptet", "--samples", "all")["stated_errors"]
        self.assertFalse(errors["are_bounds"])
        self.assertGreater(sum(e["above"] for e in errors["by_name"].values()), 0)


class Checkpoints(Case):
    def interrupted(self, *arguments, name=signal.SIGTERM):
        """Starts a build that keeps checkpoints, and sends it the signal once there is one."""
        checkpoint = self.folder / "b.ckpt"
        with subprocess.Popen([PTET, "build", "grid.vtu", "--checkpoint", checkpoint.name, "--checkpoint-every", "0",
                               *arguments], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
            while not checkpoint.exists() and run.poll() is None:
                time.sleep(0.001)
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
        self.grid(22)  # 64 thousand tets: the program itself is no more than half of it
        for arguments in [["--method", "QN"], ["--threads", "2", "--target-vertices", "40%"],
                          ["--field", "smooth", "--evaluate", "vertices", "--threads", "1"]]:
            with self.subTest(arguments):
                report = self.json("build", "grid.vtu", *arguments)
                peak, foreseen = report["peak_memory_bytes"], report["foreseen_memory_bytes"]
                self.assertEqual(report["peak_memory_bytes_per_tet"], peak / report["input"]["tets"])
                self.assertGreater(peak, 200 * report["input"]["tets"])
                if b"__asan_init" in pathlib.Path(PTET).read_bytes():
                    continue  # there is more than the program asks for
                self.assertLessEqual(peak, foreseen)
                self.assertLessEqual(foreseen, 1.3 * peak + 40e6)  # the program and its libraries do not grow

    def test_a_limit_is_kept_before_it_is_passed(self):
        self.grid(16)
        self.ptet("build", "grid.vtu", "-q")
        whole = (self.folder / "grid.ptet").read_bytes()
        self.ptet("build", "grid.vtu", "-q", "--memory-limit", "64GiB")
        self.assertEqual((self.folder / "grid.ptet").read_bytes(), whole)
        (self.folder / "grid.ptet").unlink()
        # The head of the file is enough; then the counts of the mesh, before anything is made of it.
        self.refused(5, "build", "grid.vtu", "--memory-limit", "1M", says=["reading 24,576 cells", "allows 1,000,000"])
        self.refused(5, "build", "grid.vtu", "--memory-limit", "40M", "--threads", "2",
                     says=["24576 tets", "would take up to", "the limit is 40 MB"])
        self.assertEqual(self.files(), ["grid.vtu"])


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
        meshes.vtu(self.folder / "crossed.vtu", [*points, *((x + 0.3, y + 0.3, z + 0.3) for x, y, z in points)],
                   [*tets, *([v + len(points) for v in tet] for tet in tets)])
        report = self.json("measure", "fine.vtu", "crossed.vtu")
        self.assertGreater(report["simplified"]["validity"]["boundary_self_intersections"], 0)
        self.assertEqual(report["simplified"]["validity"]["components"], 2)
        self.assertIn("no floating-point field", report["notes"][0])
        self.assertFalse(any("intersects itself" in note for note in report["notes"]))
        report = self.json("measure", "crossed.vtu", "fine.vtu")
        self.assertTrue(any("intersects itself" in note for note in report["notes"]))

    def test_errors_as_a_mesh(self):
        self.cube("fine.vtu", 4, self.quadratic)
        self.cube("coarse.vtu", 2, self.quadratic)
        self.ptet("measure", "fine.vtu", "coarse.vtu", "--errors", "errors.vtu")
        fields = {field["name"]: field for field in self.json("info", "errors.vtu")["fields"]}
        self.assertAlmostEqual(fields["q error"]["max"], 1 / 16, delta=1e-12)
        self.assertEqual(fields["q error"]["min"], 0)
        self.assertIn("flow error", fields)
        self.refused(2, "measure", "fine.vtu", "coarse.vtu", "--errors", "errors.vtk", says=".vtu")
        self.refused(2, "measure", "fine.vtu", "coarse.vtu", "--errors", "fine.vtu", says="fine.vtu")
        self.refused(2, "measure", "fine.vtu", "coarse.vtu", "--errors", "coarse.vtu", says="coarse.vtu")
        self.refused(2, "measure", "fine.vtu", "coarse.vtu", "--errors", "e.vtu", "--samples", 9, says="--errors")
        self.assertEqual(self.files(), ["coarse.vtu", "errors.vtu", "fine.vtu"])

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
        motorbike = self.mesh("motorbike.vtu")
        for name, after in [(signal.SIGINT, 0.2), (signal.SIGINT, 3.0), (signal.SIGTERM, 6.0)]:
            with self.subTest(signal=name, after=after):
                with subprocess.Popen([PTET, "build", str(motorbike), "-o", "m.ptet"], cwd=self.folder,
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
                with subprocess.Popen([PTET, "measure", str(motorbike), str(motorbike), "--errors", "e.vtu"],
                                      cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
                    time.sleep(after)
                    run.send_signal(signal.SIGINT)
                    out, err = run.communicate(timeout=120)
                self.assertEqual((run.returncode, out), (130, b""), err)
                self.assertEqual(err, b"ptet: interrupted; nothing was written\n")
                self.assertEqual(self.files(), [])

    def test_a_second_interrupt_kills_at_once(self):
        motorbike = self.mesh("motorbike.vtu")
        with subprocess.Popen([PTET, "build", str(motorbike), "-o", "m.ptet"], cwd=self.folder,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
            time.sleep(1.0)
            run.send_signal(signal.SIGINT)
            time.sleep(0.1)
            run.send_signal(signal.SIGINT)
            self.assertIn(run.wait(timeout=10), (-signal.SIGINT, 130))


if __name__ == "__main__":
    if len(sys.argv) < 2 or shutil.which(sys.argv[1]) is None:
        sys.exit("usage: test_cli.py PTET [unittest options]")
    PTET = str(pathlib.Path(shutil.which(sys.argv.pop(1))).resolve())
    unittest.main()
