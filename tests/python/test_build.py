"""Building from arrays of every kind, and what is refused."""
import pathlib
import tempfile
import unittest

from support import built, cube

import numpy as np
import ptet

FAST = {"method": "QN"}


def vertex_order(cut, points):
    """For each vertex of the cut its row in the original points."""
    rows = {point.tobytes(): i for i, point in enumerate(points)}
    return np.array([rows[point.tobytes()] for point in cut.points])


class Build(unittest.TestCase):
    def test_what_goes_in_comes_out(self):
        points, tets, fields = cube()
        cut = ptet.build(points, tets, fields).open().extract()
        order = vertex_order(cut, points)
        self.assertEqual(cut.limited_by, "nothing")
        self.assertEqual(sorted(order), list(range(len(points))))
        for name, values in fields.items():
            self.assertEqual(cut.fields[name].dtype, values.dtype)
            np.testing.assert_array_equal(cut.fields[name], values[order])
        self.assertEqual({tuple(sorted(row)) for row in order[cut.tets].tolist()},
                         {tuple(sorted(row)) for row in tets.tolist()})

    def test_every_type_of_numbers(self):
        points, tets, fields = cube(3)
        for name in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"):
            values = (np.arange(2 * len(points)).reshape(-1, 2) % 50).astype(name)
            cut = ptet.build(points, tets, {"values": values, "t": fields["t"]}, **FAST).open().extract()
            self.assertEqual(cut.fields["values"].dtype, np.dtype(name))
            np.testing.assert_array_equal(cut.fields["values"], values[vertex_order(cut, points)])
        double = ptet.build(points.astype("f8"), tets, fields, **FAST).open()
        self.assertEqual(double.info.point_dtype, np.float64)
        self.assertEqual(double.extract().points.dtype, np.float64)

    def test_every_layout_gives_the_same_bytes(self):
        points, tets, fields = cube(4)
        wanted = bytes(ptet.build(points, tets, fields, **FAST).data)
        read_only = points.copy()
        read_only.flags.writeable = False
        spread = np.full((len(points), 7), np.nan, np.float32)
        spread[:, 1:6:2] = points
        layouts = {
            "Fortran order": (np.asfortranarray(points), np.asfortranarray(tets), fields),
            "read-only": (read_only, tets, fields),
            "strides": (spread[:, 1:6:2], tets, fields),
            "backwards": (points[::-1][::-1], np.ascontiguousarray(tets[:, ::-1])[:, ::-1], fields),
            "big-endian": (points.astype(">f4"), tets.astype(">i8"),
                           {name: values.astype(values.dtype.newbyteorder(">")) for name, values in fields.items()}),
            "uint8 and lists": (points.tolist() and points, tets.astype(np.uint8).tolist(), fields),
            "uint32": (points, tets.astype(np.uint32), fields),
            "uint64": (points, tets.astype(np.uint64), fields),
            "int16": (points, tets.astype(np.int16), fields),
        }
        for name, (p, t, f) in layouts.items():
            with self.subTest(name):
                self.assertEqual(bytes(ptet.build(p, t, f, **FAST).data), wanted)

    def test_threads_do_not_matter(self):
        self.assertEqual(bytes(ptet.build(*cube(), threads=1).data), built())
        self.assertEqual(bytes(ptet.build(*cube(), threads=3).data), built())
        whole = ptet.build(*cube(), memory_limit=2**40)
        self.assertEqual(bytes(whole.data), built())
        self.assertGreater(whole.report.peak_memory_bytes, 0)
        self.assertRaisesRegex(ptet.LimitError, "of memory", ptet.build, *cube(), memory_limit=1000)

    def test_pieces(self):
        points, tets, fields = cube()
        in_pieces = ptet.build(points, tets, fields, pieces=4)
        self.assertEqual(bytes(ptet.build(points, tets, fields, pieces=4, threads=1).data), bytes(in_pieces.data))
        self.assertNotEqual(bytes(in_pieces.data), built())
        cut = in_pieces.open().extract()
        self.assertEqual({tuple(sorted(row)) for row in vertex_order(cut, points)[cut.tets].tolist()},
                         {tuple(sorted(row)) for row in tets.tolist()})
        for wrong in (0, 65537, 1.5):
            self.assertRaisesRegex(ptet.ArgumentError, "pieces", ptet.build, *cube(), pieces=wrong)

    def test_points_that_are_alike_are_welded(self):
        points, tets, fields = cube()
        half = len(tets) // 2
        apart = np.concatenate([tets[:half], tets[half:] + len(points)])  # each half with points of its own
        twice = {name: np.concatenate([values, values]) for name, values in fields.items()}
        built_from = np.concatenate([points, points]), apart, twice
        welded = ptet.build(*built_from, weld=True, target_vertices="10%")
        self.assertEqual(welded.report.input_vertices, len(points))
        self.assertIn(f"{len(points)} points were welded", welded.report.notes[0])
        self.assertEqual(welded.report.base_vertices, -(-len(points) // 10))
        self.assertEqual(ptet.build(*built_from).report.input_vertices, 2 * len(points))
        whole = welded.open().extract()
        self.assertEqual((len(whole.points), len(whole.tets)), (len(points), len(tets)))
        seam = len(np.intersect1d(tets[:half], tets[half:]))  # what is in no tet stays
        rounded = np.concatenate([points, points.astype(np.float64) + 1e-13]), apart, twice
        self.assertEqual(ptet.build(*rounded, weld=True).report.input_vertices, 2 * len(points))
        for within in 1e-11, "1e-9%":
            report = ptet.build(*rounded, weld=within).report
            self.assertEqual(report.input_vertices, 2 * len(points) - seam)
            self.assertIn("nearly the same place", report.notes[0])
        for wrong in "1%", -1.0, "near", 1.0:
            self.assertRaises(ptet.ArgumentError, ptet.build, *rounded, weld=wrong)

    def test_the_order_of_the_input(self):
        points, tets, fields = cube()
        order = np.random.default_rng(3).permutation(len(points))
        points, fields = points[order], {name: values[order] for name, values in fields.items()}
        tets = np.argsort(order)[tets][::-1, [2, 0, 3, 1]]  # all of them inverted
        data = ptet.build(points, tets, fields, keep_order=True).open()
        self.assertTrue(data.info.has_input_order)
        self.assertFalse(data.info.overlaps_itself)
        self.assertEqual(data.info.errors_are_bounds, data.info.provenance["options"]["evaluate"] == "exact")
        whole = data.extract(input_order=True)
        np.testing.assert_array_equal(whole.points, points)
        np.testing.assert_array_equal(whole.tets, tets)
        for name, values in fields.items():
            np.testing.assert_array_equal(whole.fields[name], values)
        np.testing.assert_array_equal(whole.input_vertex, np.arange(len(points)))
        part = data.extract(budget="20%", input_order=True)
        self.assertLess(len(part.points), len(points))
        np.testing.assert_array_equal(part.points, points[part.input_vertex])
        self.assertIsNone(data.extract().input_vertex)
        without = ptet.open(built())
        self.assertFalse(without.info.has_input_order)
        self.assertRaisesRegex(ptet.ArgumentError, "keep the order", without.extract, input_order=True)

    def test_a_file_is_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a mésh.ptet"
            made = ptet.build(*cube(), out=path)
            self.assertIsNone(made.data)
            self.assertEqual(made.path, str(path))
            self.assertEqual(path.read_bytes(), built())
            self.assertEqual(made.open().info, ptet.open(path).info)
            with self.assertRaises(ptet.FileError):
                ptet.build(*cube(3), out=pathlib.Path(folder) / "none" / "x.ptet", **FAST)

    def test_report(self):
        points, tets, fields = cube()
        made = ptet.build(points, tets, fields, target_vertices="20%", source_name="cube", source_hash="abc")
        report, info = made.report, made.open().info
        self.assertEqual((report.input_vertices, report.input_tets), (len(points), len(tets)))
        self.assertEqual((info.base_vertices, info.base_tets), (report.base_vertices, report.base_tets))
        self.assertEqual(report.base_vertices, -(-len(points) // 5))
        self.assertEqual(report.records, len(points) - report.base_vertices)
        self.assertEqual(report.collapses["accepted"], report.records)
        self.assertEqual(report.file_bytes, len(made.data))
        self.assertEqual(len(report.walk), report.rounds)
        self.assertEqual(report.walk[-1].vertices, report.base_vertices)
        self.assertEqual(set(report.field_error), {"t", "flow"})
        self.assertEqual(info.provenance["source_name"], "cube")
        self.assertEqual(info.provenance["source_hash"], "abc")
        self.assertEqual([field.governing for field in info.fields], [True, True, False])

    def test_options_reach_the_library(self):
        points, tets, fields = cube()
        options = {"govern": "t", "method": "BF", "objective": "max", "max_domain_error": 0.01, "max_star": 40,
                   "round_fraction": 0.2, "min_quality": 0.01, "target_vertices": 200, "max_field_error": {"t": "8%"}}
        made = ptet.build(points, tets, fields, **options)
        told = made.open().info.provenance["options"]
        for name, value in {"field": "t", "predict": "simulate", "evaluate": "vertices", "objective": "max",
                            "max-star": "40", "round-fraction": "0.2", "min-quality": "0.01",
                            "target-vertices": "200", "max-domain-error": "0.01"}.items():
            self.assertEqual(told[name], value)
        info = made.open().info
        self.assertLessEqual(info.max_field_error["t"], 0.08 * info.field("t").range * (1 + 1e-12))

    def test_arrays_that_are_refused(self):
        points, tets, fields = cube(3)
        n = len(points)
        for error, says, arguments in [
            (ptet.ArgumentError, "shape", (points[:, :2], tets, fields)),
            (ptet.ArgumentError, "shape", (points.ravel(), tets, fields)),
            (ptet.ArgumentError, "shape", (points, tets[:, :3], fields)),
            (ptet.ArgumentError, "shape", (points, tets.ravel(), fields)),
            (ptet.ArgumentError, "shape", (points, tets, {"t": fields["t"][:-1]})),
            (ptet.ArgumentError, "shape", (points, tets, {"t": np.zeros((n, 2, 2))})),
            (ptet.ArgumentError, "shape", (points, tets, {"t": np.zeros((n, 0))})),
            (ptet.ArgumentError, "shape", (points, tets, {"t": 3.0})),
            (ptet.ArgumentError, "whole numbers", (points, tets.astype(np.float64), fields)),
            (ptet.ArgumentError, "float16", (points.astype(np.float16), tets, fields)),
            (ptet.ArgumentError, "bool", (points, tets, {"t": np.zeros(n, bool)})),
            (ptet.ArgumentError, "complex", (points, tets, {"t": np.zeros(n, complex)})),
            (ptet.ArgumentError, "object", (points, tets, {"t": np.array([None] * n)})),
            (ptet.ArgumentError, "float128", (points, tets, {"t": np.zeros(n, np.longdouble)})),
            (ptet.ArgumentError, "masked", (points, tets, {"t": np.ma.masked_less(fields["t"], 0.5)})),
            (ptet.ArgumentError, "no name", (points, tets, {3: fields["t"]})),
            (ptet.ArgumentError, "", (points, [[0, 1, 2], [0, 1]], fields)),
            (ptet.InputError, str(n), (points, np.where(tets == 5, n, tets), fields)),
            (ptet.InputError, "-1", (points, np.where(tets == 5, -1, tets), fields)),
            (ptet.InputError, str(2**32), (points, np.where(tets == 5, 2**32, tets), fields)),
            (ptet.InputError, "finite", (np.where(points == 1, np.nan, points), tets, fields)),
            (ptet.InputError, "finite", (np.where(points == 1, np.inf, points), tets, fields)),
            (ptet.InputError, "finite", (points, tets, {"t": np.where(fields["t"] > 1, np.nan, fields["t"])})),
            (ptet.InputError, "", (points, tets[:0], fields)),
            (ptet.InputError, "", (points[:0], tets[:0], {})),
        ]:
            with self.subTest(says=says, error=error.__name__), self.assertRaisesRegex(error, says):
                ptet.build(*arguments, **FAST)

    def test_options_that_are_refused(self):
        for options in [
            {"method": "best"}, {"predict": "x"}, {"evaluate": "x"}, {"objective": "x"}, {"govern": "nothing"},
            {"govern": [3]}, {"max_domain_error": "two"}, {"max_domain_error": -1}, {"max_domain_error": float("nan")},
            {"govern": 5}, {"method": []},
            {"target_vertices": "x"}, {"target_vertices": -3}, {"target_vertices": "200%"}, {"target_vertices": 1.5},
            {"max_star": 3}, {"max_star": 1.5}, {"threads": -1}, {"threads": "all"}, {"round_fraction": 0},
            {"min_quality": float("nan")}, {"max_field_error": {"nothing": 1}}, {"max_field_error": {"t": -1}},
            {"predict": "exact", "evaluate": "none"}, {"progress": 3}, {"out": 3}, {"out": "\ud800"},
        ]:
            with self.subTest(options), self.assertRaises(ptet.ArgumentError):
                ptet.build(*cube(3), **options)

    def test_what_is_no_ptet_file_is_not_replaced(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "mesh.vtu"
            path.write_bytes(b"somebody's work")
            with self.assertRaisesRegex(ptet.ArgumentError, "not a .ptet file"):
                ptet.build(*cube(2), out=path, **FAST)
            self.assertEqual(path.read_bytes(), b"somebody's work")
            path.unlink()
            for _ in range(2):
                ptet.build(*cube(2), out=path, **FAST)
            named = pathlib.Path(folder) / "half.ptet"
            named.write_bytes(b"what is left of one")
            ptet.build(*cube(2), out=named, **FAST)
            self.assertEqual(named.read_bytes(), path.read_bytes())

    def test_numbers_of_numpy_are_numbers(self):
        points, tets, fields = cube(4)
        wanted = bytes(ptet.build(points, tets, fields, target_vertices=0.25, threads=1, **FAST).data)
        for number in (np.float32(0.25), np.float64(0.25)):
            made = ptet.build(points, tets, fields, target_vertices=number, threads=np.int64(1), **FAST)
            self.assertEqual(bytes(made.data), wanted)

    def test_what_is_wrong_is_named(self):
        points, tets, fields = cube(2)
        for name, value in (("min_quality", "good"), ("round_fraction", "much"), ("max_domain_error", 10**400)):
            with self.subTest(name), self.assertRaisesRegex(ptet.ArgumentError, name):
                ptet.build(points, tets, fields, **{name: value})
        for wrong in (fields["t"], [("t", fields["t"])]):
            with self.assertRaisesRegex(ptet.ArgumentError, "by their names"):
                ptet.build(points, tets, wrong)

    def test_names_of_files_are_not_cut_short(self):
        with tempfile.TemporaryDirectory() as folder:
            name = pathlib.Path(folder) / "a\0b"
            self.assertRaisesRegex(ptet.ArgumentError, "zero byte", ptet.build, *cube(2), out=name, **FAST)
            self.assertEqual(list(pathlib.Path(folder).iterdir()), [])
            self.assertRaisesRegex(ptet.ArgumentError, "zero byte", ptet.open, name)

    def test_text_that_no_file_can_hold(self):
        points, tets, fields = cube(3)
        for name in ("source_name", "source_hash", "govern", "predict", "evaluate", "objective"):
            for text in (3, "a\udc80"):
                given = [text] if name == "govern" else text
                with self.subTest(name=name, text=text), self.assertRaisesRegex(ptet.ArgumentError, f"^{name} "):
                    ptet.build(points, tets, fields, **{name: given})
        with self.assertRaisesRegex(ptet.ArgumentError, "^fields: the name .*UTF-8"):
            ptet.build(points, tets, {"a\udc80": fields["t"]}, **FAST)
        data = ptet.open(built())
        for request in ({"error": {"a\udc80": 1}}, {"values": ptet.Values("a\udc80", 1)}, {"values": ptet.Values(3, 1)}):
            with self.subTest(request), self.assertRaises(ptet.ArgumentError):
                data.extract(**request)

    def test_progress_is_told_and_may_cancel(self):
        told = []
        ptet.build(*cube(), progress=lambda stage, done, total: told.append((stage, done, total)))
        self.assertIn("collapsing", {stage for stage, _, _ in told})
        for stage, done, total in told:
            self.assertIsInstance(stage, str)
            self.assertTrue(total == 0 or 0 <= done <= total)
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(ptet.Cancelled):
                ptet.build(*cube(), out=folder + "/x.ptet", progress=lambda *told: False)
            self.assertEqual(list(pathlib.Path(folder).iterdir()), [])
        with self.assertRaises(ptet.Cancelled):
            ptet.build(*cube(2), progress=lambda *told: np.float64(1) < 0)  # numpy's False
        for answer in (None, 0, "", np.True_):
            ptet.build(*cube(2), progress=lambda *told, answer=answer: answer)

    def test_what_progress_raises_comes_through(self):
        class Own(BaseException):
            pass

        def progress(*_):
            raise Own("stop")
        with self.assertRaisesRegex(Own, "stop"):
            ptet.build(*cube(), progress=progress)
        with self.assertRaises(TypeError):
            ptet.build(*cube(), progress=lambda: None)

    def test_validate(self):
        points, tets, fields = cube(3)
        report = ptet.validate(points, tets, fields)
        self.assertEqual((report.vertices, report.tets, report.components), (64, 162, 1))
        self.assertEqual((report.boundary_faces, report.boundary_euler_characteristic), (108, 2))
        self.assertAlmostEqual(report.volume, 1)
        self.assertEqual(report.box_max, (1, 1, 1))
        twice = ptet.validate(points, np.concatenate([tets, tets[:3]]), fields)
        found = {finding.code: finding for finding in twice.findings}
        self.assertEqual([f.count for f in found.values() if f.severity == "error"][0], 3)


if __name__ == "__main__":
    unittest.main()
