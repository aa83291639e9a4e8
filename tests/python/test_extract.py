"""Extractions: the mesh, its errors, its memory."""
import gc
import math
import pathlib
import threading
import unittest
import warnings

from support import built, check_mesh, cube, largest_error, resident_bytes, rows_as_set

import numpy as np
import ptet


class Bytes:
    """Bytes that are read a part at a time."""

    def __init__(self, data):
        self.data, self.size = data, len(data)

    def read(self, offset, size):
        return self.data[offset:offset + size]


class Extract(unittest.TestCase):
    def setUp(self):
        self.data = ptet.open(built())
        self.points, self.tets, self.fields = cube()

    def test_equal_wishes_are_equal(self):
        centre = np.array([1, 2, 3], np.float32)
        for one, same, other in (
                (ptet.Sphere(centre, 1), ptet.Sphere((1, 2, 3), 1), ptet.Sphere((1, 2, 4), 1)),
                (ptet.Box([0, 0, 0], centre), ptet.Box(np.zeros(3), [1, 2, 3]), ptet.Box((0, 0, 0), (1, 2, 9))),
                (ptet.OrientedBox(centre, np.eye(3)), ptet.OrientedBox((1, 2, 3), np.eye(3).tolist()),
                 ptet.OrientedBox((1, 2, 3), 2 * np.eye(3))),
                (ptet.View(eye=centre), ptet.View(eye=[1, 2, 3]), ptet.View(eye=[3, 2, 1]))):
            with self.subTest(one):
                self.assertEqual(one, same)
                self.assertNotEqual(one, other)
                self.assertEqual(len({one, same, other}), 2)
        asked = ptet.Sphere(centre, 1)
        centre[0] = 9
        self.assertEqual(asked.centre, (1, 2, 3))

    def test_errors_hold_at_original_vertices(self):
        for request in ({"error": "5%"}, {"error": 0.1}, {"error": {"t": 0.02}}, {"budget": 300},
                        {"budget": ptet.Budget(vertices="10%")}):
            with self.subTest(request):
                cut = self.data.extract(**request)
                check_mesh(self, cut.points, cut.tets, cut.boundary_faces)
                self.assertLess(len(cut.tets), len(self.tets))
                for name in ("t", "flow"):
                    worst = largest_error(cut.points, cut.tets, cut.fields[name], self.points, self.fields[name])
                    self.assertGreater(worst, 0)
                    self.assertLessEqual(worst, cut.field_error[name] + 1e-6)
                    self.assertLessEqual(cut.rms_error[name], cut.field_error[name])
                self.assertTrue(0.5 < cut.covered <= 1)

    def test_what_is_asked_is_kept(self):
        info = self.data.info
        cut = self.data.extract(error={"t": "3%", "flow": 0.05}, domain_error="1%")
        self.assertLessEqual(cut.field_error["t"], 0.03 * info.field("t").range)
        self.assertLessEqual(cut.field_error["flow"], 0.05)
        self.assertLessEqual(cut.domain_error, 0.01 * info.diagonal)
        self.assertEqual(cut.limited_by, "error")
        for budget, count in ((400, lambda c: len(c.tets)), (ptet.Budget(vertices=90), lambda c: len(c.points)),
                              (ptet.Budget(tets="10%"), lambda c: 400 * len(c.tets) / 307)):
            cut = self.data.extract(budget=budget)
            self.assertEqual(cut.limited_by, "budget")
            self.assertLessEqual(count(cut), 400)
        cut = self.data.extract(budget=ptet.Budget(bytes=20_000))
        used = cut.tets.nbytes + cut.boundary_faces.nbytes + cut.points.nbytes + sum(
            values.nbytes for values in cut.fields.values())
        self.assertLessEqual(used, 20_000)
        self.assertGreater(used, 15_000)

    def test_focus_is_the_original_inside(self):
        turn = math.sqrt(0.5)
        inside = {
            ptet.Box((0, 0, 0), (0.4, 0.5, 0.3)): lambda p: ((p >= 0) & (p <= (0.4, 0.5, 0.3))).all(axis=1),
            ptet.Sphere((0.5, 0.5, 1), 0.3): lambda p: np.linalg.norm(p - (0.5, 0.5, 1), axis=1) <= 0.3,
            ptet.HalfSpace((1, 1, 0), 0.3): lambda p: p[:, 0] + p[:, 1] <= 0.3,
            ptet.OrientedBox((0.5, 0.5, 0.5), ((0.3 * turn, 0.3 * turn, 0), (-0.1 * turn, 0.1 * turn, 0), (0, 0, 0.2))):
                lambda p: (np.abs((p - 0.5) @ np.array([(turn, turn, 0), (-turn, turn, 0), (0, 0, 1)]).T)
                           <= (0.3, 0.1, 0.2)).all(axis=1),
        }
        rows = {point.tobytes(): i for i, point in enumerate(self.points)}
        for region, holds in inside.items():
            with self.subTest(region):
                cut = self.data.extract(focus=region)
                check_mesh(self, cut.points, cut.tets, cut.boundary_faces)
                touched = holds(self.points.astype(float))[self.tets].any(axis=1)
                self.assertGreater(touched.sum(), 20)
                self.assertLess(len(cut.tets), 0.9 * len(self.tets))
                order = np.array([rows[point.tobytes()] for point in cut.points])
                self.assertLessEqual(rows_as_set(self.tets[touched]), rows_as_set(order[cut.tets]))
                self.assertEqual(cut.in_focus[0].field_error, {"t": 0, "flow": 0})
                self.assertEqual(cut.limited_by, "focus")

    def test_focus_errors_and_falloffs(self):
        box = ((0, 0, 0), (0.4, 0.4, 0.4))
        alone = self.data.extract(focus=ptet.Box(*box))
        loose = self.data.extract(focus=ptet.Box(*box, error="5%"))
        wide = self.data.extract(focus=[ptet.Box(*box, falloff="5%")])
        both = self.data.extract(focus=(ptet.Box(*box), ptet.Sphere((1, 1, 1), 0.2, error=0.01)))
        self.assertLess(len(loose.tets), len(alone.tets))
        self.assertGreater(len(wide.tets), len(alone.tets))
        self.assertGreater(len(both.tets), len(alone.tets))
        self.assertEqual(len(both.in_focus), 2)
        self.assertLessEqual(both.in_focus[1].field_error["t"], 0.01)

    def test_values_and_views(self):
        everywhere = self.data.extract(error="4%")
        there = self.data.extract(error="4%", values=ptet.Values("t", 1.2, 1.3))
        self.assertLess(len(there.tets), len(everywhere.tets))
        self.assertLessEqual(there.at_values[0].field_error["t"], 0.04 * self.data.info.field("t").range)
        self.assertEqual(len(self.data.extract(error="4%", values=ptet.Values("t", 1.25)).at_values), 1)
        seen = self.data.extract(error="4%", view=ptet.View((3, 0.2, 0.2), (-1, 0, 0), (0, 0, 1), vertical_angle=0.1))
        self.assertLessEqual(seen.in_view.field_error["t"], 0.04 * self.data.info.field("t").range)
        self.assertLess(len(seen.tets), len(everywhere.tets))
        self.assertIsNone(everywhere.in_view)

    def test_what_is_not_there_is_warned_of(self):
        near, far = ptet.Sphere((0, 0, 0), 0.2), ptet.Sphere((9, 9, 9), 0.2)
        with self.assertWarnsRegex(ptet.UnmetWarning, r"no tet of the mesh meets focus 1: the mesh is in the box \(0\.0, "):
            self.data.extract(focus=[near, far])
        with self.assertWarnsRegex(ptet.UnmetWarning, "nothing of the mesh has the values asked for: t = 1000000"):
            self.data.extract(error="4%", values=ptet.Values("t", 1e6))
        with self.assertWarnsRegex(ptet.UnmetWarning, r"nothing of the mesh is in the view: the mesh is in the box \(0\.0, "):
            self.data.extract(view=ptet.View(eye=(9, 9, 9), direction=(1, 1, 1)))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.data.extract(focus=near, error="4%", values=ptet.Values("t", 1.25))
            self.data.extract(view=ptet.View(eye=(9, 9, 9), direction=(-1, -1, -1)))
            # What the coarsest mesh has not, a finer one may have.
            self.data.extract(values=ptet.Values("t", 1e6), budget=ptet.Budget(tets=0))
            self.data.extract(values=ptet.Values("t", 1e6), budget=ptet.Budget(milliseconds=0))

    def test_origins(self):
        cut = self.data.extract(error="3%", origins=True)
        self.assertEqual(cut.made_by.shape, (len(cut.tets),))
        rows = {point.tobytes(): i for i, point in enumerate(self.points)}
        order = np.array([rows[point.tobytes()] for point in cut.points])
        original = rows_as_set(self.tets)
        is_original = np.array([tuple(sorted(row)) in original for row in order[cut.tets].tolist()])
        np.testing.assert_array_equal(is_original, cut.made_by == 0xFFFFFFFF)
        self.assertIsNone(self.data.extract(error="3%").made_by)

    def test_what_is_no_number_of_a_record_is_refused(self):
        levels = self.data.origin_values(np.array([0, 1, 0xFFFFFFFF]), "level")  # of any type of whole numbers
        self.assertEqual(levels[2], 0)
        self.assertEqual(self.data.origin_values([], "level").shape, (0,))
        for wrong in ([2**32], [-1], [1.0], ["1"], [[0]], [10**6]):
            with self.subTest(wrong), self.assertRaises(ptet.ArgumentError):
                self.data.origin_values(wrong, "level")

    def test_vertex_ids_are_stable(self):
        at = {}
        for request in ({}, {"error": "2%"}, {"budget": 500}, {"focus": ptet.Sphere((0, 0, 0), 0.5)}):
            cut = self.data.extract(**request)
            self.assertEqual(len(set(cut.vertex_ids.tolist())), len(cut.points))
            for number, point in zip(cut.vertex_ids.tolist(), cut.points.tolist()):
                self.assertEqual(at.setdefault(number, point), point)

    def test_requests_that_are_refused(self):
        nan = float("nan")
        for request in [
            {"error": -1}, {"error": nan}, {"error": "x"}, {"error": "-1%"}, {"error": {"nothing": 1}},
            {"error": {"number": 1}}, {"error": {3: 1}}, {"error": []}, {"domain_error": math.inf},
            {"domain_error": None, "error": object()}, {"budget": -1}, {"budget": 1.5}, {"budget": "x"},
            {"budget": ptet.Budget(tets="101%")}, {"budget": ptet.Budget(bytes="5%")},
            {"budget": ptet.Budget(milliseconds=-1)}, {"budget": 2**64}, {"focus": (0, 0, 0)}, {"focus": 3},
            {"focus": ptet.Box((0, 0), (1, 1, 1))}, {"focus": ptet.Box((1, 1, 1), (0, 0, 0))},
            {"focus": ptet.Box((0, 0, 0), (1, 1, nan))}, {"focus": ptet.Sphere((0, 0, 0), -1)},
            {"focus": ptet.Sphere((0, 0, 0), "x")}, {"focus": ptet.Sphere((0, 0, 0), 1, error=-1)},
            {"focus": ptet.HalfSpace((0, 0, 0), 1)}, {"focus": ptet.OrientedBox((0, 0, 0), ((1, 0, 0), (0, 1, 0)))},
            {"focus": ptet.OrientedBox((0, 0, 0), ((1, 0, 0), (1, 1, 0), (0, 0, 1)))},
            {"values": ptet.Values("nothing", 1)}, {"values": ptet.Values("t", 2, 1)}, {"values": ["t"]},
            {"view": 3}, {"view": ptet.View((0, 0, 0), (0, 0, 0))}, {"view": ptet.View((0, 0, 0), width=-1)},
            {"view": ptet.View((0, 0, 0), width=2**40)}, {"view": [ptet.View((0, 0, 0))]}, {"error": 10**400},
            {"focus": ptet.Sphere((0, 0, 10**400), 1)}, {"focus": ptet.Sphere((0, 0, 0), 10**400)},
            {"budget": np.array([5, 6])}, {"budget": True}, {"focus": ptet.Box("012", "345")},
            {"view": ptet.View((0, 0, 0), width="5%")}, {"view": ptet.View((0, 0, 0), height=0)}, {"error": True},
            {"focus": ptet.OrientedBox((0, 0, 0), None)}, {"focus": ptet.OrientedBox((0, 0, 0), 3)}, {"progress": 5},
        ]:
            with self.subTest(request), self.assertRaises(ptet.ArgumentError):
                self.data.extract(**request)

    def test_what_is_refused_is_named(self):
        good, bad = ptet.Sphere((0, 0, 0), 1), ptet.Sphere((0, 0, 0), -1)
        with self.assertRaisesRegex(ptet.ArgumentError, r"^focus\[1\]: the radius of a focus sphere is -1; it must be finite"):
            self.data.extract(focus=[good, bad])
        with self.assertRaisesRegex(ptet.ArgumentError, "no field 'x' in this file; those with errors are '"):
            self.data.extract(error={"x": 1})
        self.data.extract(error=-0.0)

    def test_arrays_are_views_that_outlive_everything(self):
        cut = self.data.extract(error="5%")
        arrays = [cut.points, cut.tets, cut.boundary_faces, cut.vertex_ids, *cut.fields.values()]
        copies = [array.copy() for array in arrays]
        for array in arrays:
            self.assertFalse(array.flags.owndata)
            self.assertFalse(array.flags.writeable)
            with self.assertRaises(ValueError):
                array.flags.writeable = True
        again = self.data.extract(error="5%")
        self.assertNotEqual(again.points.ctypes.data, cut.points.ctypes.data)
        self.data = None
        del cut, again
        gc.collect()
        np.ones(10**6)  # somebody else's memory
        for array, copy in zip(arrays, copies):
            np.testing.assert_array_equal(array, copy)

    def test_threads_share_a_dataset(self):
        requests = [{"error": f"{percent}%"} for percent in (1, 2, 4, 8)] + [{"budget": 200}, {}]
        wanted = [self.data.extract(**request).tets for request in requests]
        data, wrong = ptet.open(built()), []

        def run(first):
            for i in range(40):
                which = (first + i) % len(requests)
                if not np.array_equal(data.extract(**requests[which]).tets, wanted[which]):
                    wrong.append(which)

        threads = [threading.Thread(target=run, args=(first,)) for first in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_exceptions_stay_in_their_thread(self):
        def raises(*_):
            raise ZeroDivisionError
        stop, caught = threading.Event(), []

        def run():
            while not stop.is_set():
                try:
                    self.data.extract(error="2%", progress=raises)
                except ZeroDivisionError as error:
                    caught.append(error)

        thread = threading.Thread(target=run)
        thread.start()
        try:
            for _ in range(200):
                self.data.extract(error="1%", progress=lambda *told: None)
        finally:
            stop.set()
            thread.join()
        self.assertGreater(len(caught), 0)

    def test_repeating_leaves_no_memory_behind(self):
        grid = cube(4)

        def once():
            data = ptet.build(*grid, method="QN", progress=lambda *told: None).open()
            data.extract(error="1%", origins=True)
            session = data.session()
            session.update(error="1%")
            session.extraction()
            reader = Bytes(built())
            for background in (False, True):
                ptet.open(reader, background=background).extract(error="1%")
            for bad in (b"", built()[:2000]):
                try:
                    ptet.open(bad)
                except ptet.Error:
                    pass
            try:
                data.extract(error="1%", progress=lambda *told: 1 // 0)
            except ZeroDivisionError:
                pass

        for _ in range(20):
            once()

        def growth():
            before = resident_bytes()
            for _ in range(100):
                once()
            return resident_bytes() - before

        # One extraction, session or file more a time would be 3 MB and more each time; what the heap takes when threads
        # come at other moments it takes once.
        self.assertTrue(any(growth() < 1_500_000 for _ in range(3)))


class Exchange(unittest.TestCase):
    def setUp(self):
        self.cut = ptet.open(built()).extract(error="5%", origins=True)

    def test_vtk(self):
        try:
            from vtkmodules.util.numpy_support import vtk_to_numpy
        except ImportError:
            self.skipTest("VTK's Python modules are not here")
        cut = self.cut
        points, tets, t = cut.points.copy(), cut.tets.copy(), cut.fields["t"].copy()
        grid, surface = cut.to_vtk(), cut.boundary_to_vtk()
        self.assertEqual(vtk_to_numpy(grid.GetPoints().GetData()).ctypes.data, cut.points.ctypes.data)
        faces = cut.boundary_faces.copy()
        del cut, self.cut
        gc.collect()
        np.ones(10**6)
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), points)
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPointData().GetArray("t")), t)
        self.assertEqual(grid.GetNumberOfCells(), len(tets))
        cell = grid.GetCell(7).GetPointIds()
        self.assertEqual([cell.GetId(i) for i in range(4)], tets[7].tolist())
        self.assertIsNotNone(grid.GetCellData().GetArray("made by"))
        self.assertGreater(grid.GetFieldData().GetArray("error of t").GetValue(0), 0)
        self.assertEqual(surface.GetNumberOfPolys(), len(faces))
        cell = surface.GetCell(3).GetPointIds()
        self.assertEqual([cell.GetId(i) for i in range(3)], faces[3].tolist())
        back, corners, fields = ptet.from_vtk(grid)
        np.testing.assert_array_equal(back, points)
        np.testing.assert_array_equal(corners, tets)
        np.testing.assert_array_equal(fields["t"], t)
        self.assertEqual(ptet.build(back, corners, {"t": fields["t"]}, method="QN").report.input_tets, len(tets))
        with self.assertRaisesRegex(ptet.InputError, "tetrahedra"):
            from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON, vtkUnstructuredGrid
            other = vtkUnstructuredGrid()
            other.SetPoints(grid.GetPoints())
            other.InsertNextCell(VTK_HEXAHEDRON, 8, list(range(8)))
            ptet.from_vtk(other)
        with self.subTest("cells of lower dimension are left out, and linear Lagrange tets taken"):
            from vtkmodules.vtkCommonDataModel import VTK_LAGRANGE_TETRAHEDRON, VTK_TETRA, VTK_TRIANGLE, VTK_VERTEX
            mixed = vtkUnstructuredGrid()
            mixed.SetPoints(grid.GetPoints())
            for kind, corners in ((VTK_TRIANGLE, [2, 1, 0]), (VTK_TETRA, [0, 1, 2, 3]), (VTK_VERTEX, [5]),
                                  (VTK_LAGRANGE_TETRAHEDRON, [3, 2, 1, 4])):
                mixed.InsertNextCell(kind, len(corners), corners)
            self.assertEqual(ptet.from_vtk(mixed)[1].tolist(), [[0, 1, 2, 3], [3, 2, 1, 4]])
            mixed.InsertNextCell(VTK_LAGRANGE_TETRAHEDRON, 10, list(range(10)))
            with self.assertRaisesRegex(ptet.InputError, "1 cells are no tetrahedra"):
                ptet.from_vtk(mixed)

    def test_what_is_no_grid_is_refused(self):
        try:
            from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
        except ImportError:
            self.skipTest("VTK's Python modules are not here")
        for wrong in None, vtkImageData(), vtkPolyData():
            self.assertRaisesRegex(ptet.ArgumentError, "vtkUnstructuredGrid is wanted", ptet.from_vtk, wrong)

    def test_ghost_cells_of_vtk_are_left_out(self):
        try:
            from vtkmodules.util.numpy_support import numpy_to_vtk
            from vtkmodules.vtkCommonCore import vtkBitArray, vtkStringArray
            from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON
        except ImportError:
            self.skipTest("VTK's Python modules are not here")
        grid = self.cut.to_vtk()
        count, points = grid.GetNumberOfCells(), grid.GetNumberOfPoints()

        def mark(flags, cells=True):
            array = numpy_to_vtk(np.array(flags, np.uint8), deep=True)
            array.SetName("vtkGhostType")
            (grid.GetCellData() if cells else grid.GetPointData()).AddArray(array)

        mark([0, 1, 2, 4, 8, 16, 32] + [0] * (count - 7))
        mark([1] + [0] * (points - 1), cells=False)
        with self.assertWarnsRegex(UserWarning, "^3 ghost cells are left out"):
            back, tets, fields = ptet.from_vtk(grid)
        self.assertEqual(len(back), points)
        np.testing.assert_array_equal(tets, np.delete(self.cut.tets, [1, 4, 6], axis=0))
        self.assertNotIn("vtkGhostType", fields)
        # A ghost of another kind is no reason to refuse the mesh.
        grid.InsertNextCell(VTK_HEXAHEDRON, 8, list(range(8)))
        mark([0] * count + [1])
        with self.assertWarnsRegex(UserWarning, "^1 ghost cell is left out"):
            np.testing.assert_array_equal(ptet.from_vtk(grid)[1], self.cut.tets)
        mark([1] * (count + 1))
        with self.assertWarns(UserWarning):
            self.assertEqual(ptet.from_vtk(grid)[1].shape, (0, 4))

        grid = self.cut.to_vtk()
        for kind, name in ((vtkBitArray, "bits"), (vtkStringArray, "words")):
            array = kind()
            array.SetName(name)
            array.SetNumberOfValues(points)
            grid.GetPointData().AddArray(array)
        with self.assertWarnsRegex(UserWarning, "'(bits|words)' is not numeric") as caught:
            fields = ptet.from_vtk(grid)[2]
        self.assertEqual(len(caught.warnings), 2)
        self.assertEqual({pathlib.Path(w.filename).name for w in caught.warnings}, {"test_extract.py"})
        self.assertTrue({"t", "flow"} <= set(fields) and not {"bits", "words"} & set(fields))

    def test_ghost_cells_of_meshio_are_left_out(self):
        class Block:  # as of meshio, which need not be here
            def __init__(self, kind, data):
                self.type, self.data = kind, data

        class Mesh:
            points = self.cut.points
            point_data = {"t": self.cut.fields["t"], "vtkGhostType": np.zeros(len(self.cut.points))}
            cells = [Block("tetra", self.cut.tets[:9]), Block("hexahedron", np.arange(8).reshape(1, 8)),
                     Block("tetra", self.cut.tets[9:])]
            cell_data = {"vtkGhostType": [np.array([0, 1] + [0] * 7), np.array([1]), np.full(len(self.cut.tets) - 9, 2)]}

        with self.assertWarnsRegex(UserWarning, "^2 ghost cells are left out"):
            _, tets, fields = ptet.from_meshio(Mesh())
        np.testing.assert_array_equal(tets, np.delete(self.cut.tets, 1, axis=0))
        self.assertEqual(list(fields), ["t"])

    def test_meshio(self):
        try:
            import meshio
        except ImportError:
            self.skipTest("meshio is not here")
        mesh = self.cut.to_meshio()
        np.testing.assert_array_equal(mesh.cells_dict["tetra"], self.cut.tets)
        np.testing.assert_array_equal(mesh.points, self.cut.points)
        np.testing.assert_array_equal(mesh.point_data["flow"], self.cut.fields["flow"])
        points, tets, fields = ptet.from_meshio(mesh)
        np.testing.assert_array_equal(tets, self.cut.tets)
        self.assertEqual(ptet.build(points, tets, {"t": fields["t"]}, method="QN").report.input_tets, len(tets))
        with self.assertRaises(ptet.InputError):
            ptet.from_meshio(meshio.Mesh(np.zeros((8, 3)), [("hexahedron", [list(range(8))])]))


if __name__ == "__main__":
    unittest.main()
