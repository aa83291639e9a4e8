"""Ctrl-C while the library works, in the main thread and beside it."""
import os
import signal
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import unittest

from support import built, cube

import ptet

SOON = 1.5  # seconds of processor time, of all threads: they say the same however busy the machine is


class Interrupt(unittest.TestCase):
    def interrupted(self, call, after=1.0):
        """Runs `call` and presses Ctrl-C: what it took to stop after that."""
        pressed = []

        def press():
            pressed.append(time.process_time())
            os.kill(os.getpid(), signal.SIGINT)
        timer = threading.Timer(after, press)
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            call()
        timer.join()
        return time.process_time() - pressed[0]

    def ends_in_silence(self, script):
        """Runs `script` in a Python of its own, where `bytes` is a file and Source() reads it."""
        begin = """
            import sys, threading, time
            sys.path.insert(0, sys.argv[1])
            import support
            from support import ptet
            bytes = support.built()
            class Source:
                size = len(bytes)
                def read(self, offset, size):
                    return bytes[offset:offset + size]
        """
        done = subprocess.run([sys.executable, "-c", textwrap.dedent(begin) + textwrap.dedent(script),
                               os.path.dirname(__file__)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              encoding="utf-8", timeout=60, check=False)
        self.assertEqual((done.returncode, done.stdout), (0, ""))

    def test_builds_stop(self):
        big = cube(36)  # for a minute or so
        for method in ({}, {"method": "BFS"}, {"method": "QN", "evaluate": "exact"}):
            with self.subTest(method), tempfile.TemporaryDirectory() as folder:
                took = self.interrupted(lambda: ptet.build(*big, out=folder + "/x.ptet", **method))
                self.assertLess(took, SOON)
                self.assertEqual(os.listdir(folder), [])

    def test_what_reads_stops(self):
        class Slow:
            size = len(built())

            def read(self, offset, size):
                if threading.current_thread() is threading.main_thread():
                    raise AssertionError("read by the wrong thread")
                time.sleep(0.5)
                return built()[offset:offset + size]

        data = None

        def wait():
            nonlocal data
            while True:
                data.extract(error="1%")
                data.wait_until_loaded()

        class Opening(Slow):
            def read(self, offset, size):
                return built()[offset:offset + size]
        source = Opening()
        data = ptet.open(source, background=True)
        source.read = Slow().read
        self.assertLess(self.interrupted(wait, after=0.2), SOON)
        del data

    def test_the_process_ends_as_interrupted(self):
        script = """
            import sys
            sys.path.insert(0, sys.argv[1])
            import support
            big = support.cube(36)
            print("ready", flush=True)
            support.ptet.build(*big)
        """
        child = subprocess.Popen([sys.executable, "-c", textwrap.dedent(script), os.path.dirname(__file__)],
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8")
        with child:
            self.assertEqual(child.stdout.readline(), "ready\n")
            time.sleep(0.5)
            child.send_signal(signal.SIGINT)
            _, errors = child.communicate(timeout=60)
        self.assertEqual(child.returncode, -signal.SIGINT)
        self.assertIn("KeyboardInterrupt", errors)

    def test_the_process_ends_while_other_threads_are_at_work(self):
        script = """
            def extract():
                data = ptet.open(bytes)
                while True:
                    data.extract(budget="50%")
            def read():
                while True:
                    ptet.open(Source()).extract()
            def update():
                session = ptet.open(bytes).session()
                while True:
                    session.update(budget="20%")
                    session.update(budget="50%")
            def report():
                while True:
                    ptet.open(bytes).extract(progress=lambda *what: time.sleep(0.001))
            def build():
                mesh = support.cube(8)
                while True:
                    ptet.build(*mesh, method="QN")
            for work in [extract, read, update, report, build]:
                threading.Thread(target=work, daemon=True).start()
            time.sleep(0.5)
        """
        for _ in range(5):
            self.ends_in_silence(script)

    def test_the_process_ends_while_one_thread_reads_and_others_are_to(self):
        script = """
            class Slow(Source):
                def read(self, offset, size):
                    if is_open.is_set():
                        is_read.set()
                        time.sleep(1)
                    return bytes[offset:offset + size]
            is_open, is_read = threading.Event(), threading.Event()
            many = [ptet.open(Source()) for _ in range(500)]
            slow = ptet.open(Slow())
            is_open.set()
            def extract():
                for data in many:
                    data.extract()
                    time.sleep(0.002)
            for work in [extract, slow.extract]:
                threading.Thread(target=work, daemon=True).start()
            is_read.wait()
        """
        self.ends_in_silence(script)

    def test_the_process_ends_while_a_source_reads_another_dataset(self):
        script = """
            class Outer(Source):
                def read(self, offset, size):
                    if is_open.is_set():
                        is_read.set()
                        time.sleep(1)
                        inner.extract()
                    return bytes[offset:offset + size]
            is_open, is_read = threading.Event(), threading.Event()
            inner = ptet.open(Source())
            outer = ptet.open(Outer())
            is_open.set()
            threading.Thread(target=outer.extract, daemon=True).start()
            is_read.wait()
        """
        self.ends_in_silence(script)

    def test_other_threads_run_meanwhile(self):
        big = cube(24)
        ticks, done = 0, threading.Event()
        error = []

        def build():
            try:
                ptet.build(*big, method="QN", threads=1)
            except ptet.Error as caught:
                error.append(caught)
            finally:
                done.set()
        thread = threading.Thread(target=build)
        thread.start()
        while not done.wait(0.01):
            ticks += 1
        thread.join()
        self.assertEqual(error, [])
        self.assertGreater(ticks, 5)


if __name__ == "__main__":
    unittest.main()
