"""What is left when the program is killed, or the disk is full or breaks: the file that was there, the new one, or
none, never a part. Usage: test_loss.py PTET FAILING_CALLS [unittest options]

FAILING_CALLS is the library of failing_calls.c. PTET_TEST_KILLS: how often the program is killed at a random moment of
a build, and of an overwrite (default: 20 each)."""
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True  # leaves the source tree as it is
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import meshes  # noqa: E402

PTET = None
FAILING_CALLS = None
KILLS = int(os.environ.get("PTET_TEST_KILLS", "20"))
TEMPORARY = re.compile(r"\.part\d+x\d+$")
INPUT_OUTPUT = 6  # exit code


class Loss(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ptet-loss-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        points, tets = meshes.grid(5)
        meshes.vtu(self.folder / "grid.vtu", points, tets, meshes.wave(points))

    def run_ptet(self, *arguments, **environment):
        return subprocess.run([PTET, *map(str, arguments)], cwd=self.folder, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, encoding="utf-8", timeout=600, check=False,
                              env={**os.environ, **environment})

    def result_of(self, arguments, output):
        """The bytes of the output when nothing goes wrong; the output is removed."""
        done = self.run_ptet(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        whole = (self.folder / output).read_bytes()
        (self.folder / output).unlink()
        return whole

    def temporaries(self):
        return [path for path in self.folder.iterdir() if TEMPORARY.search(path.name)]

    def check_names(self, *expected):
        """Besides temporary files there are these only."""
        names = {path.name for path in self.folder.iterdir() if not TEMPORARY.search(path.name)}
        self.assertLessEqual(names, set(expected) | {"grid.vtu"})

    def check_left(self, output, old, new):
        """Nothing, the old or the new."""
        path = self.folder / output
        if not path.exists():
            self.assertIsNone(old, "the old file is gone")
            return "none"
        found = path.read_bytes()
        self.assertIn(found, [old, new], f"{len(found)} bytes are neither the old nor the new file")
        return "new" if found == new else "old"

    def clear(self, output, old):
        for path in self.temporaries():
            path.unlink()
        (self.folder / output).unlink(missing_ok=True)
        if old is not None:
            (self.folder / output).write_bytes(old)


class Killed(Loss):
    BUILD = ("build", "grid.vtu", "-o", "out.ptet", "--quiet", "--threads", "2")

    def kill_at_random(self, old):
        arguments = [*self.BUILD, "--force"]
        new = self.result_of(arguments, "out.ptet")
        started = time.monotonic()
        self.result_of(arguments, "out.ptet")
        duration = time.monotonic() - started
        chance = random.Random(7)
        seen = {"none": 0, "old": 0, "new": 0}
        for number in range(KILLS):
            self.clear("out.ptet", old)
            # The file is written at the end: half of the kills come about then.
            moment = duration * (chance.uniform(0, 1) if number % 2 == 0 else chance.uniform(0.8, 1.2))
            with subprocess.Popen([PTET, *arguments], cwd=self.folder, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL) as process:
                try:
                    process.wait(moment)
                except subprocess.TimeoutExpired:
                    process.send_signal(signal.SIGKILL)
            self.check_names("out.ptet")
            seen[self.check_left("out.ptet", old, new)] += 1
        print(f"{KILLS} kills at random: {seen}", file=sys.stderr)
        # What is left does not stand in the way.
        self.assertEqual(self.result_of(arguments, "out.ptet"), new)

    def test_build(self):
        self.kill_at_random(None)

    def test_overwrite(self):
        self.kill_at_random(self.result_of([*self.BUILD, "--target-vertices", "50%"], "out.ptet"))

    def test_at_every_call(self):
        """Killed within each call that writes, half of the bytes written."""
        old = self.result_of([*self.BUILD, "--target-vertices", "50%"], "out.ptet")
        arguments = [*self.BUILD, "--force"]
        new = self.result_of(arguments, "out.ptet")
        for before in (None, old):
            call = 0
            while True:
                call += 1
                self.clear("out.ptet", before)
                done = self.run_ptet(*arguments, LD_PRELOAD=FAILING_CALLS, PTET_FAIL_PATH="out.ptet",
                                     PTET_FAIL_HOW="KILL", PTET_FAIL_CALL=str(call), PTET_FAIL_CHUNK="2000")
                left = self.check_left("out.ptet", before, new)
                self.check_names("out.ptet")
                if done.returncode == 0:
                    break
                self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
                self.assertEqual(left, "none" if before is None else "old")
                # A part is no file that anybody reads.
                for path in self.temporaries():
                    if path.read_bytes() != new:
                        self.assertNotEqual(self.run_ptet("info", path.name).returncode, 0)
            self.assertGreater(call, 5)


class Refused(Loss):
    def fail_each_call(self, arguments, output, chunk, most_calls=1000):
        """Every call that writes fails once, with no space and with an error of the device."""
        new = self.result_of(arguments, output)
        log = self.folder / "calls.log"
        self.run_ptet(*arguments, LD_PRELOAD=FAILING_CALLS, PTET_FAIL_PATH=output, PTET_FAIL_CHUNK=str(chunk),
                      PTET_FAIL_LOG=str(log))
        self.assertEqual((self.folder / output).read_bytes(), new, "short writes make another file")
        calls = log.read_text().split()
        log.unlink()
        self.assertGreaterEqual({*calls}, {"open", "write", "fsync", "rename"})
        step = max(1, len(calls) // most_calls)
        # The last calls are of different kinds: each of them.
        chosen = sorted({*range(1, len(calls) + 1, step), *range(max(1, len(calls) - 5), len(calls) + 1)})
        for before in (None, b"what was there"):
            for how, says in (("ENOSPC", "No space left on device"), ("EIO", "Input/output error")):
                for call in chosen:
                    self.clear(output, before)
                    done = self.run_ptet(*arguments, LD_PRELOAD=FAILING_CALLS, PTET_FAIL_PATH=output,
                                         PTET_FAIL_HOW=how, PTET_FAIL_CALL=str(call), PTET_FAIL_CHUNK=str(chunk))
                    where = f"{output}: {calls[call - 1]}, call {call} of {len(calls)}, {how}: {done.stderr}"
                    self.assertEqual(done.returncode, INPUT_OUTPUT, where)
                    self.assertTrue(done.stderr.startswith("ptet: error: "), where)
                    self.assertIn(says, done.stderr, where)
                    self.assertIn(output, done.stderr, where)
                    self.assertEqual(self.temporaries(), [], where)
                    self.assertEqual(self.check_left(output, before, None), "none" if before is None else "old", where)
        print(f"{output}: {len(calls)} calls, {4 * len(chosen)} failures", file=sys.stderr)
        self.clear(output, None)

    def test_build(self):
        self.fail_each_call(("build", "grid.vtu", "-o", "out.ptet", "--quiet", "--force"), "out.ptet", 2000)

    def test_extract(self):
        built = self.run_ptet("build", "grid.vtu", "-o", "grid.ptet", "--quiet")
        self.assertEqual(built.returncode, 0, built.stderr)
        for ending in ("vtu", "vtk", "obj", "ply", "stl", "off"):
            with self.subTest(ending=ending):
                output = "out." + ending
                self.fail_each_call(("extract", "grid.ptet", "-o", output), output, 8000, 4)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    PTET = str(pathlib.Path(sys.argv[1]).resolve())
    FAILING_CALLS = str(pathlib.Path(sys.argv[2]).resolve())
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
