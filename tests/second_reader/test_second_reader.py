"""The second reader against the program, on the golden files: what it decodes, which cuts it makes, what it rejects.
Usage: test_second_reader.py PTET [unittest options]"""
import collections
import itertools
import json
import math
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy as np
    import xxhash
    import zstandard
except ImportError as missing:
    print(f"skipped: {missing}; tools/install-dependencies.sh --tests installs it")
    sys.exit(77)

HERE = pathlib.Path(__file__).resolve().parent
sys.dont_write_bytecode = True  # leaves the source tree as it is
sys.path[:0] = [str(HERE), str(HERE.parent / "cli"), str(HERE.parent / "golden")]
import make_golden  # noqa: E402
import meshes  # noqa: E402
from ptet_reader import KINDS, OPTIONAL, Bytes, Corrupt, PtetFile  # noqa: E402

PTET = None
GOLDEN = sorted((HERE.parent / "golden").glob("*.ptet")) + [HERE.parents[1] / "formats" / "ptet" / "example.ptet"]
CORRUPT = 4  # the program's exit code


def hash_of(data):
    return xxhash.xxh64_intdigest(bytes(data))


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ptet-second-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def ptet(self, *arguments):
        return subprocess.run([PTET, *map(str, arguments)], cwd=self.folder, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, encoding="utf-8", errors="surrogateescape", timeout=600,
                              check=False)

    def output(self, *arguments):
        done = self.ptet(*arguments)
        self.assertEqual(done.returncode, 0, f"ptet {arguments}\n{done.stderr}")
        return done.stdout


def load(path, blocks=None):
    file = PtetFile(path)
    file.load(blocks)
    return file


def printable(name):
    return "".join(chr(c) if 0x20 <= c < 0x7F else f"\\x{c:02x}" for c in name.encode("utf-8", "surrogateescape"))


def describe(file, record):
    """A record as `ptet dump --annotate` says it."""
    text = lambda values: " ".join(f"{value:.9g}" for value in values)
    yield (f"record {record.number}: vertex {record.vertex} at {text(file.point(record.vertex))}, "
           f"split from vertex {record.target}, generation {record.generation}")
    for array in file.arrays:
        columns = range(array.first_column, array.first_column + array.components)
        yield f"{printable(array.name)}: " + text(file.values[i][record.vertex] for i in columns)
    codes = "".join(f" {own} / {monotone}" for own, monotone in zip(record.own, record.monotone))
    *squared, uncovered = record.squared or [None]
    squared = ", squared:" + "".join(f" {code}" for code in squared) if squared else ""
    squared += f", uncovered: {uncovered}" if file.squared else ""
    yield f"error codes, own / monotone:{codes}{squared}"
    yield f"order code: {record.order}"
    if record.parents:
        yield "after records " + " ".join(map(str, sorted(record.parents)))
    made = [" ".join("-" if x == file.w else str(x) for x in file.corners[t]) for t in record.made]
    yield "makes " + ", ".join(f"({corners})" for corners in made)


def described(file):
    return [line for r in range(file.record_count) for line in describe(file, file.records[r])]


def said_of_records(file, dump):
    """The same lines out of the dump."""
    begins = ["record ", "error codes", "order code", "after records", "makes"]
    begins += [printable(array.name) + ":" for array in file.arrays]
    lines = (line.strip().replace("-nan", "nan") for line in dump.splitlines())
    return [line for line in lines if line.startswith(tuple(begins))]


