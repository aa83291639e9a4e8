"""What callers pass as meshes, brought to the form that the library copies from."""

from __future__ import annotations

import operator
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import ArgumentError, InputError

Array = npt.NDArray[Any]

_TYPES = {np.dtype(name) for name in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8")}


def _as_array(given: npt.ArrayLike, what: str) -> Array:
    if isinstance(given, np.ma.MaskedArray) and np.ma.is_masked(given):  # type: ignore[no-untyped-call]
        raise ArgumentError(f"{what}: masked values have no meaning in a mesh; fill them, or leave the array out")
    try:
        return np.asarray(given)
    except ValueError as error:  # rows of different lengths
        raise ArgumentError(f"{what}: {error}") from None


def _plain(array: Array, what: str) -> Array:
    """Contiguous, in the machine's byte order; the values stay as they are."""
    native = array.dtype.newbyteorder("=")
    if native not in _TYPES:
        raise ArgumentError(f"{what}: numbers of type {array.dtype} cannot be kept; convert them to one of "
                            "int8 ... int64, uint8 ... uint64, float32, float64")
    return np.ascontiguousarray(array, dtype=native)


def as_points(given: npt.ArrayLike) -> Array:
    """n x 3, of one of the file's types."""
    array = _as_array(given, "points")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ArgumentError(f"points: an array of shape (n, 3) is wanted, not {array.shape}")
    return _plain(array, "points")


def as_tets(given: npt.ArrayLike, vertices: int) -> Array:
    """m x 4 of uint32, each below the number of vertices."""
    array = _as_array(given, "tets")
    if array.ndim != 2 or array.shape[1] != 4:
        raise ArgumentError(f"tets: an array of shape (m, 4) is wanted, not {array.shape}")
    if array.dtype.kind not in "iu":
        raise ArgumentError(f"tets: an array of whole numbers is wanted, not of {array.dtype}")
    if array.size and (int(array.min()) < 0 or int(array.max()) >= vertices):
        wrong = ((array < 0) | (array >= vertices)).any(axis=1)
        first = int(np.argmax(wrong))
        raise InputError(f"tets: {int(wrong.sum())} of them name vertices that are not there (0 to {vertices - 1}), "
                         f"the first is tet {first}: {array[first].tolist()}")
    return np.ascontiguousarray(array, dtype=np.uint32)


def as_callback(given: Any) -> Any:
    """None, or what can be called."""
    if given is not None and not callable(given):
        raise ArgumentError(f"progress {given!r}: it cannot be called")
    return given


def as_whole(given: Any, least: int, most: int, what: str, wanted: str = "") -> int:
    """A whole number in a range. `wanted`: what the range is in words."""
    try:
        number = least - 1 if isinstance(given, (bool, np.bool_)) else operator.index(given)
    except TypeError:
        number = least - 1
    if not least <= number <= most:
        raise ArgumentError(f"{what} {given!r}: {wanted or f'a whole number from {least} to {most}'} is wanted")
    return number


def as_text(given: str, what: str) -> str:
    """Text that a file can hold, as UTF-8."""
    if not isinstance(given, str):
        raise ArgumentError(f"{what} {given!r}: text (str) is wanted")
    try:
        given.encode()
    except UnicodeEncodeError as error:
        raise ArgumentError(f"{what} {given!r}: there is no such text in UTF-8 ({error.reason})") from None
    return given


def as_path(given: str | bytes | os.PathLike[str] | os.PathLike[bytes]) -> bytes:
    """As the system has it."""
    try:
        return os.fsencode(given)
    except TypeError:
        raise ArgumentError(f"{given!r}: a path is wanted") from None
    except UnicodeEncodeError as error:
        raise ArgumentError(f"{given!r}: there is no such name of a file ({error.reason})") from None


def as_fields(given: Mapping[str, npt.ArrayLike] | None, vertices: int) -> list[tuple[str, Array]]:
    """By name, (n,) or (n, components), each of one of the file's types."""
    fields: list[tuple[str, Array]] = []
    if given is None:
        return fields
    if not callable(getattr(given, "items", None)):
        raise ArgumentError(f"fields: arrays by their names are wanted (a dict), not {type(given).__name__}")
    for name, values in given.items():
        if not isinstance(name, str):
            raise ArgumentError(f"fields: {name!r} is no name; names are str")
        as_text(name, "fields: the name")
        what = f"field {name!r}"
        array = _as_array(values, what)
        if array.ndim not in (1, 2) or array.shape[0] != vertices or 0 in array.shape[1:]:
            raise ArgumentError(f"{what}: an array of shape ({vertices},) or ({vertices}, components) is wanted, "
                                f"not {array.shape}")
        fields.append((name, _plain(array, what)))
    return fields
