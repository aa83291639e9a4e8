"""What a user types, and what is refused: help, options, input, files. What is reported: test_reports.py; what builds and
measurements come to: test_builds.py.
Usage: test_cli.py PTET [unittest options]"""
import fcntl
import json
import os
import pty
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import termios

sys.dont_write_bytecode = True  # leaves the source tree as it is
import case  # noqa: E402
import meshes  # noqa: E402
from case import Case, program  # noqa: E402

COMMANDS = {
    "build": ["--output", "--field", "--max-field-error", "--max-domain-error", "--target-vertices", "--min-quality",
              "--method", "--objective", "--predict", "--evaluate", "--max-star", "--pieces", "--keep-order",
              "--threads", "--memory-limit", "--checkpoint", "--checkpoint-every", "--resume", "--force", "--json", "--quiet"],
    "extract": ["--output", "--field-error", "--domain-error", "--tets", "--vertices", "--bytes", "--milliseconds",
                "--focus", "--focus-error", "--focus-falloff", "--isovalue", "--values", "--view", "--pixels",
                "--outside", "--errors", "--input-order", "--salvage", "--json"],
    "info": ["--levels", "--json"],
    "measure": ["--field", "--exact", "--samples", "--seed", "--tolerance", "--threads", "--errors", "--json"],
    "verify": ["--original", "--samples", "--json"],
    "dump": ["--annotate"],
}


