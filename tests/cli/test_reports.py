"""What the commands say and write of a file that is well: reports, extractions, verifications.
Usage: test_reports.py PTET [unittest options]"""
import json
import os
import re
import sys

sys.dont_write_bytecode = True  # leaves the source tree as it is
import case  # noqa: E402
import meshes  # noqa: E402
from case import Case  # noqa: E402


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
            self.assertEqual(report["base"]["vertices"], 146)
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

    def test_stuck_builds_name_the_option_that_holds_them(self):
        self.grid(6)
        options = ["--max-star", "12", "--target-vertices", "1", "--force"]
        report = self.json("build", "grid.vtu", "-o", "stuck.ptet", *options)
        self.assertIn("star too large", report["stopped_by"])
        refused = report["last_refusals"]
        self.assertEqual(max(refused, key=refused.get), "star too large")
        text = self.ptet("build", "grid.vtu", "-o", "stuck.ptet", *options).stdout
        self.assertRegex(text, r"hint +--max-star 12 refused [\d,]+ of the last [\d,]+ collapses .*; a larger one")
        done = self.json("build", "grid.vtu", "-o", "done.ptet", "--target-vertices", "90%")
        self.assertEqual((done["stopped_by"], done["last_refusals"]), ("target", {}))

    def test_a_whole_percentage_is_not_a_count(self):
        self.grid(4)
        self.assertEqual(self.json("build", "grid.vtu", "--target-vertices", "100%")["records"], 0)

    def test_points_in_no_tet_count_in_no_level(self):
        points, tets = meshes.grid(5)
        used = len(points)
        points = points + [(9.0 + i, 0.0, 0.0) for i in range(3 * used)]
        meshes.vtu(self.folder / "un.vtu", points, tets, {"f": ("Float64", [x * y for x, y, z in points])})
        built = self.json("build", "un.vtu", "--target-vertices", "10%", "--method", "QN")
        self.assertEqual(built["input"]["vertices"], 4 * used)
        self.assertEqual(built["base"]["vertices"], -(-used // 10))
        self.assertEqual(built["base"]["vertices"] + built["records"], used)
        self.assertEqual(built["walk"][-1]["vertices"], built["base"]["vertices"])
        info = self.json("info", "un.ptet", "--levels")
        self.assertEqual(info["base"], built["base"])
        self.assertEqual(self.json("extract", "un.ptet", "--vertices", "0")["vertices"], built["base"]["vertices"])
        level, cut = info["levels"][-1], self.json("extract", "un.ptet", "--field-error", "0", "--domain-error", "0")
        self.assertEqual((level["vertices"], level["tets"]), (cut["vertices"], cut["tets"]))

    def test_one_percent_is_what_a_build_goes_down_to(self):
        points, tets = meshes.grid(6)
        meshes.vtu(self.folder / "six.vtu", points, tets, {"f": ("Float64", [x * y for x, y, z in points])})
        self.ptet("build", "six.vtu", "-o", "default.ptet", "--method", "QN")
        self.ptet("build", "six.vtu", "-o", "told.ptet", "--method", "QN", "--target-vertices", "1%")
        self.assertEqual((self.folder / "default.ptet").read_bytes(), (self.folder / "told.ptet").read_bytes())

    def test_a_build_states_the_errors_that_its_file_states(self):
        points, tets = meshes.grid(6)
        # Large where a rounded edge is cut off: at vertices that coarse meshes do not cover.
        points = [(x + 0.2 * y * y, y, z + 0.2 * x * x) for x, y, z in points]
        fields = {"f": ("Float64", [x * x + 9 * (y > 0.9) * x for x, y, z in points])}
        meshes.vtu(self.folder / "bent.vtu", points, tets, fields)
        built = self.json("build", "bent.vtu")
        info = self.json("info", "bent.ptet")
        self.assertEqual(built["stated"], {"field_error": {"f": info["fields"][0]["max_error"]},
                                           "domain_error": info["max_domain_error"]})
        said = self.ptet("build", "bent.vtu", "--force").stdout
        stated = re.search(r"field +f:.*error up to (\S+) ", self.ptet("info", "bent.ptet").stdout).group(1)
        self.assertIn(f"  error     f up to {stated} (", said)
        fields["g"] = ("Float64", [1000 * z * z for x, y, z in points])
        meshes.vtu(self.folder / "both.vtu", points, tets, fields)
        both = self.json("build", "both.vtu", "--field", "g", "--field", "f")["stated"]["field_error"]
        self.assertEqual(both, {field["name"]: field["max_error"] for field in self.json("info", "both.ptet")["fields"]})
        self.assertEqual("; at vertices outside of a mesh up to " in said,
                         built["field_error"]["f"] > built["stated"]["field_error"]["f"])

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
        self.assertEqual(first, {"field_error": {"smooth": 0, "bumpy": 0}, "domain_error": 0, "tets": 6 * 8 * 8})
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

    def test_budgets_of_bytes_and_time(self):
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
        self.assertEqual(set(report), {"asked", "achieved", "vertices", "tets", "bytes", "bytes_read", "read_requests",
                                       "seconds", "limited_by", "complete", "failures", "notes", "output"})
        self.assertEqual(report["notes"], [])
        self.assertIsNone(report["output"])
        self.assertEqual(report["limited_by"], "error")
        asked, achieved = report["asked"], report["achieved"]
        self.assertAlmostEqual(asked["field_error"]["smooth"], 0.4)
        self.assertEqual(asked["field_error"]["bumpy"], 0.02)
        self.assertAlmostEqual(asked["domain_error"], 0.01 * 3 ** 0.5)
        for field, bound in asked["field_error"].items():
            self.assertLessEqual(achieved["field_error"][field], bound)
        self.assertLessEqual(achieved["domain_error"], asked["domain_error"])
        self.assertEqual(set(achieved), {"field_error", "domain_error", "errors_are_bounds", "overlaps_itself", "rms_error",
                                         "covered"})
        self.assertLess(report["vertices"], 729)

    def test_budgets(self):
        self.built_grid(8)
        for option, key, limit in [("--tets", "tets", 1500), ("--vertices", "vertices", 200)]:
            report = self.json("extract", "grid.ptet", option, limit)
            self.assertLessEqual(report[key], limit)
            self.assertEqual(report["limited_by"], "budget")
        self.assertLessEqual(self.json("extract", "grid.ptet", "--vertices", "30%")["vertices"], 218)
        self.assertEqual(self.json("extract", "grid.ptet", "--vertices", "100%")["vertices"], 729)
        self.built_grid(9)  # .57 x 1000 is below 570 in doubles
        self.assertEqual(self.json("extract", "grid.ptet", "--vertices", "57%")["asked"]["vertices"], 570)

    def test_what_does_not_fit_into_memory(self):
        self.built_grid(12)
        self.refused(5, "extract", "grid.ptet", "--memory-limit", "10k", says="memory")
        self.refused(5, "extract", "grid.ptet", "--memory-limit", "900k", "-o", "part.vtu", says="--memory-limit")
        self.assertFalse((self.folder / "part.vtu").exists())
        self.assertTrue(self.json("extract", "grid.ptet", "--memory-limit", "1G")["complete"])
        part = self.ptet("extract", "grid.ptet", "--memory-limit", "900k", "--salvage", "--json", code=5)
        report = json.loads(part.stdout)
        self.assertEqual((report["limited_by"], report["complete"]), ("memory", False))
        self.assertLess(report["vertices"], 13 ** 3)

    def test_places_are_told_with_digits_enough(self):
        points, tets = meshes.grid(3, origin=(5e5, 4.5e6, 0.0))
        values = {"high": ("Float64", [1e10 + x - 5e5 for x, _, _ in points])}
        meshes.vtu(self.folder / "far.vtu", points, tets, values)
        text = self.ptet("info", "far.vtu").stdout
        self.assertIn("box       (500000, 4500000, 0) to (500001, 4500001, 1)", text)
        self.assertIn("from 10000000000 to 10000000001", text)
        self.ptet("build", "far.vtu", "-q")
        self.assertIn("box       (500000, 4500000, 0) to (500001, 4500001, 1)", self.ptet("info", "far.ptet").stdout)
        text = self.ptet("extract", "far.ptet", "--focus", "box:500000,4500000,0,500000.25,4500000.5,1",
                         "--isovalue", "high=10000000000.5").stdout
        self.assertIn("box (500000, 4500000, 0) to (500000.25, 4500000.5, 1)", text)
        self.assertIn("high = 10000000000.5", text)

    def test_integers_alone_are_compared(self):
        points, tets = meshes.grid(4)
        values = {"count": ("Int32", [int(40 * x * y + 9 * z) for x, y, z in points])}
        meshes.vtu(self.folder / "whole.vtu", points, tets, values)
        self.ptet("build", "whole.vtu", "-q")  # without a floating-point array they govern
        self.ptet("extract", "whole.ptet", "--vertices", "40%", "-o", "part.vtu")
        stated = self.json("extract", "whole.ptet", "--vertices", "40%")["achieved"]["field_error"]["count"]
        report = self.ptet("measure", "whole.vtu", "part.vtu").stdout
        self.assertIn("field       count, range", report)
        found = self.json("measure", "whole.vtu", "part.vtu")["inside"]["fields"]["count"]["max"]
        self.assertTrue(0 < found <= stated, (found, stated))

    def test_pipes_are_refused_at_once(self):
        self.built_grid(3)
        os.mkfifo(self.folder / "pipe")
        for command in ["build", "info", "extract", "verify", "dump"]:
            with self.subTest(command):
                self.refused(6, command, "pipe", says="it is not a regular file")
        for one, other in [("pipe", "grid.vtu"), ("grid.vtu", "pipe")]:
            self.refused(6, "measure", one, other, says="it is not a regular file")
        self.refused(6, "build", "grid.vtu", "-o", "/dev/stdout",
                     says="cannot write '/dev/stdout': it is not a regular file")

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

    def test_wishes_that_meet_nothing_are_named(self):
        self.built_grid(4)
        inside, outside = "box:0.1,0.1,0.1,0.2,0.2,0.2", "sphere:3,0,0,1"
        notes = self.json("extract", "grid.ptet", "--focus", inside, "--focus", outside)["notes"]
        self.assertEqual(len(notes), 1)
        self.assertIn("no tet of the mesh meets focus 2: the mesh is in the box (0, 0, 0) to (1, 1, 1)", notes[0])
        text = self.ptet("extract", "grid.ptet", "--focus", outside).stdout
        self.assertIn("  note      no tet of the mesh meets the focus: ", text)
        self.assertNotIn("  note", self.ptet("extract", "grid.ptet", "--focus", inside).stdout)
        notes = self.json("extract", "grid.ptet", "--view", "eye=-9,0,0:at=-10,0,0")["notes"]
        self.assertEqual(notes, ["nothing of the mesh is in the view: the mesh is in the box (0, 0, 0) to (1, 1, 1)"])
        self.assertEqual(self.json("extract", "grid.ptet", "--view", "eye=-9,0,0:at=0,0,0")["notes"], [])
        # smooth is from -1 to 3
        for values in (["--isovalue", "smooth=3.5"], ["--values", "smooth=..-1.5"]):
            notes = self.json("extract", "grid.ptet", *values)["notes"]
            self.assertEqual(len(notes), 1, values)
            self.assertRegex(notes[0], "^nothing of the mesh has the values asked for: smooth is from -.* to .* in it$")
        for values in (["--isovalue", "smooth=1.5"], ["--values", "smooth=0..9"], ["--values", "smooth=.."]):
            self.assertEqual(self.json("extract", "grid.ptet", *values)["notes"], [], values)

    def test_what_stl_cannot_hold_is_said(self):
        points, tets = meshes.grid(3, origin=(1e7, -1e7, 0.0))
        meshes.vtu(self.folder / "far.vtu", points, tets, meshes.wave(points))
        self.ptet("build", "far.vtu", "--quiet")
        notes = self.json("extract", "far.ptet", "-o", "far.stl")["notes"]
        self.assertEqual(len(notes), 1)
        self.assertRegex(notes[0], r"^the 32-bit floats of \.stl moved vertices by up to .* of the diagonal\), "
                                   r"[0-9]+ faces lost all area; \.obj, ")
        self.assertEqual(self.json("extract", "far.ptet", "-o", "far.obj")["notes"], [])
        lines = (self.folder / "far.obj").read_text().splitlines()
        found = {tuple(map(float, line.split()[1:])) for line in lines if line.startswith("v ")}
        on_boundary = {p for p in points if p[0] in (1e7, 1e7 + 1) or p[1] in (-1e7, 1 - 1e7) or p[2] in (0, 1)}
        self.assertEqual(found, on_boundary)

    def test_the_original_comes_back(self):
        self.built_grid(6)
        self.ptet("extract", "grid.ptet", "-o", "full.vtu")
        self.assertTrue(self.json("verify", "grid.ptet", "--original", "full.vtu")["ok"])

    def test_errors_that_are_no_bounds_are_called_so(self):
        points, tets = meshes.grid(6)
        meshes.vtu(self.folder / "grid.vtu", points, tets, meshes.wave(points))
        for evaluate, are_bounds in [("none", False), ("exact", True)]:
            self.ptet("build", "grid.vtu", "--method", "QN", "--evaluate", evaluate, "-o", "qn.ptet", "--quiet")
            self.assertEqual(self.json("info", "qn.ptet")["errors_are_bounds"], are_bounds)
            report = self.json("extract", "qn.ptet", "--tets", "20%")
            self.assertEqual(report["achieved"]["errors_are_bounds"], are_bounds)
            self.assertTrue(self.json("extract", "qn.ptet")["achieved"]["errors_are_bounds"])  # the original
            said = self.ptet("extract", "qn.ptet", "--tets", "20%").stdout
            for text in [" within ", " about ", "the true ones may be larger"]:
                self.assertEqual(text in said, are_bounds == (text == " within "), text)
            self.assertEqual("the true ones may be larger" in self.ptet("info", "qn.ptet").stdout, not are_bounds)

    def test_a_budget_of_bytes_counts_what_it_is_about(self):
        points, tets = meshes.grid(6)
        meshes.vtu(self.folder / "grid.vtu", points, tets, meshes.wave(points))
        self.ptet("build", "grid.vtu", "--method", "QN", "--keep-order", "-o", "kept.ptet", "--quiet")
        whole = self.json("extract", "kept.ptet")["bytes"]
        done = self.ptet("extract", "kept.ptet", "--bytes", str(whole // 2), "--input-order", "-o", "half.vtu")
        self.assertIn("budget: the next split does not fit", done.stdout)

    def test_the_order_of_arrays_is_not_that_of_the_input(self):
        points, tets = meshes.grid(3)
        fields = meshes.wave(points)
        meshes.vtu(self.folder / "given.vtu", points, tets, fields)
        self.ptet("build", "given.vtu", "--method", "QN", "--keep-order", "-o", "kept.ptet", "--quiet")
        meshes.vtu(self.folder / "turned.vtu", points, tets, dict(reversed(fields.items())))
        self.assertTrue(self.json("verify", "kept.ptet", "--original", "turned.vtu")["ok"])

    def test_it_comes_back_as_it_stood(self):
        points, tets = meshes.grid(5)
        points, tets = points[::-1], [[len(points) - 1 - v for v in tet] for tet in tets[::-1]]  # inverted, too
        meshes.vtu(self.folder / "given.vtu", points, tets, meshes.wave(points))
        report = self.json("build", "given.vtu", "--keep-order", "-o", "kept.ptet")
        self.assertTrue(report["keep_order"])
        self.assertTrue(self.json("info", "kept.ptet")["has_input_order"])
        for ending in ["vtu", "vtk"]:
            self.ptet("extract", "kept.ptet", "--input-order", "-o", f"again.{ending}")
            for original in ["given.vtu", f"again.{ending}"]:
                self.assertTrue(self.json("verify", "kept.ptet", "--original", original)["ok"])
        self.ptet("extract", "kept.ptet", "-o", "other.vtu")
        self.ptet("verify", "kept.ptet", "--original", "other.vtu", code=4)
        # What is the same but for its order is not what was given.
        meshes.vtu(self.folder / "other.vtu", points, tets[1:] + tets[:1], meshes.wave(points))
        done = self.ptet("verify", "kept.ptet", "--original", "other.vtu", code=4)
        self.assertIn("the order that is kept is not that of the original", done.stdout)
        self.ptet("build", "given.vtu", "-o", "plain.ptet", "--quiet")
        self.assertFalse(self.json("info", "plain.ptet")["has_input_order"])
        self.refused(2, "extract", "plain.ptet", "--input-order", "-o", "x.vtu", says=["--input-order", "--keep-order"])
        self.refused(2, "extract", "kept.ptet", "--input-order", "-o", "x.ply", says=["--input-order", ".vtu"])
        # A mesh that has come out in this way goes in again.
        report = self.json("extract", "kept.ptet", "--input-order", "--tets", "50%", "-o", "part.vtu")
        self.assertTrue(report["asked"]["input_order"])
        self.ptet("build", "part.vtu", "--keep-order", "-o", "part.ptet", "--quiet")
        self.ptet("extract", "part.ptet", "--input-order", "--tets", "50%", "-o", "less.vtu")
        names = [field["name"] for field in self.json("info", "less.vtu")["fields"]]
        self.assertEqual(sorted(names), ["bumpy", "input vertex", "input vertex 2", "smooth"])
        size = lambda name: (self.folder / name).stat().st_size
        self.assertLess(size("plain.ptet"), size("kept.ptet"))

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


if __name__ == "__main__":
    case.main()
