"""What is asked of a file: bounds, focus regions, values of interest, a view, budgets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Union

import numpy as np

from . import _core
from ._arrays import as_text, as_whole
from ._errors import ArgumentError

Vector = Sequence[float]
"""Three numbers: a tuple, a list or an array."""

Bound = Union[float, str]
"""A number in the units of the field (of the mesh, for the domain), or a percentage such as "2%": of the field's range,
or of the diagonal of the bounding box."""

Count = Union[int, str]
"""A number of vertices or tets, or a percentage such as "5%" of the original's, rounded down."""


def parse_bound(bound: Bound, what: str) -> tuple[float, bool]:
    """The value, and whether it is relative."""
    relative = isinstance(bound, str) and bound.endswith("%")
    try:
        if isinstance(bound, (bool, np.bool_)):
            raise TypeError
        value = float(bound[:-1]) / 100 if isinstance(bound, str) and relative else float(bound)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{what} {bound!r}: a number is wanted, or a percentage such as '2%'") from None
    if not (math.isfinite(value) and value >= 0):
        raise ArgumentError(f"{what} {bound!r}: a finite number that is not negative is wanted")
    return value, relative


def parse_count(count: Count, total: int, what: str) -> int:
    """The count, given how many the original has."""
    if isinstance(count, str) and count.endswith("%"):
        share, _ = parse_bound(count, what)
        if share > 1:
            raise ArgumentError(f"{what} {count!r}: a percentage from 0% to 100% is wanted")
        return math.floor(share * total * (1 + 2**-51))  # 29% of 100 is 29
    return as_whole(count, 0, 2**63 - 1, what,
                    "a whole number that is not negative, or a percentage such as '5%',")


def _vector(values: Vector, what: str) -> list[float]:
    try:
        numbers = [] if isinstance(values, str) else [float(value) for value in values]
    except (TypeError, ValueError, OverflowError):
        numbers = []
    if len(numbers) != 3:
        raise ArgumentError(f"{what}: three numbers are wanted, not {values!r}")
    return numbers


