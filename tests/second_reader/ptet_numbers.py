"""The numbers of .ptet files, for the second reader: [Conventions], [The range coder] and [Numbers] of PTET.md."""
import functools
import math
import struct

POWERS = [float(10**e) for e in range(23)]
clamp = lambda value, least, most: min(max(value, least), most)
times_ten = lambda m, e: m * POWERS[e] if e >= 0 else m / POWERS[-e]


class Corrupt(Exception):
    """The file breaks a rule of PTET.md."""


def require(condition, what):
    if not condition:
        raise Corrupt(what)


class Bytes:
    """Takes numbers off its front [Conventions]."""

    def __init__(self, data):
        self.left = memoryview(data)

    def take(self, count):
        require(count <= len(self.left), "it ends too early")
        taken, self.left = self.left[:count], self.left[count:]
        return bytes(taken)

    def get(self, layout):
        return struct.unpack("<" + layout, self.take(struct.calcsize("<" + layout)))

    def varint(self, most=2**63 - 1):
        value = 0
        for place in range(9):
            byte, = self.take(1)
            value |= (byte & 127) << 7 * place
            if byte < 128:
                require(value <= most, "a number that is too large")
                return value
        raise Corrupt("a varint of more than 9 bytes")

    def text(self): return self.take(self.varint()).decode("utf-8", "surrogateescape")


class RangeDecoder:
    """[The range coder]"""

    def __init__(self, data, model):
        self.data, self.range = iter(data), 2**32 - 1
        self.code = functools.reduce(lambda code, _: code << 8 | next(self.data, 0), range(4), 0)
        self.p = [256 * b + 128 for b in model]

    def go_on(self, start, size):
        self.code, self.range = self.code - start, size
        while self.range < 1 << 24:
            self.range, self.code = self.range << 8, self.code << 8 | next(self.data, 0)

    def bit(self, context):
        p = self.p[context]
        bound = (self.range >> 12) * (p >> 4)
        one = int(self.code < bound)
        self.p[context] = p + (65535 - p >> 5) if one else p - (p >> 5)
        self.go_on(*((0, bound) if one else (bound, self.range - bound)))
        return one

    def raw(self, bits):
        if bits <= 0:
            return 0
        step, size = min(bits, 8), self.range >> min(bits, 8)
        digit = min(self.code // size, (1 << step) - 1)
        self.go_on(digit * size, size)
        return digit << (bits - step) | self.raw(bits - step)

    def tree(self, context, bits):
        node = 1
        for _ in range(bits):
            node = 2 * node + self.bit(context + node)
        return node - (1 << bits)

    def mantissa(self, context, n):
        if n < 2:
            return n
        value = 2 + self.bit(context + 3 * n)
        if n > 2:
            value = 2 * value + self.bit(context + 3 * n + value - 1)
        return value << max(n - 3, 0) | self.raw(n - 3)

    def signed(self, sign, context, n):
        """A mantissa behind its sign; none for 0."""
        return (-1 if n > 0 and self.bit(sign) else 1) * self.mantissa(context, n)

    def int(self, context):
        m = self.uint(context)
        return -m if m > 0 and self.bit(context + 128 + m.bit_length()) else m

    def uint(self, context): return self.mantissa(context + 32, self.tree(context, 5))

    def near(self, c, expected): return expected + self.signed(c + 64, c + 16, self.tree(c, 4))


class Column:
    """One axis, or one component of an array [Numbers]; `start` is its first context."""

    def __init__(self, kind, precision, start):
        self.scalar, self.unsigned, self.float = "<" + "bBhHiIqQfd"[kind], "<" + "BBHHIIQQIQ"[kind], kind > 7
        self.digits, self.zeros = (precision, 0) if precision < 64 else (0, precision - 64)
        self.bytes, self.low = struct.calcsize(self.scalar), 10**max(self.digits - 1, 0)
        self.mask, self.top, self.start = 256**self.bytes - 1, 256**self.bytes // 2, start
        most = (2 - 2.0**-23) * 2.0**127 if kind == 8 else (2 - 2.0**-52) * 2.0**1023
        self.limits = (-most, most) if self.float else (0, self.mask) if kind % 2 else (-self.top, self.top - 1)
        self.flips = (self.mask, self.top) if self.float else (0, 0) if kind % 2 else (self.top, self.top)
        self.width, self.depth = (64, 7) if self.bytes == 8 else (32, 6)
        self.length = start + 2 + 3 * (self.width + 1)
        self.end = self.length + (self.width // 2 + 1 << self.depth)

    # The pattern of the scalar.
    def bits(self, rank): return rank ^ self.flips[rank & self.top > 0]

    def value(self, rank):
        """As binary64."""
        return float(struct.unpack(self.scalar, struct.pack(self.unsigned, self.bits(rank)))[0])

    def rank(self, value):
        """The nearest rank."""
        value = 0.0 if value != value else value
        if not self.float:
            value = int(clamp(value - 0.5 if value < 0 else value + 0.5, -1e30, 1e30))
        bits, = struct.unpack(self.unsigned, struct.pack(self.scalar, clamp(value, *self.limits)))
        return bits ^ self.flips[bits & self.top == 0]

    def decimal_rank(self, value):
        """The nearest decimal rank."""
        a, low = abs(value), self.low
        if not a >= times_ten(low, -22) / 2:
            return 0
        e = next((e for e in range(-22, 22) if a < times_ten(10 * low, e)), 22)
        m = clamp(math.floor(clamp(times_ten(a, -e), 0, 1e15) + 0.5), low, 10 * low)
        rank = min((e + 22) * 9 * low + m - low + 1, 405 * low)
        return -rank if value < 0 else rank

    def difference(self, coder, spread):
        n = coder.tree(self.length + (min(spread.bit_length(), self.width) // 2 << self.depth), self.depth)
        require(n <= self.width, "a difference of too many bits")
        return coder.signed(self.start + 1, self.start + 2, n)

    def decode(self, coder, p, q):
        """scalar(column, p, q), as a rank."""
        escaped = self.digits + self.zeros > 0 and coder.bit(self.start)
        if self.digits == 0 or escaped:
            zeros = 0 if escaped else self.zeros
            origin, size = self.rank(p) >> zeros, self.mask + 1 >> zeros
            apart = ((self.rank(p + q) >> zeros) - origin) % size
            rank = (origin + self.difference(coder, min(apart, size - apart))) % size << zeros
            return rank | ((1 << zeros) - 1 if rank & self.top == 0 else 0)
        origin = self.decimal_rank(p)
        decimal = origin + self.difference(coder, abs(self.decimal_rank(p + q) - origin))
        decimal = (decimal + 2**63) % 2**64 - 2**63
        require(abs(decimal) <= 405 * self.low, "a decimal rank out of range")
        e, m = divmod(abs(decimal) - 1, 9 * self.low)
        value = times_ten(m + self.low, e - 22) if decimal else 0.0
        return self.rank(-value if decimal < 0 else value)
