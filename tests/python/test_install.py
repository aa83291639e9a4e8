"""`pip install tools/python` without a network, into an environment of its own; then the examples with what is there.

PTET_BUILD_DIR names the folder that ptet is built in. Ends with 77 where there is no pip.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parents[2] / "tools" / "python"


def run(*command, code=0, **options):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8",
                          env=environment | {"PYTHONDONTWRITEBYTECODE": "1"}, check=False, **options)
    if done.returncode != code:
        raise AssertionError(f"{command}: {done.returncode}\n{done.stdout}")
    return done.stdout


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.python = cls.folder / "venv" / "bin" / "python"
        run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", cls.folder / "venv")
        run(sys.executable, "-m", "pip", "--python", cls.python, "--disable-pip-version-check", "install", "--no-index",
            HERE)

    def test_it_is_installed_and_works(self):
        script = ("import ptet, importlib.metadata as m; from pathlib import Path\n"
                  "assert m.version('ptet') == ptet.__version__, m.version('ptet')\n"
                  f"assert Path(ptet.__file__).is_relative_to({str(self.folder)!r}), ptet.__file__\n"
                  "assert (Path(ptet.__file__).parent / 'py.typed').exists()\n"
                  "points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]\n"
                  "b = ptet.build(points, [[0, 1, 2, 3]], {'t': [0, 1, 2, 3.0]})\n"
                  "print(len(b.open().extract().tets))\n")
        self.assertEqual(run(self.python, "-c", script, cwd=self.folder), "1\n")
        there = {path.name for path in (HERE / "ptet").iterdir() if path.is_file()}
        installed = next((self.folder / "venv").glob("lib/python*/site-packages/ptet"))
        self.assertEqual({path.name for path in installed.iterdir() if path.is_file() and path.suffix != ".so"}, there)

    def test_a_relative_build_folder_is_one_of_the_clone(self):
        # pip runs the backend in tools/python, wherever it was started itself.
        script = "import sys; sys.path.insert(0, 'backend'); import cmake_backend; print(cmake_backend._build_folder())"
        top = HERE.parents[1]
        for given, wanted in (("build", top / "build"), (str(self.folder), self.folder.resolve()),
                              ("", top / "build-python")):
            told = subprocess.run([sys.executable, "-B", "-c", script], stdout=subprocess.PIPE, encoding="utf-8",
                                  env={**os.environ, "PTET_BUILD_DIR": given}, cwd=HERE, check=True).stdout
            self.assertEqual(told, f"{wanted}\n")

    def test_it_can_be_removed(self):
        listed = run(sys.executable, "-m", "pip", "--python", self.python, "show", "--files", "ptet")
        self.assertIn("ptet/py.typed", listed)
        self.assertIn("License: BSD-3-Clause", listed)

    def test_examples(self):
        made = self.folder / "small.ptet"
        run(self.python, "-c", "import sys; sys.path.insert(0, sys.argv[1]); import ptet, example_mesh as e\n"
            "ptet.build(*e.jet(8), out=sys.argv[2])", HERE / "examples", made)
        for name, needs in (("error_against_size", "matplotlib"), ("focus_picture", "vtkmodules")):
            with self.subTest(name):
                if subprocess.run([self.python, "-c", f"import {needs}"], stderr=subprocess.DEVNULL,
                                  check=False).returncode:
                    self.skipTest(f"{needs} is not here")
                if needs == "vtkmodules" and not (os.environ.get("DISPLAY") or shutil.which("xvfb-run")):
                    self.skipTest("there is no display, not even a virtual one")
                out = self.folder / f"{name}.png"
                told = run(self.python, HERE / "examples" / f"{name}.py", made, "-o", out)
                self.assertIn(f"wrote {out}", told)
                self.assertEqual(out.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
                self.assertGreater(out.stat().st_size, 20_000)


if __name__ == "__main__":
    if subprocess.run([sys.executable, "-m", "pip", "--version"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                      check=False).returncode:
        print("pip is not here (Debian: python3-pip)")
        sys.exit(77)
    unittest.main()