class Decoding(Case):
    def test_records(self):
        """Every record, with all it holds, is what the program says it is."""
        for path in GOLDEN:
            with self.subTest(path.name):
                file = load(path)
                self.assertEqual(said_of_records(file, self.output("dump", "--annotate", path)), described(file))

    def test_closed_sets(self):
        """What a record decodes to is the same in every closed set, whatever was loaded before."""
        for path in GOLDEN:
            whole, pick = load(path), random.Random(path.name)
            for _ in range(4):
                with self.subTest(path.name):
                    file = PtetFile(path)
                    for _ in range(2):
                        file.load(closure(file, pick.choices(range(file.block_count), k=2)))
                    for number, record in file.records.items():
                        self.assertEqual(list(describe(file, record)), list(describe(whole, whole.records[number])))
                    # The ranks too, which hold every bit.
                    for column, others in zip(file.ranks, whole.ranks):
                        self.assertLessEqual(column.items(), others.items())


def closure(file, numbers):
    """The smallest closed set of blocks with these."""
    closed, left = set(), set(numbers)
    while left:
        number = left.pop()
        closed.add(number)
        left |= set(file.blocks[number].needs) - closed
    return sorted(closed)


def rows_of(columns):
    """All that belongs to a vertex, as bytes."""
    return [b"".join(scalar.tobytes() for scalar in row) for row in zip(*columns)]


def oriented(tet):
    """The same for tets that are even permutations of each other."""
    order = sorted(range(4), key=lambda k: tet[k])
    odd = sum(order[i] > order[j] for i in range(4) for j in range(i + 1, 4)) % 2
    return (*(tet[k] for k in order), odd)


