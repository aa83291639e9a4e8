"""A second reader of .ptet files, version 1, in Python with numpy, zstandard and xxhash, written from
formats/ptet/PTET.md alone: where it and the C++ reader see different meshes in a file, or where it could not have been
written without looking there, the specification has a hole. Titles in brackets name the sections of PTET.md.

    file = PtetFile(path)            # everything but the blocks
    file.load([0, 3])                # decodes a closed set of blocks; without an argument all of them
    tets = file.tets(applied)        # those of the mesh in which the splits of these records are applied, by vertices
    ids, tets = file.input_order()   # the vertices' ids in the input, and its tets by these; where the file keeps them

ranks[column][vertex] and values[column][vertex] are what the vertices have, x y z first. A violation raises Corrupt.
"""
import functools
import itertools
import math
import operator
import struct
from bisect import bisect_left, bisect_right
from collections import defaultdict
from types import SimpleNamespace

import numpy as np
import zstandard
from xxhash import xxh64_intdigest as hash_of

from ptet_numbers import Bytes, Column, Corrupt, RangeDecoder, clamp, require

KINDS = {1: "arrays", 2: "model", 3: "base", 4: "blocks", 5: "manifest", 6: "table", 7: "input order"}
OPTIONAL = {7}
truncated = lambda a, b: -(-a // b) if a < 0 else a // b
total = lambda terms: functools.reduce(lambda a, b: a + b, terms, 0.0)  # newer Pythons' sum() rounds less often
pattern = lambda x: struct.unpack("<Q", struct.pack("<d", x))[0]
minus = lambda a, b: (a[0] - b[0], a[1] - b[1], a[2] - b[2])
cross = lambda a, b: (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
dot = lambda a, b: a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
finite_box = lambda box: all(map(math.isfinite, box)) and all(0 <= box[i + 3] - box[i] < math.inf for i in range(3))
known_type = lambda kind, precisions: kind < 10 and all(
    p == 0 or kind > 7 and (p <= (7, 12)[kind - 8] or 64 < p <= 64 + (23, 52)[kind - 8]) for p in precisions)


def expand(data, size):
    frame = zstandard.ZstdDecompressor().decompressobj()
    try:
        out = frame.decompress(data)
    except zstandard.ZstdError as error:
        raise Corrupt("a zstd frame") from error
    require(len(out) == size and not frame.unused_data, "the size of a zstd frame")
    return out


class Grid:
    """The 65536 places of a side of the mesh's box, in ascending order."""

    def __init__(self, low, high):
        self.low, self.high, self.step = low, high, (high - low) / 65535

    def __len__(self):
        return 65536

    def __getitem__(self, i):
        return self.high if i == 65535 else min(self.high, self.low + i * self.step)


class PtetFile:
    """A file of which blocks are decoded on demand. Vertices are numbered as in PTET.md, versions as they are met."""

    def __init__(self, path):
        with open(path, "rb") as file:
            self.data = file.read()
        self.read_header()
        self.sections = self.read_directory()
        self.read_arrays(Bytes(self.sections["arrays"]))
        self.place_contexts()
        manifest = Bytes(self.sections["manifest"])
        self.provenance = [manifest.text() for _ in range(3)]
        self.options, self.notes = ([[manifest.text() for _ in range(texts)] for _ in range(
            manifest.varint(len(manifest.left)))] for texts in (2, 1))
        require(not manifest.left, "bytes behind the manifest")
        self.read_table(Bytes(self.sections["table"]))
        self.read_base(Bytes(self.sections["base"]))
        require(len(self.sections.get("input order", bytes(4 * self.w + 5 * self.tet_count)))
                == 4 * self.w + 5 * self.tet_count, "the input order")
        self.records = {}

    def read_header(self):
        require(len(self.data) >= 168 and self.data[:8] == b"\x89PTET\r\n\x1a", "magic")
        (version, reserved, self.base_vertices, self.base_tets, self.record_count, self.tet_count, self.block_count,
         self.array_count, self.version_count, self.records_per_block, self.kind, self.precisions, flags, *box,
         self.diagonal, self.volume, stated) = struct.unpack("<8IQHB3sH6d2dQ", self.data[8:128])
        self.squared, self.w = flags & 1, self.base_vertices + self.record_count
        require(version == 1 and stated == hash_of(self.data[:120]), "the version, or the hash of the header")
        require(reserved == 0 and flags < 4, "a reserved field of the header")
        require(self.w < 2**32 - 2 and self.record_count < 2**31 and self.array_count <= 1024
                and 0 <= self.tet_count - self.base_tets <= self.version_count < 2**32 - 2
                and 1 <= self.records_per_block <= 4096, "a count of the header")
        require(known_type(self.kind, self.precisions) and finite_box(box) and 0 <= self.diagonal < math.inf
                and 0 <= self.volume < math.inf and (self.volume or not self.squared), "a type or scale of the header")

        self.grid = [Grid(low, high) for low, high in zip(box[:3], box[3:])]

    def read_directory(self):
        start, count, reserved, stated, size, magic = struct.unpack("<Q2I2Q8s", self.data[-40:])
        require(magic == b"PTETEND\n" and reserved == 0 and count <= 64, "the footer")
        require(size == len(self.data) and start == size - 40 - 40 * count >= 128, "a size of the footer")
        require(stated == hash_of(self.data[start:-40]), "the hash of the directory")
        sections, at = {}, 128
        for kind, flags, offset, stored, raw, stated in struct.iter_unpack("<2I4Q", self.data[start:-40]):
            require(flags == (kind in KINDS and kind not in OPTIONAL), "a section's flags, or a mandatory one unknown")
            require(offset == at and stored <= start - at and stored <= raw <= 1024 * stored, "a section's place")
            at += stored
            if kind in KINDS:
                name, content = KINDS[kind], self.data[offset:at]
                require(name not in sections and (raw == stored or name != "blocks"), f"the section {name}")
                require(stated == (0 if name == "blocks" else hash_of(content)), f"the hash of the section {name}")
                sections[name] = content if raw == stored else expand(content, raw)
        wanted = {name for kind, name in KINDS.items() if kind not in OPTIONAL}
        require(at == start and wanted <= sections.keys(), "a gap in the file, or a section that is not there")
        return sections

    def read_arrays(self, data):
        self.arrays = []
        for _ in range(self.array_count):
            array = SimpleNamespace(name=data.text(), kind=data.get("B")[0], components=data.varint(1024))
            array.governing, array.range, *array.precisions = data.get(f"Bd{array.components}B")
            require(array.precisions and known_type(array.kind, array.precisions) and array.governing < 2
                    and 0 <= array.range < math.inf, "an array")
            self.arrays.append(array)
        require(not data.left, "bytes behind the arrays")
        self.governing = sum(array.governing for array in self.arrays)

    def place_contexts(self):
        """[Contexts]"""
        self.c, self.columns, at = SimpleNamespace(), [], 0
        self.codes = k = self.governing + 1
        self.sums = k * self.squared
        for name, count in dict(
                source=256, index=320, fine=64, fine_rest=128, corner=8, more_seeds=1, growth=2048, same=192, columns=0,
                own_zero=4 * k, own=520 * k, above_zero=4 * k, above=128 * k, squared_zero=4 * self.sums,
                squared_negative=6 * self.sums, squared=260 * self.sums, order=1024).items():
            setattr(self.c, name, at)
            at += count
            for array in [self, *self.arrays] if name == "columns" else []:
                array.first_column = len(self.columns)
                for i, precision in enumerate(array.precisions):
                    self.columns.append(Column(array.kind, precision, at if i < 4 else self.columns[-1].start))
                    at = max(at, self.columns[-1].end)
        require(len(self.sections["model"]) == at <= 2**22, "the size of the model")
        self.vertex_bytes = sum(column.bytes for column in self.columns)

    def read_table(self, data):
        self.blocks, first, at, versions = [], 0, 0, 0
        for number in range(self.block_count):
            size, n, made = data.varint(), data.varint(), data.varint()
            require(1 <= n <= self.records_per_block and 4 * n <= made <= 32 * size
                    and n * self.vertex_bytes <= 256 * size, "a count of the table")
            block = SimpleNamespace(number=number, first=first, records=range(first, first + n), versions=made, at=at,
                                    size=size, loaded=False, needs=[])
            block.hash, *places = data.get("Q6H")
            block.box = [self.grid[i % 3][place] for i, place in enumerate(places)]
            block.max_error = list(data.get(f"{self.codes}H"))
            *block.max_own, block.max_order = data.get(f"{self.codes}HH")
            block.squared = data.get(f"{self.sums}d")
            require(finite_box(block.box) and max(block.max_error) <= 2047 and block.max_order <= 767
                    and all(own <= most for own, most in zip(block.max_own, block.max_error))
                    and all(abs(x) <= 2.0**68 for x in block.squared), "a number of the table")
            for _ in range(data.varint(len(data.left))):
                block.needs.append(data.varint() + (block.needs[-1] + 1 if block.needs else 0))
            require(all(need < self.block_count and need != number for need in block.needs), "a needed block")
            self.blocks.append(block)
            first, at, versions = first + n, at + size, versions + made
        require(not data.left and at == len(self.sections["blocks"])
                and first == self.record_count and versions == self.version_count, "the sums of the table")

    def read_base(self, data):
        require(len(data.left) == self.base_vertices * self.vertex_bytes + 16 * self.base_tets, "the size of the base")

        def planes(count, width):
            of_each = np.frombuffer(data.take(count * width), "u1").reshape(width, count).T
            return np.ascontiguousarray(of_each).view(f"<u{width}").reshape(count)

        ranks = [np.cumsum(planes(self.base_vertices, c.bytes), dtype=f"u{c.bytes}").tolist() for c in self.columns]
        self.ranks = [dict(enumerate(column)) for column in ranks]
        self.values = [{x: c.value(rank) for x, rank in column.items()} for c, column in zip(self.columns, self.ranks)]
        first = np.cumsum(planes(self.base_tets, 4), dtype="u4")
        corners = [first] + [first + planes(self.base_tets, 4) for _ in range(3)]
        self.corners = [tuple(tet) for tet in np.stack(corners, axis=1).tolist()]
        require(all(max(t) < self.base_vertices and len(set(t)) == 4 for t in self.corners), "a corner of the base")
        require(len({frozenset(t) for t in self.corners}) == self.base_tets, "a tet of the base twice")
        faces, edges = defaultdict(list), defaultdict(list)  # [Seeds, Neighbours]
        for t, tet in enumerate(self.corners):
            for k in range(4):
                faces[tuple(sorted(tet[:k] + tet[k + 1:]))].append((t, k))
        require(all(len(sides) <= 2 for sides in faces.values()), "a face of more than two tets")
        for face in sorted(face for face, sides in faces.items() if len(sides) == 1):
            t, k = faces[face][0]
            faces[face].append((len(self.corners), 3))
            ghost = tuple(self.corners[t][k ^ i] for i in (1, 2, 3))
            for i in range(3):
                edges[frozenset(ghost) - {ghost[i]}].append((len(self.corners), i))
            self.corners.append(ghost + (self.w,))
        self.base_versions = len(self.corners)
        self.neighbours = [[None] * 4 for _ in self.corners]
        self.creator, self.consumer = [None] * self.base_versions, [None] * self.base_versions
        for sides in [*faces.values(), *edges.values()]:
            if len(sides) == 2:
                self.join(*sides)

    def join(self, one, other):
        """Makes two tets neighbours at the faces opposite these corners of theirs: (tet, corner) each."""
        self.neighbours[one[0]][one[1]], self.neighbours[other[0]][other[1]] = other[0], one[0]

    def load(self, numbers=None):
        """Decodes a set of blocks that is closed together with those that were loaded before [Cuts]."""
        numbers = range(self.block_count) if numbers is None else numbers
        new = [self.blocks[number] for number in numbers if not self.blocks[number].loaded]
        runs = [run for block in new for run in self.open(block)]
        for generation, number, records in sorted(runs, key=lambda run: run[:2]):
            for r in records:
                self.decode(self.blocks[number], r, generation)
        for block in new:
            self.check(block, [self.records[r] for r in block.records])
            block.loaded = True
        if all(block.loaded for block in self.blocks):
            require(len(self.tets(self.records)) == self.tet_count, "tet_count")

    def open(self, block):
        """Its runs and other parents [Order]; the state before the first record [A record]."""
        data = Bytes(self.sections["blocks"][block.at:block.at + block.size])
        require(hash_of(data.left) == block.hash, f"the hash of block {block.number}")
        runs, block.other_parents, r, generation = [], defaultdict(list), block.first, -1
        while r < block.records.stop:
            generation, count = generation + 1 + data.varint(), data.varint(block.records.stop - r)
            require(count >= 1 and generation < self.record_count, "a run")
            runs.append((generation, block.number, range(r, r + count)))
            r += count
        r, homes = block.first - 1, [block, *(self.blocks[number] for number in block.needs)]
        for _ in range(data.varint(len(block.records))):
            r += 1 + data.varint()
            parents, count = block.other_parents[r], data.varint(len(data.left) // 2)
            for _ in range(count):
                home = homes[data.varint(len(block.needs))]
                parents.append(home.records[data.varint(len(home.records) - 1)])
            require(r in block.records and parents and parents == sorted(set(parents)), "other parents")
        block.coder, block.homes = RangeDecoder(bytes(data.left), self.sections["model"]), homes
        block.recent, block.last_index, block.last_rank = [*range(len(homes) + 1)], [0] * (len(homes) + 1), 0
        block.last_own, block.own_zero, block.above_zero = [1280] * self.codes, [0] * self.codes, [0] * self.codes
        block.last_sign = [0] * self.codes
        block.drift, block.last_code = ([[start] * 2 for _ in range(self.governing)] for start in (-960, 800))
        return runs

    def check(self, block, records):
        """What the table states exactly [Table]."""
        made = {t for record in records for t in record.made}
        around = {x for t in made for x in self.corners[t]} - {self.w}
        points = np.array([self.point(x) for x in around])
        require(block.versions == len(made), "version_count of the table")
        least, greatest = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        require(all(grid.low <= a <= b <= grid.high for grid, a, b in zip(self.grid, least, greatest)),
                "a vertex outside")
        require(block.box == [grid[bisect_right(grid, x) - 1] for grid, x in zip(self.grid, least)]
                + [grid[bisect_left(grid, x)] for grid, x in zip(self.grid, greatest)], "a box of the table")
        require(block.max_error == [max(codes) for codes in zip(*(record.monotone for record in records))]
                and block.max_own == [max(codes) for codes in zip(*(record.own for record in records))]
                and block.max_order == max(record.order for record in records), "a largest code of the table")
        for i, stated in enumerate(block.squared):
            least, most = ([self.fraction(i, record.squared[i] - less) for record in records] for less in (1, 0))
            slack = total(max(abs(a), abs(b)) for a, b in zip(least, most)) * 2.0**-40
            require(total(least) - slack <= stated <= total(most) + slack, "a squared error of the table")

    def fraction(self, i, code):
        """[Squared errors]"""
        whole = 1600 if i < self.governing else 65 + 8 * self.record_count.bit_length()
        return math.copysign(2.0**((abs(code) - whole) / 8), code) if code else 0.0

    def decode(self, block, r, generation):
        """[A record]"""
        record = SimpleNamespace(number=r, generation=generation, vertex=self.base_vertices + r, region=[], made=[])
        self.decode_seeds(block, record)
        self.decode_position(block.coder, record)
        self.grow(block.coder, record)
        self.split(record)
        self.decode_errors(block, record, self.decode_arrays(block.coder, record))
        record.squared = self.decode_squared(block, record) if self.squared else []
        record.parents = {self.creator[t] for t in record.region}.union(block.other_parents.get(r, [])) - {None}
        most = block.max_order
        for number in record.parents:
            parent = self.records.get(number)
            require(parent and any(number in home.records for home in block.homes), "a parent is not there")
            require(parent.generation < generation and all(map(operator.ge, parent.monotone, record.monotone)),
                    "a parent's generation, or its errors")
            most = min(most, parent.order)
        record.order = most - block.coder.uint(self.c.order + 128 * min(7, (block.max_order - most) // 8))
        require(record.order >= 0, "an order code")
        self.records[r] = record

    def decode_seeds(self, block, record):
        coder, more, record.target = block.coder, 1, None
        while more:
            rank = coder.uint(self.c.source + 128 * (block.last_rank != 0))
            require(rank < len(block.recent), "a seed's source")
            source, block.last_rank = block.recent.pop(rank), rank
            block.recent.insert(0, source)
            index = block.last_index[source] + coder.int(self.c.index + 160 * (source != 0))
            require(0 <= index < 2**31, "a seed's index")
            block.last_index[source] = index
            versions, k, context = range(self.base_versions), index, self.c.corner
            if source < len(block.homes):
                home, context = block.homes[source], self.c.corner + 4
                require(index < len(home.records) and home.first + index in self.records, "a seed's record")
                k = coder.tree(self.c.fine + 32 * (source != 0), 5)
                k += coder.uint(self.c.fine_rest) if k == 31 else 0
                versions = self.records[home.first + index].made
            require(k < len(versions), "a seed's version")
            seed, u = versions[k], self.corners[versions[k]][coder.tree(context, 2)]
            require(u != self.w and record.target in (None, u), "a seed's vertex")
            require(self.consumer[seed] is None and seed not in record.region, "a seed that is not there, or twice")
            record.target, more = u, coder.bit(self.c.more_seeds)
            record.region.append(seed)
            require(len(record.region) <= 4096, "too many seeds")

    def decode_position(self, coder, record):
        corners = [record.target, *(x for x in self.corners[record.region[0]] if x not in (record.target, self.w))]
        earlier = 0
        for axis, (column, ranks, values) in enumerate(zip(self.columns[:3], self.ranks, self.values)):
            at = [ranks[x] for x in corners]
            for i, rank in enumerate(dict.fromkeys(at)):
                if coder.bit(self.c.same + ((axis * 4 + i) * 4 + at.count(rank) - 1) * 4 + earlier):
                    earlier += 1 << axis
                    break
            else:
                u, *others = at = [values[x] for x in corners]
                rank = column.decode(coder, u + 0.6 * (total(others) / len(others) - u), max(at) - min(at))
            ranks[record.vertex], values[record.vertex] = rank, column.value(rank)

    def point(self, x): return self.values[0][x], self.values[1][x], self.values[2][x]

    def grow(self, coder, record):
        """[Growth]"""
        region, inside, u, w, rim = record.region, set(record.region), record.target, self.w, defaultdict(int)
        at_u, at_v = self.point(u), self.point(record.vertex)
        from_u = functools.cache(lambda x: minus(self.point(x), at_u))
        above = lambda value, unit, steps: sum(not value < step * unit for step in steps)

        @functools.cache
        def near(x):
            du, dv = (dot(d, d) for d in (from_u(x), minus(self.point(x), at_v))) if x != w else (0, 0)
            return above(dv, du, (0.3, 0.6, 0.9, 1.3, 2)) if x != w else 6

        def height(a, b, c):
            if w in (a, b):
                return near(c)
            normal = cross(from_u(a), from_u(b))
            h = dot(normal, minus(at_v, at_u))
            if c == w:
                return 7 if h > 0 else 6
            return 1 + above(h, dot(normal, from_u(c)), (0.1, 0.3, 0.6, 1.2)) if h > 0 else 0

        for t in region:  # grows meanwhile
            corners = self.corners[t]
            m = corners.index(u)
            for k, behind in enumerate(self.neighbours[t]):
                if k == m or behind is None or behind in inside:
                    continue
                # (m, m^1, m^2, m^3) is even, and stays so when its last three are rotated.
                a, b = corners[m ^ (m ^ k) % 3 + 1], corners[m ^ ((m ^ k) + 1) % 3 + 1]
                least, most = sorted((near(a), near(b)))
                edge = 3 if max(rim[a], rim[b]) >= 2 else rim[a] + rim[b]
                high = 0 if edge == 3 else height(a, b, corners[k])
                if coder.bit(self.c.growth + ((high * 8 + most) * 8 + least) * 4 + edge):
                    region.append(behind)
                    inside.add(behind)
                else:
                    rim[a], rim[b] = rim[a] + 1, rim[b] + 1
            require(len(region) <= 4096, "too large a region")

    def split(self, record):
        """[The split]"""
        u, v, region = record.target, record.vertex, record.region
        place = {t: self.corners[t].index(u) for t in region}

        def make(corners):
            for column, entry in ((self.corners, tuple(corners)), (self.neighbours, [None] * 4),
                                  (self.creator, record.number), (self.consumer, None)):
                column.append(entry)
            record.made.append(len(self.corners) - 1)
            return record.made[-1]

        modified = {t: make([v, *(self.corners[t][place[t] ^ i] for i in (1, 2, 3))]) for t in region}
        rim = defaultdict(list)  # at each of its vertices the faces of new tets there, as (tet, corner)
        start, behind_edge = None, {}  # of the cycle, and by the vertex where a tet's edge of it begins: tet and end
        for t in region:
            self.consumer[t], m = record.number, modified[t]
            for j, behind in enumerate(self.neighbours[t]):
                i, last = j ^ place[t], (m, 0)
                if i > 0 and behind in place:
                    self.neighbours[m][i] = modified[behind]
                    continue
                if i > 0:
                    fine = make(v if l == 0 else u if l == i else self.corners[m][l ^ i] for l in range(4))
                    self.join((fine, i), (m, i))
                    last = fine, 0
                    for k in {1, 2, 3} - {i}:
                        rim[self.corners[fine][6 - i - k]].append((fine, k))
                    begins, ends = self.corners[m][(i + 1) % 3 + 1], self.corners[m][i % 3 + 1]
                    start = begins if start is None else start
                    behind_edge[begins] = fine, ends
                if behind is not None:
                    self.join(last, (behind, self.neighbours[behind].index(t)))
        # A disk: V - E + F = 1 with 2 E = 3 F + rim, and the tets at the rim are one cycle.
        vertices, new = {x for t in region for x in self.corners[t]} - {u}, set(record.made[len(region):])
        require(len(new) >= 3 and 2 * len(vertices) == len(region) + len(new) + 2
                and all(len(sides) == 2 for sides in rim.values()), "a region that is no disk")
        for sides in rim.values():
            self.join(*sides)
        reached = [record.made[-1]]
        for f in reached:
            reached += new.intersection(self.neighbours[f]).difference(reached)
        require(len(reached) == len(new), "a rim of more than one cycle")
        require(len(behind_edge) == len(new), "a rim that begins twice at a vertex")
        for k in range(len(region), len(record.made)):
            require(start in behind_edge, "a rim that turns round")
            record.made[k], start = behind_edge.pop(start)

    def decode_arrays(self, coder, record):
        """[Arrays]; returns the missed codes of the governing ones."""
        v, missed = record.vertex, []
        around = dict.fromkeys(x for t in record.made for x in self.corners[t][1:] if x != self.w)
        squares = [(x, dot(d, d)) for x in around for d in [minus(self.point(x), self.point(v))]]
        weights = [(x, 1 / d if d > 0 else 0.0) for x, d in squares]
        for array in self.arrays:
            greatest = 0.0
            for i in range(array.first_column, array.first_column + array.components):
                column, values = self.columns[i], self.values[i]
                known = [(weight, values[x]) for x, weight in weights if math.isfinite(values[x])]
                whole, p, q = total(weight for weight, _ in known), 0.0, 0.0
                if whole > 0:
                    p = total(weight * value for weight, value in known) / whole
                    q = total(weight * abs(value - p) for weight, value in known) / whole
                self.ranks[i][v] = column.decode(coder, p, q)
                values[v] = column.value(self.ranks[i][v])
                greatest = max(greatest, abs(values[v] - p))
            if array.governing:
                code = (pattern(greatest) >> 48) - (pattern(array.range) >> 48) + 1280
                missed.append(clamp(code, 1, 2047) if greatest > 0 else 0)
        return missed

    def decode_errors(self, block, record, missed):
        """[Errors]"""
        coder, c, record.own, record.monotone = block.coder, self.c, [], []
        ghost = any(self.w in self.corners[t] for t in record.made)
        for i in range(self.codes):
            domain, own, last = i == self.governing, 0, block.last_own[i]
            place = ghost if domain else missed[i] > 0
            zero = block.own_zero[i] = coder.bit(c.own_zero + 4 * i + 2 * place + block.own_zero[i])
            if not zero:
                relation = 4 if domain else clamp((missed[i] - last + 256) // 16 - 12, 0, 7)
                own = block.last_own[i] = coder.near(c.own + (8 * i + relation) * 65, last)
                require(1 <= own <= 2047, "an own code")
            same = block.above_zero[i] = coder.bit(c.above_zero + 4 * i + 2 * zero + block.above_zero[i])
            record.own.append(own)
            record.monotone.append(own if same else own + coder.uint(c.above + 128 * i) + 1)
        require(max(record.monotone) <= 2047, "a monotone code")

    def decode_squared(self, block, record):
        """[Squared errors]"""
        coder, c, at, codes = block.coder, self.c, self.point(record.vertex), []
        stars = [[minus(self.point(x), at) for x in self.corners[t][1:]]
                 for t in record.made if self.w not in self.corners[t]]
        level = lambda x: pattern(x) >> 49 if x > 0 else 0
        size = level(total(abs(dot(cross(a, b), d)) for a, b, d in stars)) - level(self.volume) + 320
        for i in range(self.governing):
            none, sign, block.last_sign[i] = int(record.own[i] == 0), block.last_sign[i], 0
            codes.append(0)
            if not coder.bit(c.squared_zero + 4 * i + 2 * none + (sign == 0)):
                s = coder.bit(c.squared_negative + 6 * i + 3 * none + sign)
                drift, last, estimate = block.drift[i], block.last_code[i], record.own[i] + size
                expected = last[s] if none else clamp(estimate + truncated(drift[s], 16), 1, 2047)
                magnitude = coder.near(c.squared + (4 * i + 2 * none + s) * 65, expected)
                require(1 <= magnitude <= 2047, "a squared error")
                if none:
                    last[s] = magnitude
                else:
                    drift[s] += truncated(16 * clamp(magnitude - estimate, -4096, 4096) - drift[s], 8)
                block.last_sign[i], codes[i] = 1 + s, -magnitude if s else magnitude
        none, sign, block.last_sign[-1], i = int(record.own[-1] == 0), block.last_sign[-1], 0, self.governing
        if coder.bit(c.squared_zero + 4 * i + 2 * none + (sign == 0)):
            return [*codes, 0]
        u, lost = self.point(record.target), 0.0
        for t in record.made:
            for apex in [] if self.w in self.corners[t] else [at] if record.target in self.corners[t] else [at, u]:
                a, b, d = (minus(self.point(x), apex) for x in self.corners[t][1:])
                lost += (1 if apex is at else -1) * abs(dot(cross(a, b), d))
        grows = int(not lost > 0)
        s = coder.bit(c.squared_negative + 6 * i + 3 * none + 1 + grows)
        bits = self.record_count.bit_length()
        expected = clamp(level(abs(lost)) - level(6 * self.volume) + 65 + 8 * bits, 1, 512 + 8 * bits)
        magnitude = coder.near(c.squared + (4 * i + 2 * grows + s) * 65, expected)
        require(1 <= magnitude <= 512 + 8 * bits, "an uncovered volume")
        block.last_sign[-1] = 1 + s
        return [*codes, -magnitude if s else magnitude]

    def input_order(self):
        """[Input order]"""
        data, n, t = np.frombuffer(self.sections["input order"], np.uint8), self.w, self.tet_count
        numbers = lambda planes: np.cumsum(planes.reshape(4, -1).T.copy().view("<u4").ravel(), dtype=np.uint32)
        vertices, places, corners = numbers(data[:4 * n]), numbers(data[4 * n:4 * (n + t)]), data[4 * (n + t):]
        require(sorted(vertices) == list(range(n)) and sorted(places) == list(range(t))
                and max(corners, default=0) < 24, "the input order")
        ascending = sorted(sorted(int(vertices[x]) for x in tet) for tet in self.tets(self.records))
        orders, tets = list(itertools.permutations(range(4))), [None] * t
        for tet, place, order in zip(ascending, places, corners):
            tets[place] = [tet[k] for k in orders[order]]
        return vertices, tets

    def tets(self, applied):
        """The tets of the cut in which the records of this closed set are applied [Cuts]."""
        return [corners for corners, creator, consumer in zip(self.corners, self.creator, self.consumer)
                if self.w not in corners and (creator is None or creator in applied)
                and (consumer is None or consumer not in applied)]
