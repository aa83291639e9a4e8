"""What tests of the program have in common: a folder for each, and what its answers look like."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True  # leaves the source tree as it is
import meshes  # noqa: E402

_program = None


def program():
    """Path of the program that is tested."""
    return _program


def main():
    """Runs the tests of the script: SCRIPT PTET [unittest options]."""
    global _program
    if len(sys.argv) < 2 or shutil.which(sys.argv[1]) is None:
        sys.exit(f"usage: {pathlib.Path(sys.argv[0]).name} PTET [unittest options]")
    _program = str(pathlib.Path(shutil.which(sys.argv.pop(1))).resolve())
    unittest.main()


class Case(unittest.TestCase):
    """A test with a folder of its own, in which the program runs."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ptet-cli-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def ptet(self, *arguments, code=0, **options):
        options.setdefault("stdout", subprocess.PIPE)
        done = subprocess.run([program(), *map(str, arguments)], cwd=self.folder, stderr=subprocess.PIPE,
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
