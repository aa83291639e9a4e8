"""ptet view as a user types it: pictures without a display, and errors that say what is wrong.

    test_view_cli.py PTET EXAMPLE.ptet [unittest options]
"""
import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest

PTET, EXAMPLE = os.path.abspath(sys.argv.pop(1)), os.path.abspath(sys.argv.pop(1))


def run(*arguments, **environment):
    clean = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    return subprocess.run([PTET, "view", *arguments], env={**clean, **environment}, capture_output=True, text=True,
                          timeout=120, check=False)


class View(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.picture = os.path.join(self.folder.name, "p.png")

    def refused(self, code, *arguments, says, **environment):
        result = run(*arguments, **environment)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertTrue(result.stderr.startswith("ptet: error: "), result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertIn(says, result.stderr)
        self.assertFalse(os.path.exists(self.picture))
        return result

    def test_picture_without_a_display(self):
        result = run(EXAMPLE, "--show", "cells", "--plane", "+y", "--size", "320x240", "--error", "0",
                     "--screenshot", self.picture)
        self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "", ""))
        with open(self.picture, "rb") as file:
            head = file.read(24)
        self.assertEqual(head[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">II", head[16:24]), (320, 240))

    def test_an_isosurface_of_nothing_is_said(self):
        fields = json.loads(subprocess.run([PTET, "info", EXAMPLE, "--json"], capture_output=True, check=True).stdout)
        result = run(EXAMPLE, "--show", "iso", "--isovalue", fields["fields"][0]["name"] + "=1e30", "--size", "64x64",
                     "--screenshot", self.picture)
        self.assertEqual((result.returncode, result.stdout), (0, ""))
        self.assertIn("there is no isosurface", result.stderr)

    def test_a_plane_beside_the_mesh_is_said(self):
        for show, says in (("slice", "there is no slice"), ("cells", "no cell has its centre behind")):
            result = run(EXAMPLE, "--show", show, "--plane", "y:-1e30" if show == "slice" else "+y:-1e30", "--size",
                         "64x64", "--screenshot", self.picture)
            self.assertEqual((result.returncode, result.stdout), (0, ""))
            self.assertIn(says, result.stderr)

    def test_no_display(self):
        self.refused(6, EXAMPLE, says="no display")
        self.refused(6, EXAMPLE, "--screenshot", self.picture, says="install xvfb", PATH="/nonexistent")

    def test_usage(self):
        shot = ("--screenshot", self.picture)
        self.refused(2, EXAMPLE, *shot, "--colour", "nothing", says="there is no field 'nothing'; there are: ")
        self.refused(2, EXAMPLE, *shot, "--isovalue", "nothing=1", says="there is no field 'nothing'")
        self.refused(2, EXAMPLE, *shot, "--show", "all", says="surface, cells, slice, iso or volume")
        self.refused(2, EXAMPLE, *shot, "--show", "iso", says="--isovalue")
        self.refused(2, EXAMPLE, *shot, "--error", "3", says="a percentage")
        self.refused(2, EXAMPLE, *shot, "--plane", "w:1", says="--plane 'w:1'")
        self.refused(2, EXAMPLE, *shot, "--camera", "eye=9,9,9:at=0,0,0:size=80x60", says="--size")
        for plane in ("x:", "y:1.7m", "z:inf", "1,0,0", "1,0,0,", "0,0,0,1"):
            result = self.refused(2, EXAMPLE, *shot, "--plane", plane, says=f"--plane '{plane}': ")
            self.assertNotIn("half:", result.stderr)
        self.refused(2, EXAMPLE, *shot, "--range", "3..1", says="MIN must be less")
        self.refused(2, EXAMPLE, *shot, "--size", "10x10", says="--size")
        self.refused(2, EXAMPLE, *shot, "--focus", "sphere:1,2", says="--focus")
        self.refused(2, EXAMPLE, "--screenshot", "p.jpg", says=".png")
        self.refused(2, EXAMPLE, "--nonsense", says="--nonsense")
        self.refused(2, says="FILE")

    def test_files(self):
        self.refused(6, "/nonexistent.ptet", "--screenshot", self.picture, says="/nonexistent.ptet")
        self.refused(6, EXAMPLE, "--screenshot", "/nonexistent/p.png", says="/nonexistent")
        damaged = os.path.join(self.folder.name, "damaged.ptet")
        with open(EXAMPLE, "rb") as file:
            content = bytearray(file.read())
        content[60] ^= 255
        with open(damaged, "wb") as file:
            file.write(content)
        self.refused(4, damaged, "--screenshot", self.picture, says="damaged.ptet")

    def test_help_has_the_keys(self):
        text = run("--help").stdout
        for line in ("  3      slice\n", "  o      focus in a sphere\n", "--screenshot OUT.png"):
            self.assertIn(line, text)


if __name__ == "__main__":
    unittest.main()