def parse_number(value: float, what: str) -> float:
    """Any number; what it may be is for the library to say."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{what}: a number is wanted, not {value!r}") from None


def _as_tuples(value: object) -> object:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    return tuple(_as_tuples(one) for one in value) if isinstance(value, (list, tuple)) else value


class _Comparable:
    """Lists and arrays become tuples: two that ask for the same are equal, and can be keys."""

    def __post_init__(self) -> None:
        for name, value in list(vars(self).items()):
            object.__setattr__(self, name, _as_tuples(value))


@dataclass(frozen=True)
class Box(_Comparable):
    """A focus on an axis-parallel box, closed.

    Args:
        min, max: opposite corners, mesh units.
        error: largest error of the tets and boundary faces that meet the region, for every governing field, and up to
            the same fraction of the diagonal for the domain. 0: they are original ones, bit for bit.
        falloff: outside, the error allowed at a distance is error + falloff * distance / diagonal of the bounding box.
            None: nothing is asked outside.
    """

    min: Vector
    max: Vector
    error: Bound = 0.0
    falloff: Bound | None = None


@dataclass(frozen=True)
class OrientedBox(_Comparable):
    """A focus on a box in any position, closed: centre + a x + b y + c z with -1 <= a, b, c <= 1.

    Args:
        centre: mesh units.
        half_axes: x, y, z, from the centre to the middle of a side, mutually perpendicular; 3 x 3, mesh units.
        error, falloff: as of Box.
    """

    centre: Vector
    half_axes: Sequence[Vector]
    error: Bound = 0.0
    falloff: Bound | None = None


@dataclass(frozen=True)
class Sphere(_Comparable):
    """A focus on a ball, closed.

    Args:
        centre, radius: mesh units.
        error, falloff: as of Box.
    """

    centre: Vector
    radius: float
    error: Bound = 0.0
    falloff: Bound | None = None


@dataclass(frozen=True)
class HalfSpace(_Comparable):
    """A focus on the points x with dot(normal, x) <= offset.

    Args:
        normal: of any length but 0; points out of the half space.
        offset: mesh units times the normal's length.
        error, falloff: as of Box.
    """

    normal: Vector
    offset: float
    error: Bound = 0.0
    falloff: Bound | None = None


Region = Union[Box, OrientedBox, Sphere, HalfSpace]


@dataclass(frozen=True)
class Values:
    """Refine only where a field may take values in [min, max].

    Args:
        field: a governing one; of vectors the Euclidean length counts.
        min, max: field units; max None: an isovalue, max = min.
    """

    field: str
    min: float
    max: float | None = None


@dataclass(frozen=True)
class View(_Comparable):
    """What a camera sees, in perspective.

    Args:
        eye: mesh units.
        direction: of any length but 0.
        up: not parallel to the direction.
        vertical_angle: of the whole picture, radians, below pi (30 degrees).
        width, height: of the picture, pixels.
        max_pixels: largest domain error as seen from the eye, pixels.
        outside: what cannot be seen may have so many times the errors, those by bounds, too, >= 1; infinity: nothing is
            asked there.
    """

    eye: Vector
    direction: Vector = (0.0, 0.0, -1.0)
    up: Vector = (0.0, 1.0, 0.0)
    vertical_angle: float = math.pi / 6
    width: int = 1920
    height: int = 1080
    max_pixels: float = 1.0
    outside: float = math.inf


@dataclass(frozen=True)
class Budget:
    """How much the answer may cost. What is asked is refined in an order that the file has, which keeps small what it
    was built for, up to the first that does not fit; what focus regions need inside is there in any case.

    Args:
        tets, vertices: how many at most; a number, or a percentage of the original's.
        bytes: of the answer: points, fields, tets (16 each) and boundary faces (12 each).
        milliseconds: about how long the call may refine. The answer then depends on the machine. `origins` of an
            extraction read all of the file, however long that takes.
    """

    tets: Count | None = None
    vertices: Count | None = None
    bytes: int | None = None
    milliseconds: float | None = None


ErrorBounds = Union[Bound, Mapping[str, Bound]]
"""One bound for every governing field, or one for each of some."""


def as_list(given: object, kinds: tuple[type, ...], what: str) -> list[object]:
    """One of these kinds, or several."""
    if given is None:
        return []
    if isinstance(given, kinds) or isinstance(given, (str, bytes)) or not isinstance(given, Iterable):
        several = [given]
    else:
        several = list(given)
    for one in several:
        if not isinstance(one, kinds):
            names = ", ".join(kind.__name__ for kind in kinds)
            raise ArgumentError(f"{what}: one or several of {names} are wanted, not {one!r}")
    return several


def parse_field_bounds(bounds: ErrorBounds | None, what: str) -> list[tuple[str, tuple[float, bool]]]:
    """By field; an empty name is for every governing one."""
    if bounds is None:
        return []
    if not isinstance(bounds, Mapping):
        return [("", parse_bound(bounds, what))]
    for name in bounds:
        if not isinstance(name, str) or not name:
            raise ArgumentError(f"{what}: {name!r} is no name of a field")
        as_text(name, f"{what}: the name")
    return [(name, parse_bound(bound, f"{what} of {name!r}")) for name, bound in bounds.items()]


def _add_region(request: _core.Request, region: Region) -> None:
    error = parse_bound(region.error, "error of a focus")
    falloff = None if region.falloff is None else parse_bound(region.falloff, "falloff of a focus")
    if isinstance(region, Box):
        request.add_box(_vector(region.min, "min of a Box"), _vector(region.max, "max of a Box"), error, falloff)
    elif isinstance(region, OrientedBox):
        if not isinstance(region.half_axes, Iterable):
            raise ArgumentError(f"half_axes of an OrientedBox: three are wanted, not {region.half_axes!r}")
        axes = [_vector(axis, "half axis of an OrientedBox") for axis in region.half_axes]
        if len(axes) != 3:
            raise ArgumentError(f"half_axes of an OrientedBox: three are wanted, not {len(axes)}")
        request.add_oriented_box(_vector(region.centre, "centre of an OrientedBox"), axes, error, falloff)
    elif isinstance(region, Sphere):
        radius = parse_number(region.radius, "radius of a Sphere")
        request.add_sphere(_vector(region.centre, "centre of a Sphere"), radius, error, falloff)
    else:
        offset = parse_number(region.offset, "offset of a HalfSpace")
        request.add_half_space(_vector(region.normal, "normal of a HalfSpace"), offset, error, falloff)


def _set_view(request: _core.Request, view: View) -> None:
    if not isinstance(view, View):
        raise ArgumentError(f"view: one View is wanted, not {view!r}")

    def pixels(value: int, what: str) -> int:
        return as_whole(value, 1, 2**32 - 1, what)

    request.set_view(_vector(view.eye, "eye of a View"), _vector(view.direction, "direction of a View"),
                     _vector(view.up, "up of a View"), parse_number(view.vertical_angle, "vertical_angle of a View"),
                     pixels(view.width, "width of a View"), pixels(view.height, "height of a View"),
                     parse_number(view.max_pixels, "max_pixels of a View"),
                     parse_number(view.outside, "outside of a View"))


def _set_budget(request: _core.Request, budget: Budget | int, vertices: int, tets: int) -> None:
    if not isinstance(budget, Budget):
        budget = Budget(tets=budget)
    if budget.tets is not None:
        request.max_tets = parse_count(budget.tets, tets, "tets of a Budget")
    if budget.vertices is not None:
        request.max_vertices = parse_count(budget.vertices, vertices, "vertices of a Budget")
    if budget.bytes is not None:
        request.max_bytes = as_whole(budget.bytes, 0, 2**63 - 1, "bytes of a Budget")
    if budget.milliseconds is not None:
        request.max_milliseconds = parse_number(budget.milliseconds, "milliseconds of a Budget")
        if not math.isfinite(request.max_milliseconds):
            raise ArgumentError(f"the time allowed is {request.max_milliseconds} milliseconds; it must be finite and "
                                "not negative")


def make_request(vertices: int, tets: int, *, error: ErrorBounds | None, domain_error: Bound | None,
                 focus: Region | Iterable[Region] | None, values: Values | Iterable[Values] | None, view: View | None,
                 budget: Budget | int | None, origins: bool = False) -> _core.Request:
    """The request in the library's terms, for a file with so many vertices and tets."""
    request = _core.Request()
    for name, bound in parse_field_bounds(error, "error"):
        request.add_field_error(name, bound)
    if domain_error is not None:
        request.set_domain_error(parse_bound(domain_error, "domain_error"))
    for region in as_list(focus, (Box, OrientedBox, Sphere, HalfSpace), "focus"):
        _add_region(request, region)  # type: ignore[arg-type]
    for wanted in as_list(values, (Values,), "values"):
        assert isinstance(wanted, Values)
        least = parse_number(wanted.min, "min of Values")
        as_text(wanted.field, "field of Values")
        greatest = least if wanted.max is None else parse_number(wanted.max, "max of Values")
        request.add_values(wanted.field, least, greatest)
    if view is not None:
        _set_view(request, view)
    if budget is not None:
        _set_budget(request, budget, vertices, tets)
    request.origins = bool(origins)
    return request
