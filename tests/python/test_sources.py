"""Where bytes come from: paths, memory, objects that read; and bytes that nobody should trust."""
import array
import gc
import pathlib
import random
import subprocess
import sys
import tempfile
import textwrap
import threading
import unittest
import warnings
import weakref

from support import built, check_mesh, cube

import numpy as np
import ptet


class Reader:
    """Counts what is read of the bytes."""

    def __init__(self, data=None):
        self.data = built() if data is None else data
        self.reads = []

    @property
    def size(self):
        return len(self.data)

    def read(self, offset, size):
        assert 0 <= offset and size > 0 and offset + size <= len(self.data)
        self.reads.append((offset, size))
        return self.data[offset:offset + size]


class Sources(unittest.TestCase):
    def setUp(self):
        self.wanted = ptet.open(built()).extract(error="2%")

    def check(self, data):
        np.testing.assert_array_equal(data.extract(error="2%").tets, self.wanted.tets)

    def test_what_a_source_raises_comes_after_nothing_else(self):
        class Broken(Reader):
            def read(self, offset, size):
                raise OSError("no such host")
        with self.assertRaisesRegex(ptet.FileError, "no such host") as caught:
            ptet.open(Broken())
        self.assertIsNone(caught.exception.__context__)

    def test_paths(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "ä.ptet"
            path.write_bytes(built())
            self.check(ptet.open(path))
            self.check(ptet.open(str(path)))
            with self.assertRaises(ptet.FileError) as caught:
                ptet.open(path / "none")
            self.assertIsInstance(caught.exception, FileNotFoundError)
            with self.assertRaises(ptet.FileError) as caught:
                ptet.open(folder)
            self.assertNotIsInstance(caught.exception, FileNotFoundError)
        for wrong in (3, None, object(), 1.5, ["a"], "\ud800"):
            with self.assertRaises(ptet.ArgumentError):
                ptet.open(wrong)
        with self.assertRaisesRegex(ptet.ArgumentError, r"memory_limit array\(\[1, 2\]\): a whole number"):
            ptet.open(built(), memory_limit=np.array([1, 2]))

    def test_memory(self):
        for data in (built(), bytearray(built()), memoryview(built()), array.array("B", built()),
                     np.frombuffer(built(), np.uint8)):
            self.check(ptet.open(data))
        with self.assertRaises(ptet.ArgumentError):
            ptet.open(np.frombuffer(built() * 2, np.uint8)[::2])

    def test_memory_is_held(self):
        held = bytearray(built())
        data = ptet.open(held)
        with self.assertRaises(BufferError):
            held.clear()
        array_of_bytes = np.frombuffer(bytearray(built()), np.uint8)
        is_alive = weakref.ref(array_of_bytes)
        other = ptet.open(array_of_bytes)
        del array_of_bytes
        gc.collect()
        self.check(other)
        cut = data.extract()
        del data, other
        gc.collect()
        held.clear()
        self.assertIsNone(is_alive())
        self.assertEqual(len(cut.tets), 3072)

    def test_a_reader_is_asked_for_what_is_needed(self):
        source = Reader()
        data = ptet.open(source)
        cut = data.extract(budget=50)
        read = sum(size for _, size in source.reads)
        self.assertLess(read, len(built()) // 2)
        self.assertEqual(cut.bytes_read, read)
        self.assertEqual(cut.read_requests, len(source.reads))
        self.check(data)

    def test_sizes(self):
        class Callable(Reader):
            def size(self):
                return np.int64(len(self.data))
        self.check(ptet.open(Callable()))
        for size in (-1, 2**64, 1.5, "many", None):
            source = Reader()
            with self.assertRaisesRegex(ptet.ArgumentError, f"size {size!r}: a number of bytes is wanted"):
                ptet.open(type("Sized", (), {"read": source.read, "size": size})())
        for size in (0, 10, len(built()) - 1):
            source = Reader(built())
            with self.assertRaises(ptet.FormatError):
                ptet.open(type("Sized", (), {"read": source.read, "size": size})())

    def test_any_text_of_an_error_is_told(self):
        def read(offset, size):
            raise ValueError("gone \udc80")
        source = type("Gone", (), {"size": 1000, "read": staticmethod(read)})()
        self.assertRaisesRegex(ptet.FileError, r"ValueError: gone \\udc80", ptet.open, source)

    def test_what_a_reader_answers_is_checked(self):
        class Own(Exception):
            pass

        def raises(*_):
            raise Own("no connection")
        answers = [lambda o, n: b"", lambda o, n: built()[o:o + n - 1], lambda o, n: built()[o:o + n] + b"x",
                   lambda o, n: "text", lambda o, n: None, lambda: b"", raises,
                   lambda o, n: np.zeros(2 * n, np.uint8)[::2]]
        for answer in answers:
            source = type("Wrong", (), {"read": staticmethod(answer), "size": len(built())})()
            with self.assertRaises(ptet.FileError):
                ptet.open(source)
        with self.assertRaisesRegex(ptet.FileError, "Own: no connection"):
            ptet.open(type("Wrong", (), {"read": staticmethod(raises), "size": len(built())})())

    def test_a_reader_that_fails_later(self):
        class Failing(Reader):
            fails = False

            def read(self, offset, size):
                if self.fails:
                    raise ConnectionError("gone")
                return super().read(offset, size)

        source = Failing()
        strict, salvage = ptet.open(source), ptet.open(source, salvage=True)
        source.fails = True
        with self.assertRaisesRegex(ptet.FileError, "ConnectionError: gone") as caught:
            strict.extract(error="2%")
        self.assertGreater(caught.exception.offset, 0)
        cut = salvage.extract(error="2%")
        self.assertFalse(cut.complete)
        self.assertEqual(cut.limited_by, "unreadable")
        self.assertTrue(all(failure.retriable for failure in cut.failures))
        self.assertLess(len(cut.tets), len(self.wanted.tets))
        check_mesh(self, cut.points, cut.tets, cut.boundary_faces)
        update = strict.session().update(error="2%")
        self.assertFalse(update.complete)
        self.assertEqual(update.limited_by, "unreadable")
        source.fails = False
        self.check(strict)
        self.check(salvage)

    def test_what_is_no_exception_comes_through(self):
        class Stopping(Reader):
            stops = False

            def read(self, offset, size):
                if self.stops:
                    self.stops = False
                    raise KeyboardInterrupt
                return super().read(offset, size)

        source = Stopping()
        data = ptet.open(source)
        for use in (lambda: data.extract(error="2%"), lambda: data.session().update(error="2%"),
                    lambda: ptet.open(source)):
            data = ptet.open(source)
            source.stops = True
            with self.assertRaises(KeyboardInterrupt):
                use()
            self.check(data)

    def test_in_the_background(self):
        source = Reader()
        data = ptet.open(source, background=True)
        cut = data.extract(error="2%")
        while not cut.complete:
            self.assertEqual(cut.limited_by, "loading")
            check_mesh(self, cut.points, cut.tets, cut.boundary_faces)
            data.wait_until_loaded()
            cut = data.extract(error="2%")
        np.testing.assert_array_equal(cut.tets, self.wanted.tets)

    def test_what_is_not_there_yet_is_not_warned_of(self):
        may_read = threading.Event()
        may_read.set()

        class Held(Reader):
            def read(self, offset, size):
                may_read.wait()
                return super().read(offset, size)

        data = ptet.open(Held(), background=True)
        may_read.clear()
        peak = {"error": 0, "values": ptet.Values("t", float(cube()[2]["t"].max()))}
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                self.assertEqual(data.extract(**peak).limited_by, "loading")  # the coarsest mesh, which is lower
            finally:
                may_read.set()
            data.wait_until_loaded()
            self.assertTrue(data.extract(**peak).complete)

    def test_closing_while_a_thread_reads(self):
        started = threading.Event()

        class Slow(Reader):
            def read(self, offset, size):
                if self.reads and len(self.reads) > 5:
                    started.set()
                return super().read(offset, size)

        for _ in range(30):
            data = ptet.open(Slow(), background=True)
            data.extract()
            del data  # the thread may be waiting for the GIL

    def test_the_end_of_python_while_a_thread_reads(self):
        script = """
            import sys, time, ptet
            data = open(sys.argv[1], "rb").read()
            class Slow:
                size = len(data)
                count = 0
                def read(self, offset, size):
                    self.count += 1
                    if self.count > 5:
                        time.sleep(0.02)
                    return data[offset:offset + size]
            kept = ptet.open(Slow(), background=True)
            kept.extract()
            time.sleep(float(sys.argv[2]))
            print("end")
        """
        with tempfile.NamedTemporaryFile() as file:
            file.write(built())
            file.flush()
            for pause in ("0", "0.03"):
                done = subprocess.run([sys.executable, "-c", textwrap.dedent(script), file.name, pause], timeout=60,
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", check=False)
                self.assertEqual((done.returncode, done.stdout), (0, "end\n"))

    def test_limits(self):
        for limit in ({"max_vertices": 100}, {"max_tets": 100}, {"max_bytes": 1000}):
            with self.assertRaises(ptet.LimitError):
                ptet.open(built(), **limit)
        for wrong in ({"max_tets": -1}, {"memory_limit": 1.5}, {"max_gap": "x"}, {"max_bytes": 2**64}):
            with self.assertRaises(ptet.ArgumentError):
                ptet.open(built(), **wrong)
        with self.assertRaises(ptet.LimitError):
            ptet.open(built(), memory_limit=1).extract()
        self.check(ptet.open(built(), max_bytes=ptet.open(built()).info.memory_for_all))
        cut = ptet.open(built(), memory_limit=1, salvage=True).extract()
        self.assertEqual(cut.limited_by, "memory")
        self.check(ptet.open(built(), memory_limit=10**8))


class Hostile(unittest.TestCase):
    """Damaged files are refused by the package's exceptions, or give sound meshes."""

    def use(self, data):
        try:
            opened = ptet.open(data, salvage=True, max_bytes=10**9)
            for request in ({"error": "3%"}, {}):
                cut = opened.extract(**request)
                self.assertLess(int(cut.tets.max()), len(cut.points))
            opened.session().update(error="3%")
        except ptet.Error as error:
            if isinstance(error, ptet.FormatError):
                self.assertTrue(error.offset is None or 0 <= error.offset <= len(data))
            return False
        return True

    def test_cut_short(self):
        for size in [*range(0, 200), *range(200, len(built()), 97)]:
            self.assertFalse(self.use(built()[:size]))

    def test_bits_turned(self):
        random_numbers, refused = random.Random(7), 0
        for _ in range(300):
            data = bytearray(built())
            data[random_numbers.randrange(len(data))] ^= 1 << random_numbers.randrange(8)
            refused += not self.use(data)
        self.assertGreater(refused, 30)
        self.assertLess(refused, 300)

    def test_noise(self):
        random_numbers = random.Random(8)
        for _ in range(50):
            self.assertFalse(self.use(random_numbers.randbytes(random_numbers.randrange(3000))))
            self.assertFalse(self.use(built()[:64] + random_numbers.randbytes(2000)))

    def test_a_damaged_block_is_told(self):
        data = ptet.open(built())
        data.extract(budget=50)
        damaged = bytearray(built())
        reader = Reader()
        opened = ptet.open(reader)
        opened.extract(error="1%")
        offset, size = reader.reads[-1]
        damaged[offset + size // 2] ^= 255
        with self.assertRaisesRegex(ptet.FormatError, "salvage") as caught:
            ptet.open(damaged).extract()
        self.assertTrue(offset <= caught.exception.offset < offset + size)
        cut = ptet.open(damaged, salvage=True).extract()
        self.assertEqual([failure.retriable for failure in cut.failures], [False])
        check_mesh(self, cut.points, cut.tets, cut.boundary_faces)


if __name__ == "__main__":
    unittest.main()
