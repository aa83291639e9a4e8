"""The same request through the program (C++), the C interface and Python gives identical cells."""
import math
import os
import pathlib
import subprocess
import tempfile
import unittest

from support import cube, meshes

import numpy as np
import ptet

ANGLE = math.pi / 180 * 30
TURN = 0.6, 0.8

# Name: what the program is asked, what the C program is asked, what Python is asked.
REQUESTS = {
    "original": ("", "", {}),
    "error": ("--field-error 3%", "field - 0.03", {"error": "3%"}),
    "errors by field": ("--field-error t=2%,flow=7% --domain-error 1%", "field t 0.02 field flow 0.07 domain 0.01",
                        {"error": {"t": "2%", "flow": "7%"}, "domain_error": "1%"}),
    "tets": ("--tets 500", "tets 500", {"budget": 500}),
    "vertices": ("--vertices 20%", "vertices 145", {"budget": ptet.Budget(vertices="20%")}),
    "box and budget": ("--focus box:0,0,0,0.4,0.3,0.5 --tets 900", "box 0 0 0 0.4 0.3 0.5 tets 900",
                       {"focus": ptet.Box((0, 0, 0), (0.4, 0.3, 0.5)), "budget": ptet.Budget(tets=900)}),
    "sphere with falloff": ("--focus sphere:0.5,0.5,1,0.25 --focus-error 1% --focus-falloff 10%",
                            "sphere 0.5 0.5 1 0.25 region-error 0 0.01 region-falloff 0 0.1",
                            {"focus": ptet.Sphere((0.5, 0.5, 1), 0.25, error="1%", falloff="10%")}),
    "two regions": ("--focus half:1,0,0.5,0.2 --focus sphere:1,1,1,0.2 --focus-error 0 --focus-error 2% "
                    "--field-error 20%",
                    "half 1 0 0.5 0.2 sphere 1 1 1 0.2 region-error 0 0 region-error 1 0.02 field - 0.2",
                    {"focus": [ptet.HalfSpace((1, 0, 0.5), 0.2), ptet.Sphere((1, 1, 1), 0.2, error="2%")],
                     "error": "20%"}),
    "oriented box": ("--focus obox:0.5,0.5,0.5,0.3,0.4,0,-0.08,0.06,0,0.25",
                     "obox 0.5 0.5 0.5 0.3 0.4 0 -0.08 0.06 0 0 0 0.25",
                     {"focus": ptet.OrientedBox((0.5, 0.5, 0.5), np.array([(0.3, 0.4, 0), (-0.08, 0.06, 0),
                                                                           (0, 0, 0.25)]))}),
    "values": ("--values t=1..1.2 --field-error 2%", "values t 1 1.2 field - 0.02",
               {"values": ptet.Values("t", 1, 1.2), "error": "2%"}),
    "isovalue": ("--isovalue t=0.75", "values t 0.75 0.75", {"values": [ptet.Values("t", 0.75)]}),
    "view": ("--view eye=4,-3,2:at=0.5,0.5,0.5 --pixels 2 --outside 4 --field-error 5%",
             f"view 4 -3 2 -3.5 3.5 -1.5 0 0 1 {ANGLE!r} 2 4 field - 0.05",
             {"view": ptet.View((4, -3, 2), (-3.5, 3.5, -1.5), (0, 0, 1), ANGLE, max_pixels=2, outside=4),
              "error": "5%"}),
}


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", check=False)
    if done.returncode != 0:
        raise AssertionError(f"{command}: {done.stdout}")
    return done.stdout


class SameCells(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.path = pathlib.Path(cls.folder.name) / "cube.ptet"
        ptet.build(*cube(), out=cls.path)
        cls.data = ptet.open(cls.path)

    def test_c_and_python(self):
        program = os.environ["PTET_CUT"]
        out = pathlib.Path(self.folder.name) / "cut.raw"
        sizes = set()
        for name, (_, request, asked) in REQUESTS.items():
            with self.subTest(name):
                run(program, self.path, out, *request.split())
                raw = out.read_bytes()
                cut = self.data.extract(**asked)
                wanted = np.array([len(cut.points), len(cut.tets)], np.uint64).tobytes()
                wanted += cut.points.tobytes() + cut.tets.tobytes() + cut.vertex_ids.tobytes()
                self.assertEqual(raw, wanted)
                sizes.add(len(raw))
        self.assertGreater(len(sizes), len(REQUESTS) - 3)  # they ask for different things

    def test_program_and_python(self):
        program = os.environ.get("PTET_CLI")
        if not program:
            self.skipTest("the program is not built")
        try:
            import vtkmodules.vtkIOXML  # noqa: F401
        except ImportError:
            self.skipTest("VTK's Python modules are not here")
        out = pathlib.Path(self.folder.name) / "cut.vtu"
        for name, (request, _, asked) in REQUESTS.items():
            with self.subTest(name):
                run(program, "extract", self.path, "-o", out, *request.split())
                points, arrays, tets = meshes.read_vtu(out)
                cut = self.data.extract(**asked)
                np.testing.assert_array_equal(tets, cut.tets)
                np.testing.assert_array_equal(points, cut.points)
                for field, values in cut.fields.items():
                    np.testing.assert_array_equal(arrays[field], values)

    def test_builds_are_the_same_bytes(self):
        program = os.environ.get("PTET_CLI")
        if not program:
            self.skipTest("the program is not built")
        points, tets = meshes.grid(6)
        fields = meshes.wave(points)
        source = meshes.vtu(pathlib.Path(self.folder.name) / "grid.vtu", points, tets, fields)
        out = pathlib.Path(self.folder.name) / "grid.ptet"
        arrays = {name: np.array(values, {"Float32": "f4", "Float64": "f8"}[kind])
                  for name, (kind, values) in fields.items()}
        for given, asked in [
            ("", {}), ("--method LN", {"method": "LN"}), ("--method GN", {"method": "GN"}),
            ("--method QN --evaluate vertices", {"method": "QN", "evaluate": "vertices"}),
            ("--method BF --objective rms", {"method": "BF", "objective": "rms"}),
            ("--method BFS", {"method": "BFS"}), ("--method staadt-gross", {"method": "staadt-gross"}),
            ("--method trotts", {"method": "trotts"}), ("--evaluate samples", {"evaluate": "samples"}),
            ("--predict gradient --field bumpy --target-vertices 10%",
             {"predict": "gradient", "govern": ["bumpy"], "target_vertices": "10%"}),
            ("--max-field-error bumpy=5% --max-domain-error 0.1 --max-star 32 --min-quality 0.05 --target-vertices 90",
             {"max_field_error": {"bumpy": "5%"}, "max_domain_error": 0.1, "max_star": 32, "min_quality": 0.05,
              "target_vertices": 90}),
        ]:
            with self.subTest(given):
                run(program, "build", source, "-o", out, *given.split())
                told = ptet.open(out).info.provenance
                made = ptet.build(np.array(points), tets, arrays, source_name=told["source_name"],
                                  source_hash=told["source_hash"], **asked)
                if told["notes"] or made.open().info.provenance["notes"]:
                    self.assertEqual(told, made.open().info.provenance)
                self.assertEqual(bytes(made.data), out.read_bytes())


if __name__ == "__main__":
    unittest.main()
