"""Builds over pieces by the processes of mpirun. Usage: test_ranks.py PTET MPIRUN [unittest options]

The file is the same, byte for byte, as one process makes; what goes wrong is said once."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True  # leaves the source tree as it is
import meshes  # noqa: E402

PTET = None
MPIRUN = None


class Ranks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ptet-ranks-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        points, tets = meshes.grid(9)
        meshes.vtu(self.folder / "grid.vtu", points, tets, meshes.wave(points))

    def run_in_folder(self, command, code):
        environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        done = subprocess.run(list(map(str, command)), cwd=self.folder, env=environment, encoding="utf-8", timeout=300,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
        self.assertEqual(done.returncode, code, f"{command}\n{done.stdout}\n{done.stderr}")
        return done

    def mpirun(self, ranks, *arguments, code=0):
        return self.run_in_folder([MPIRUN, "--quiet", "--oversubscribe", "-n", ranks, PTET, *arguments], code)

    def files(self):
        return sorted(path.name for path in self.folder.iterdir())

    def test_same_bytes_with_any_number_of_ranks(self):
        for method in ["exact", "QN"]:
            options = ["build", "grid.vtu", "--pieces", "5", "--method", method]
            self.run_in_folder([PTET, *options, "-o", "serial.ptet", "--quiet"], 0)
            expected = (self.folder / "serial.ptet").read_bytes()
            for ranks in [1, 2, 3]:
                with self.subTest(method=method, ranks=ranks):
                    done = self.mpirun(ranks, *options, "-o", "ranks.ptet", "--threads", "1")
                    self.assertEqual((self.folder / "ranks.ptet").read_bytes(), expected)
                    self.assertEqual(done.stdout.count("built ranks.ptet"), 1, done.stdout)
                    self.assertNotIn("ptet:", done.stderr)
                    self.assertEqual(self.files(), ["grid.vtu", "ranks.ptet", "serial.ptet"])
                    (self.folder / "ranks.ptet").unlink()

    def test_more_ranks_than_pieces(self):
        self.run_in_folder([PTET, "build", "grid.vtu", "--pieces", "2", "--method", "QN", "--quiet"], 0)
        self.mpirun(4, "build", "grid.vtu", "--pieces", "2", "--method", "QN", "-o", "ranks.ptet")
        self.assertEqual((self.folder / "ranks.ptet").read_bytes(), (self.folder / "grid.ptet").read_bytes())

    def test_errors_are_said_once(self):
        cases = [(["nothing.vtu", "--pieces", "4"], 6, "nothing.vtu"),
                 (["grid.vtu", "--pieces", "none"], 2, "--pieces 'none'"),
                 (["grid.vtu"], 2, "--pieces"),
                 (["grid.vtu", "--pieces", "4", "--field", "none"], 2, "none"),
                 (["grid.vtu", "--pieces", "4", "-o", "no/such/folder.ptet"], 6, "no/such")]
        for arguments, code, says in cases:
            with self.subTest(arguments):
                done = self.mpirun(3, "build", *arguments, code=code)
                self.assertEqual(done.stdout, "")
                errors = [line for line in done.stderr.splitlines() if line.startswith("ptet: ")]
                self.assertEqual(len(errors), 1, done.stderr)
                self.assertIn(says, errors[0])
                self.assertEqual(self.files(), ["grid.vtu"])

    def test_what_needs_no_others_is_done_in_each_process(self):
        self.run_in_folder([PTET, "build", "grid.vtu", "--method", "QN", "--quiet"], 0)
        script = f"'{PTET}' extract grid.ptet --vertices 20% -o part_$OMPI_COMM_WORLD_RANK.vtu"
        done = self.run_in_folder([MPIRUN, "--quiet", "--oversubscribe", "-n", 3, "sh", "-c", script], 0)
        self.assertEqual(done.stdout.count("limited   by"), 3, done.stdout)
        self.assertEqual(self.files(), ["grid.ptet", "grid.vtu", "part_0.vtu", "part_1.vtu", "part_2.vtu"])

    def test_an_error_of_one_rank_ends_all(self):
        (self.folder / "bad.vtu").write_text("<VTKFile>")
        build = [PTET, "build", "--pieces", "4", "-o", "out.ptet"]
        done = self.run_in_folder([MPIRUN, "--quiet", "--oversubscribe", "-n", 1, *build, "grid.vtu", ":",
                                   "-n", 1, *build, "bad.vtu"], 3)
        self.assertEqual(done.stdout, "")
        self.assertEqual(done.stderr.count("ptet: error: "), 1, done.stderr)
        self.assertIn("in process 2 of 2", done.stderr)
        self.assertEqual(self.files(), ["bad.vtu", "grid.vtu"])

    def test_ranks_that_read_different_meshes_are_found_out(self):
        points, tets = meshes.grid(8)
        meshes.vtu(self.folder / "other.vtu", points, tets, meshes.wave(points))
        build = [PTET, "build", "--pieces", "4", "-o", "out.ptet"]
        done = self.run_in_folder([MPIRUN, "--quiet", "--oversubscribe", "-n", 1, *build, "grid.vtu", ":",
                                   "-n", 1, *build, "other.vtu"], 2)
        self.assertEqual(done.stderr.count("ptet: error: "), 1, done.stderr)
        self.assertIn("not of this build", done.stderr)
        self.assertEqual(self.files(), ["grid.vtu", "other.vtu"])


if __name__ == "__main__":
    PTET, MPIRUN = sys.argv[1:3]
    del sys.argv[1:3]
    unittest.main()