class Cuts(Case):
    def extract(self, path, *options):
        """Tets as the rows of their vertices, unused points, and the report."""
        report = json.loads(self.output("extract", path, "-o", "cut.vtu", "--json", *options))
        report["tight"] = "--errors" in options
        positions, arrays, tets = meshes.read_vtu(self.folder / "cut.vtu")
        names = [array.name for array in PtetFile(path).arrays]
        self.assertEqual(sorted(arrays), sorted(names))
        rows = rows_of(column for values in [positions, *(arrays[name] for name in names)]
                       for column in values.reshape(len(values), -1).T)
        unused = collections.Counter(rows[x] for x in set(range(len(rows))) - set(tets.ravel().tolist()))
        return collections.Counter(oriented([rows[x] for x in tet]) for tet in tets.tolist()), unused, report

    def cut(self, file, applied):
        """The same by the second reader."""
        tets = file.tets(applied)
        used = sorted({x for tet in tets for x in tet})
        base = set(range(file.base_vertices)) - {x for tet in file.corners[:file.base_tets] for x in tet}
        vertices = used + sorted(base)
        rows = rows_of(np.array([column.bits(ranks[x]) for x in vertices], dtype=f"<u{column.bytes}")
                       for column, ranks in zip(file.columns, file.ranks))
        row = dict(zip(vertices, rows))
        return (collections.Counter(oriented([row[x] for x in tet]) for tet in tets),
                collections.Counter(row[x] for x in base))

    def check_stated_errors(self, file, applied, report):
        """Field errors are of the records that made tets of the cut, the domain error of those that made its boundary
        faces, mean squares of all that are not applied. Without --errors the first two are only bounds: what made a tet
        may be in a block that was not read."""
        made = {False: set(), True: set()}  # by whether it is a ghost
        for corners, creator, consumer in zip(file.corners, file.creator, file.consumer):
            if consumer is not None and consumer not in applied and (creator is None or creator in applied):
                made[file.w in corners].add(consumer)
        achieved = report["achieved"]
        governing = [array for array in file.arrays if array.governing]
        for i, (name, scale) in enumerate([(array.name, array.range) for array in governing] + [(None, file.diagonal)]):
            code = max((file.records[r].own[i] for r in made[name is None]), default=0)
            error = scale * 2.0**((code - 1280) / 16) if code else 0.0
            stated = achieved["field_error"][name] if name else achieved["domain_error"]
            self.assertGreaterEqual(stated * (1 + 1e-12), error, name)
            if report["tight"]:
                self.assertLessEqual(stated, error * (1 + 1e-12), name)
        sums = [0.0] * file.sums
        for i, block in itertools.product(range(file.sums), file.blocks):
            if not any(r in applied for r in block.records):
                sums[i] += block.squared[i]
            else:
                codes = [file.records[r].squared[i] for r in block.records if r not in applied]
                sums[i] += sum(file.fraction(i, code) for code in codes)
        if file.squared:
            self.assertTrue(math.isclose(achieved["covered"], 1 - sums[-1], rel_tol=1e-9), (achieved["covered"], sums))
        for array, fractions in zip(governing, sums):
            error = array.range * math.sqrt(max(fractions, 0.0) / (1 - sums[-1]))
            error = min(error, achieved["field_error"][array.name])
            self.assertTrue(math.isclose(achieved["rms_error"][array.name], error, rel_tol=1e-6, abs_tol=1e-12),
                            (array.name, achieved["rms_error"], error))

    def test_original(self):
        for path in GOLDEN:
            with self.subTest(path.name):
                file = load(path)
                tets, unused, _ = self.extract(path)
                mine, spare = self.cut(file, file.records)
                self.assertEqual(tets, mine)
                self.assertEqual(unused, spare)
                self.assertEqual(tets.total(), file.tet_count)

    def test_input_order(self):
        """[Input order]: what was built from, as it stood; of a part of it, which vertices these are."""
        path = HERE.parent / "golden" / "ordered.ptet"
        points, tets, _ = make_golden.ordered()
        file = load(path)
        ids, mine = file.input_order()
        self.assertEqual(mine, tets)
        for x, row in enumerate(ids):
            self.assertEqual(file.point(x), points[row])
        self.output("extract", path, "--input-order", "-o", "whole.vtu")
        positions, arrays, cells = meshes.read_vtu(self.folder / "whole.vtu")
        self.assertEqual(list(map(tuple, positions.tolist())), points)
        self.assertEqual(cells.tolist(), tets)
        self.assertEqual(list(arrays), ["f"])
        self.output("extract", path, "--input-order", "--tets", "50%", "-o", "part.vtu")
        positions, arrays, _ = meshes.read_vtu(self.folder / "part.vtu")
        rows = arrays["input vertex"].ravel().tolist()
        self.assertEqual(rows, sorted(set(rows)))
        self.assertLess(len(rows), len(points))
        self.assertEqual(list(map(tuple, positions.tolist())), [points[row] for row in rows])
        self.assertEqual(self.ptet("extract", GOLDEN[0], "--input-order", "-o", "none.vtu").returncode, 2)

    def test_error_bounds(self):
        """Cuts by one error, from the blocks alone that they need."""
        for path in GOLDEN:
            whole = load(path)
            names = [array.name for array in whole.arrays if array.governing] + [None]
            for i, name in enumerate(names):
                codes = sorted({record.monotone[i] for record in whole.records.values()})
                for bound in codes[::max(1, len(codes) // 5)]:
                    with self.subTest(f"{path.name}, {name or 'domain'} <= {bound}"):
                        file = PtetFile(path)
                        file.load(closure(file, [b.number for b in file.blocks if b.max_error[i] > bound]))
                        applied = {r for r, record in file.records.items() if record.monotone[i] > bound}
                        scale = next((a.range for a in file.arrays if a.name == name), file.diagonal)
                        value = repr(scale * 2.0**((bound + 0.5 - 1280) / 16) if bound else 0.0)
                        tets, _, report = self.extract(path, *(["--field-error", f"{name}={value}"] if name else
                                                               ["--domain-error", value]))
                        self.assertEqual(tets, self.cut(file, applied)[0])
                        self.check_stated_errors(whole, applied, report)

    def test_budgets(self):
        """[Order codes]: from the largest code down, within a code by generation and then by number."""
        for path in GOLDEN:
            file = load(path)
            order = sorted(file.records.values(), key=lambda r: (-r.order, r.generation, r.number))
            for part in (0.3, 0.6):
                with self.subTest(f"{path.name}, {part}"):
                    applied, budget = set(), int(file.base_tets + part * (file.tet_count - file.base_tets))
                    left = budget - file.base_tets
                    for record in order:
                        left -= sum(file.w not in file.corners[t] for t in record.made)
                        left += sum(file.w not in file.corners[t] for t in record.region)
                        if left < 0:
                            break
                        applied.add(record.number)
                    tets, _, report = self.extract(path, "--tets", budget, "--errors")
                    self.assertEqual(tets, self.cut(file, applied)[0])
                    self.check_stated_errors(file, applied, report)


class Parts:
    """A file taken apart, to be changed and put together again with all hashes right."""

    def __init__(self, path):
        self.file = PtetFile(path)
        self.header = bytearray(self.file.data[:128])
        self.sections = []  # kind, flags, contents
        for name, content in self.file.sections.items():
            kind = next(kind for kind, known in KINDS.items() if known == name)
            self.sections.append([kind, int(kind not in OPTIONAL), bytearray(content)])
        self.footer_reserved, self.blocks_hash = 0, 0
        self.compressed = {}  # what is stored of a kind of section, where it is not the contents
        self.rows = []  # where in the table each block's hash is
        data = Bytes(self["table"])
        for block in self.file.blocks:
            for _ in range(3):
                data.varint()
            self.rows.append(len(self["table"]) - len(data.left))
            data.take(8 + 12 + 4 * len(block.max_error) + 2 + 8 * len(block.squared))
            for _ in range(data.varint()):
                data.varint()

    def __getitem__(self, name):
        return next(content for kind, _, content in self.sections if KINDS.get(kind) == name)

    def assemble(self):
        for block, at in zip(self.file.blocks, self.rows):
            content = self["blocks"][block.at:block.at + block.size]
            if hash_of(content) != block.hash:
                struct.pack_into("<Q", self["table"], at, hash_of(content))
        struct.pack_into("<Q", self.header, 120, hash_of(self.header[:120]))
        body, directory = bytearray(self.header), bytearray()
        for kind, flags, content in self.sections:
            stored = self.compressed.get(kind, content)
            stated = self.blocks_hash if kind == 4 else hash_of(stored)
            directory += struct.pack("<2I4Q", kind, flags, len(body), len(stored), len(content), stated)
            body += stored
        size = len(body) + len(directory) + 40
        return bytes(body + directory + struct.pack("<QIIQQ", len(body), len(self.sections), self.footer_reserved,
                                                    hash_of(directory), size) + b"PTETEND\n")


def put(part, layout, offset, change):
    """Changes one number of a part: by a function, or to a value."""
    old, = struct.unpack_from("<" + layout, part, offset)
    struct.pack_into("<" + layout, part, offset, change(old) if callable(change) else change)


def in_header(layout, offset, change):
    return lambda parts: put(parts.header, layout, offset, change)


def in_section(section, layout, offset, change):
    return lambda parts: put(parts[section], layout, offset, change)


def in_row(layout, offset, change):
    """In the table's row of block 0, counted from its hash."""
    return lambda parts: put(parts["table"], layout, parts.rows[0] + offset, change)


def compress(*cuts):
    """The model as so many zstd frames and one more."""
    def change(parts):
        model, ends = bytes(parts["model"]), [0, *cuts, None]
        frames = [zstandard.compress(model[a:b]) for a, b in zip(ends, ends[1:])]
        parts.compressed[2] = b"".join(frames)
    return change


def with_order(flags, longer=0, times=1):
    """An input order, all zero: what is in it is not looked at before somebody asks for it."""
    def change(parts):
        size = 4 * parts.file.w + 5 * parts.file.tet_count + longer
        parts.sections += [[7, flags, bytearray(size)] for _ in range(times)]
    return change


def one_more(x):
    return x + 1


def directory(place, field, value):
    return lambda parts: parts.sections[place].__setitem__(field, value)


# What PTET.md says must be rejected, done to tiny.ptet: one array "f", three blocks, a base of 8 vertices and 6 tets.
VIOLATIONS = {
    "version": in_header("I", 8, 2),
    "reserved field of the header": in_header("I", 12, 1),
    "reserved flag": in_header("H", 54, 5),
    "base_vertex_count": in_header("I", 16, one_more),
    "record_count": in_header("I", 24, one_more),
    "tet_count": in_header("I", 28, one_more),
    "block_count": in_header("I", 32, one_more),
    "array_count": in_header("I", 36, one_more),
    "version_count": in_header("Q", 40, one_more),
    "records_per_block": in_header("H", 48, 0),
    "position_type": in_header("B", 50, 10),
    "precision of positions": in_header("B", 51, 8),
    "no zero bits of positions": in_header("B", 51, 64),
    "more zero bits of positions than there are": in_header("B", 51, 64 + 24),
    "box that ends before it begins": in_header("d", 56, 2.0),
    "box with NaN": in_header("d", 56, math.nan),
    "box without an end": lambda parts: [in_header("d", at, x)(parts) for at, x in ((56, -1.5e308), (80, 1.5e308))],
    "negative diagonal": in_header("d", 104, -1.0),
    "no volume, but squared errors": in_header("d", 112, 0.0),
    "reserved field of the footer": lambda parts: setattr(parts, "footer_reserved", 1),
    "hash of the blocks section": lambda parts: setattr(parts, "blocks_hash", 1),
    "reserved flag of a section": directory(0, 1, 3),
    "known section that is not mandatory": directory(0, 1, 0),
    "unknown section that is mandatory": lambda parts: parts.sections.append([77, 1, bytearray(3)]),
    "section that is there twice": lambda parts: parts.sections.append(list(parts.sections[0])),
    "input order marked as mandatory": with_order(1),
    "input order that is too long": with_order(0, longer=1),
    "input order that is too short": with_order(0, longer=-1),
    "no input order in its section": lambda parts: parts.sections.append([7, 0, bytearray()]),
    "two input orders": with_order(0, times=2),
    "section that is not there": lambda parts: parts.sections.pop(),
    "section of two zstd frames": compress(1000),
    "section of a zstd frame and an empty one": compress(1 << 20),
    "type of an array": in_section("arrays", "B", 2, 10),
    "array without components": in_section("arrays", "B", 3, 0),
    "governing": in_section("arrays", "B", 4, 2),
    "negative range": in_section("arrays", "d", 5, -1.0),
    "precision of an array": in_section("arrays", "B", 13, 8),
    "corner that is no vertex": in_section("base", "B", -96, one_more),
    "corner that is there twice": in_section("base", "I", -72, 0),
    "number of manifest options": lambda parts: parts["manifest"].__setitem__(slice(-2, None), b"\xff\x7f"),
    "box of a block too small": in_row("H", 8, one_more),
    "box of a block that ends before it begins": in_row("H", 14, 0),
    "largest error of a block": in_row("H", 20, one_more),
    "largest error out of range": in_row("H", 22, 2048),
    "largest own error of a block too small": in_row("H", 24, lambda x: x - 1),
    "largest own error above the largest error": in_row("H", 26, 2047),
    "largest order code out of range": in_row("H", 28, 768),
    "squared error of a block": in_row("d", 30, lambda x: 2 * x),
    "squared error out of range": in_row("d", 30, math.inf),
    "uncovered volume of a block": in_row("d", 38, lambda x: x + 0.1),
    "block that needs itself": in_row("H", 46, 0x0001),
    "generation": in_section("blocks", "B", 0, 5),
    "generation of no record": in_section("blocks", "B", 0, 127),
    "run without records": in_section("blocks", "B", 1, 0),
    **{f"byte behind the end of the {name}": lambda parts, name=name: parts[name].append(0)
       for name in ("arrays", "model", "base", "manifest", "table", "blocks")},
}


class Rejection(Case):
    def outcome(self, data):
        """None when the second reader rejects a file, else all its records."""
        path = self.folder / "changed.ptet"
        path.write_bytes(data)
        try:
            return load(path)
        except Corrupt:
            return None

    def test_any_byte(self):
        """No byte can change."""
        data = bytearray((HERE.parent / "golden" / "tiny.ptet").read_bytes())
        for at in range(len(data)):
            data[at] ^= 1 << at % 8
            self.assertIsNone(self.outcome(data), f"byte {at}")
            data[at] ^= 1 << at % 8

    def test_any_length(self):
        data = (HERE.parent / "golden" / "tiny.ptet").read_bytes()
        for length in range(len(data)):
            self.assertIsNone(self.outcome(data[:length]), f"{length} bytes")
        self.assertIsNone(self.outcome(data + b"\0"))

    def test_violations(self):
        """With all hashes right; the program rejects them as well."""
        path = HERE.parent / "golden" / "tiny.ptet"
        parts = Parts(path)
        for same in (lambda parts: None, compress()):
            same(parts)
            self.assertIsNotNone(self.outcome(parts.assemble()))
            self.assertEqual(self.ptet("extract", "changed.ptet").returncode, 0)
        for name, violate in VIOLATIONS.items():
            with self.subTest(name):
                parts = Parts(path)
                violate(parts)
                self.assertIsNone(self.outcome(parts.assemble()))
                self.assertEqual(self.ptet("extract", "changed.ptet").returncode, CORRUPT)

    def test_violations_of_the_input_order(self):
        """Found by who asks for it."""
        path = HERE.parent / "golden" / "ordered.ptet"
        file = PtetFile(path)
        changes = {"a vertex twice": in_section("input order", "B", 1, 0),
                   "no such vertex": in_section("input order", "B", 3 * file.w, 1),
                   "a tet twice": in_section("input order", "B", 4 * file.w + 1, 0),
                   "no such order of corners": in_section("input order", "B", -1, 24)}
        for name, change in changes.items():
            with self.subTest(name):
                parts = Parts(path)
                change(parts)
                changed = self.outcome(parts.assemble())
                self.assertRaises(Corrupt, changed.input_order)
                done = self.ptet("extract", "changed.ptet", "--input-order", "-o", "out.vtu")
                self.assertEqual(done.returncode, CORRUPT)
                self.assertEqual(self.ptet("verify", "changed.ptet").returncode, CORRUPT)
                self.assertEqual(self.ptet("extract", "changed.ptet").returncode, 0)

    def test_skippable_section(self):
        for path in GOLDEN:
            parts = Parts(path)
            parts.sections.insert(2, [77, 0, bytearray(b"of a later version")])
            file = self.outcome(parts.assemble())
            self.assertEqual(file.corners, load(path).corners)
            self.assertEqual(self.ptet("extract", "changed.ptet").returncode, 0)

    def test_random_changes(self):
        """Changed at random, with all hashes right: both readers reject a file, or both see the same in it."""
        accepted = 0
        for path in GOLDEN:
            pick = random.Random(path.name)
            for trial in range(12):
                parts = Parts(path)
                name = pick.choice(["blocks", "blocks", "table", "base", "arrays", "model"])
                part = parts[name]
                at = pick.randrange(len(part))
                part[at] = pick.randrange(256)
                with self.subTest(f"{path.name}, trial {trial}: byte {at} of {name}"):
                    file = self.outcome(parts.assemble())
                    done = self.ptet("dump", "--annotate", "changed.ptet")
                    self.assertEqual(done.returncode, 0 if file else CORRUPT, done.stderr)
                    if file:
                        self.assertEqual(said_of_records(file, done.stdout), described(file))
                        accepted += 1
        self.assertGreater(accepted, 20)


if __name__ == "__main__":
    PTET = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