class Help(Case):
    def test_what_was_mistyped_is_named_with_what_may_be_meant(self):
        for command, typed, says in (("extract", ["--feild-error", "1%"], "did you mean '--field-error'?"),
                                     ("build", ["--objecitve=max"], "'--objecitve'; did you mean '--objective'?"),
                                     ("build", ["--nonsense", "3"], "there is no option '--nonsense';"),
                                     ("info", ["b.vtu"], "'b.vtu' was not expected")):
            self.refused(2, command, "a.ptet", *typed, says=[says, f"'ptet {command} --help'"])

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
                      "--memory-limit": ["", "0", "0GB", "-1", "1.5", "G", "8T", "-8G"]},
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
        self.refused(2, "extract", "grid.ptet", "--view", "eye=-1e308,0,0:at=1e308,0,0", says="too far")
        self.ptet("extract", "grid.ptet", "--view", "eye=1e200,0,0:at=0,0,0")
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
        fields["empty"] = ("Float32", [float("nan")] * len(points))
        meshes.vtu(self.folder / "nan.vtu", points, tets, fields)
        self.refused(3, "build", "nan.vtu", says=["bumpy", "7"])
        # Where it does not govern it is carried along, bit for bit.
        self.ptet("build", "nan.vtu", "--field", "smooth")
        self.ptet("verify", "nan.ptet", "--original", "nan.vtu")
        said = self.ptet("info", "nan.vtu").stdout
        self.assertIn("not finite at 1 vertex", said)
        self.assertIn("  field     empty: float32, not finite at 64 vertices\n", said)
        self.assertIsNone(self.json("info", "nan.vtu")["fields"][2]["min"])
        self.assertIn("can be built from, if --field names others than 'bumpy', 'empty'", said)

    def test_names_with_control_characters(self):
        (self.folder / "bell.vtk").write_text("""# vtk DataFile Version 3.0
t
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 float
0 0 0 1 0 0 0 1 0 0 0 1
CELLS 1 5
4 0 1 2 3
CELL_TYPES 1
10
POINT_DATA 4
SCALARS a%1B[31mb float 1
LOOKUP_TABLE default
0 1 2 3
""")
        said = self.ptet("info", "bell.vtk").stdout
        self.assertIn("  field     a?[31mb: float32", said)
        self.assertNotIn("\x1b", said)
        self.refused(2, "build", "bell.vtk", "--field", "b", says="'a?[31mb'")
        self.assertEqual(self.json("info", "bell.vtk")["fields"][0]["name"], "a\x1b[31mb")
        text = (self.folder / "bell.vtk").read_text().replace("%1B[31m", "%7F%C2%9B%C2%A9")
        (self.folder / "late.vtk").write_text(text)
        self.assertIn("  field     a??\u00a9b: float32", self.ptet("info", "late.vtk").stdout)
        self.assertIn('"name": "a\\u007f\\u009b\u00a9b"', self.ptet("info", "late.vtk", "--json").stdout)
        self.assertEqual(self.json("info", "late.vtk")["fields"][0]["name"], "a\x7f\u009b\u00a9b")
        text = (self.folder / "bell.vtk").read_text().replace("%1B[31m", "%0A%20%20error%20none")
        (self.folder / "forged.vtk").write_text(text)
        self.assertIn("  field     a?  error noneb: float32", self.ptet("info", "forged.vtk").stdout)
        self.assertNotIn("note", said)
        # Of 3.25 something else would be left.
        text = (self.folder / "bell.vtk").read_text()
        (self.folder / "cut.vtk").write_text(text[:-1])
        self.assertIn("  note      the last line has no end", self.ptet("info", "cut.vtk").stdout)

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
        for start, hint in [(b"\x1f\x8b\x08\0", "gzip"), (b"PK\x03\x04", "ZIP"), (b"$MeshFormat\n4.1 0 8\n", "Gmsh"),
                            (b"# vtk DataFile Version 3.0\rt\rASCII\r", "carriage returns"),
                            (b'<VTKFile type="Collection"><Collection/></VTKFile>', "name one of them")]:
            (self.folder / "other").write_bytes(start)
            self.refused(3, "info", "other", says=hint)
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
        extracted = self.json("extract", "one.ptet", "-o", "again.VTU")
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

    def test_an_extracted_mesh_does_not_take_the_place_of_the_original(self):
        self.built_grid(3)
        original = (self.folder / "grid.vtu").read_bytes()
        self.refused(2, "extract", "grid.ptet", "--tets", "10", "-o", "grid.vtu", says=["grid.vtu", "built from"])
        # By what it is, not by its name.
        (self.folder / "grid.vtu").rename(self.folder / "renamed.vtu")
        self.refused(2, "extract", "grid.ptet", "--tets", "10", "-o", "renamed.vtu", says=["renamed.vtu", "built from"])
        self.assertEqual((self.folder / "renamed.vtu").read_bytes(), original)
        self.ptet("extract", "grid.ptet", "--tets", "10", "-o", "grid.vtu")
        self.ptet("extract", "grid.ptet", "--tets", "20", "-o", "grid.vtu")

    def test_the_option_is_named_that_is_meant(self):
        self.built_grid(3)
        before = (self.folder / "grid.vtu").read_bytes()
        for option, command in [("-o", ["extract", "grid.ptet", "-o", ""]),
                                ("--checkpoint", ["build", "grid.vtu", "-o", "a.ptet", "--checkpoint", ""]),
                                ("--checkpoint", ["build", "grid.vtu", "-o", "a.ptet", "--checkpoint", "grid.vtu"]),
                                ("--errors", ["measure", "grid.vtu", "grid.vtu", "--errors", "grid.vtu"])]:
            with self.subTest(command):
                self.refused(2, *command, says=f"error: {option}")
        self.assertEqual((self.folder / "grid.vtu").read_bytes(), before)

    def test_a_link_stays_a_link(self):
        self.grid(2)
        (self.folder / "elsewhere").mkdir()
        (self.folder / "elsewhere" / "real.ptet").write_bytes(b"")
        (self.folder / "grid.ptet").symlink_to("elsewhere/real.ptet")
        self.ptet("build", "grid.vtu", "--quiet")
        self.assertTrue((self.folder / "grid.ptet").is_symlink())
        self.ptet("verify", "elsewhere/real.ptet")

    def test_a_link_to_a_file_that_is_not_there_yet_stays_one(self):
        self.grid(2)
        (self.folder / "elsewhere").mkdir()
        (self.folder / "grid.ptet").symlink_to("elsewhere/real.ptet")
        self.ptet("build", "grid.vtu", "--quiet")
        self.assertTrue((self.folder / "grid.ptet").is_symlink())
        self.ptet("verify", "elsewhere/real.ptet")

    def test_names_that_cannot_be_written_are_refused_before_the_work(self):
        (self.folder / "none.vtu").write_bytes(b"")  # would be refused as an input
        (self.folder / "a.ptet").symlink_to("b.ptet")
        (self.folder / "b.ptet").symlink_to("a.ptet")
        (self.folder / "away.ptet").symlink_to("nowhere/real.ptet")
        for name, why in [("a.ptet", "symbolic links"), ("n" * 251 + ".ptet", "too long"), ("away.ptet", "no folder")]:
            with self.subTest(name):
                self.refused(6, "build", "none.vtu", "-o", name, says=[name, why])
        if os.geteuid() != 0:
            (self.folder / "kept.ptet").write_bytes(b"")
            (self.folder / "kept.ptet").chmod(0o444)
            self.refused(6, "build", "none.vtu", "-o", "kept.ptet", says="Permission denied")

    def test_a_file_that_cannot_be_replaced_is_refused_before_the_work(self):
        (self.folder / "none.vtu").write_bytes(b"")  # would be refused as an input
        for name in ["elsewhere", "mounted.ptet"]:
            (self.folder / name).write_bytes(b"")
        if os.geteuid() != 0 or subprocess.run(["mount", "--bind", "elsewhere", "mounted.ptet"], cwd=self.folder,
                                               stderr=subprocess.DEVNULL, check=False).returncode != 0:
            self.skipTest("needs the right to mount")
        self.addCleanup(subprocess.run, ["umount", self.folder / "mounted.ptet"], check=True)
        self.refused(6, "build", "none.vtu", "-o", "mounted.ptet", says=["mounted.ptet", "mounted there by itself"])

    def test_the_checkpoint_is_not_the_output_by_another_name(self):
        self.grid(2)
        (self.folder / "link.ckpt").symlink_to("a.ptet")
        for name in ["a.ptet", "./a.ptet", self.folder / "a.ptet", "link.ckpt"]:
            with self.subTest(name):
                self.refused(2, "build", "grid.vtu", "-o", "a.ptet", "--checkpoint", name, says="output file")
        self.assertEqual(self.files(), ["grid.vtu", "link.ckpt"])

    def test_an_empty_value_does_not_take_the_next_argument(self):
        self.built_grid(2)
        before = self.files()
        for option, command in [("--output", ["build", "grid.vtu", "--output=", "--force"]),
                                ("--tets", ["extract", "grid.ptet", "--tets=", "--json"]),
                                ("--field", ["build", "--field=", "grid.vtu"])]:
            with self.subTest(command):
                self.refused(2, *command, says=[f"error: {option}:", "missing"])
        self.assertEqual(self.files(), before)

    def test_same_bytes_on_any_number_of_threads(self):
        self.grid(8)
        for threads in [1, 2, 5]:
            self.ptet("build", "grid.vtu", "-o", f"{threads}.ptet", "--threads", threads, "--quiet")
        self.assertEqual((self.folder / "1.ptet").read_bytes(), (self.folder / "2.ptet").read_bytes())
        self.assertEqual((self.folder / "1.ptet").read_bytes(), (self.folder / "5.ptet").read_bytes())

    def test_threads_that_cannot_be_started_are_done_without(self):
        self.grid(8)
        self.ptet("build", "grid.vtu", "-o", "few.ptet", "--threads", 2, "--quiet")
        limited = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_AS, (2**29, 2**29))}
        if subprocess.run([program(), "--version"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                          check=False, **limited).returncode != 0:
            self.skipTest("the program itself needs more memory than that, as under sanitizers")
        self.ptet("build", "grid.vtu", "-o", "many.ptet", "--threads", 1000, "--quiet", **limited)
        self.assertEqual((self.folder / "few.ptet").read_bytes(), (self.folder / "many.ptet").read_bytes())
        self.ptet("measure", "grid.vtu", "grid.vtu", "--threads", 1000, **limited)

    def test_no_second_thread(self):
        self.grid(8)
        self.ptet("build", "grid.vtu", "-o", "two.ptet", "--threads", 2, "--quiet")
        copy = shutil.copy(program(), self.folder / "program")  # that anybody may run
        self.folder.chmod(0o777)

        def limit():
            resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))
            if os.geteuid() == 0:  # the limit is not for root
                os.setgid(65534)
                os.setuid(65534)

        def run(*arguments):
            done = subprocess.run([copy, *arguments], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  preexec_fn=limit, timeout=600, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, b""), arguments)

        run("build", "grid.vtu", "-o", "one.ptet", "--quiet")
        self.assertEqual((self.folder / "one.ptet").read_bytes(), (self.folder / "two.ptet").read_bytes())
        for ending in ["vtu", "vtk", "ply"]:
            run("extract", "one.ptet", "--field-error", "5%", "-o", f"cut.{ending}")
        run("measure", "grid.vtu", "cut.vtu", "--errors", "errors.vtu")
        run("verify", "one.ptet", "--original", "grid.vtu")
        run("info", "grid.vtu")

    def test_progress_keeps_to_one_line_of_a_narrow_terminal(self):
        self.grid(10)
        master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 12, 0, 0))
        subprocess.run([program(), "build", "grid.vtu", "--method", "QN"], cwd=self.folder, stdout=subprocess.DEVNULL,
                       stderr=slave, env={**os.environ, "TERM": "xterm"}, timeout=600, check=True)
        os.close(slave)
        shown = os.read(master, 1 << 16).decode()  # a terminal holds some 4 kB, which takes more than this build tells
        os.close(master)
        lines = [line.replace("\x1b[K", "") for line in shown.split("\r")]
        self.assertIn("collapsing ", lines)
        self.assertEqual([line for line in lines if len(line) > 11], [])

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
        closed = subprocess.run(f"{program()} info grid.ptet >&-", shell=True, cwd=self.folder, stderr=subprocess.PIPE,
                                encoding="utf-8", check=False)
        self.assertEqual(closed.returncode, 6, closed.stderr)

    def test_every_process_of_a_starter_does_its_own_work(self):
        self.built_grid(6)
        for names in [("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"), ("PMI_SIZE", "PMI_RANK")]:
            second = dict(os.environ, **dict(zip(names, ("2", "1"))))
            done = subprocess.run([program(), "info", "grid.ptet"], cwd=self.folder, env=second, encoding="utf-8",
                                  stdout=subprocess.PIPE, check=True)
            self.assertIn("grid.ptet: .ptet", done.stdout)
            done = subprocess.run([program(), "info", "nothing.ptet"], cwd=self.folder, env=second, encoding="utf-8",
                                  stderr=subprocess.PIPE, check=False)
            self.assertEqual(done.returncode, 6)
            self.assertIn("nothing.ptet", done.stderr)

    def test_a_reader_that_goes_away(self):
        self.built_grid(6)
        done = subprocess.run(f"{program()} dump --annotate grid.ptet | head -n 1", shell=True, cwd=self.folder,
                              capture_output=True, encoding="utf-8", check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_what_only_prints_ends_at_the_first_interrupt(self):
        self.built_grid(6)
        with subprocess.Popen([program(), "dump", "--annotate", "grid.ptet"], cwd=self.folder,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as run:
            self.assertTrue(run.stdout.read(100))  # the rest is more than a pipe holds: it waits
            run.send_signal(signal.SIGINT)
            self.assertEqual(run.wait(timeout=10), -signal.SIGINT)

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


if __name__ == "__main__":
    case.main()
