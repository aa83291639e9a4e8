"""Opened files."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Protocol, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import as_callback, as_path, as_whole
from ._errors import ArgumentError, FileError, FormatError, LimitError, MissingFileError, UnmetWarning
from ._extraction import Extraction
from ._request import Bound, Budget, ErrorBounds, Region, Values, View, as_list, make_request

if TYPE_CHECKING:
    from ._session import Session


class ByteSource(Protocol):
    """The bytes of a file, wherever they are: an HTTP server that knows ranges, an object store, an archive."""

    @property
    def size(self) -> int:
        """Bytes in all. A method `size()` will do as well."""

    def read(self, offset: int, size: int, /) -> bytes | bytearray | memoryview:
        """Exactly `size` bytes from `offset` on; what it raises becomes a FileError, or a BlockFailure. It is called
        from whatever thread reads, never from two at a time, and must not use the dataset itself. What may hang, as a
        connection does, has to have a time limit: the end of the process waits for a read that is under way."""


@dataclass(frozen=True)
class FieldInfo:
    """A field of a file.

    Attributes:
        name: as it was given to the build.
        dtype: of its numbers.
        components: how many numbers a vertex has.
        governing: its errors are in the file, and can be asked for.
        range: largest minus least value; for vectors the diagonal of the box of values. 0 where the field does not
            govern: the file does not tell.
    """

    name: str
    dtype: np.dtype[Any]
    components: int
    governing: bool
    range: float


@dataclass(frozen=True)
class DatasetInfo:
    """What a file holds.

    Attributes:
        vertices, tets: of the original.
        base_vertices, base_tets: of the coarsest mesh.
        records, blocks: vertex splits, and the blocks that they are stored in.
        file_bytes: size of the file.
        memory_for_all: max_bytes of open() with which all blocks fit into memory: an estimate, rather high.
        point_dtype: type of the coordinates.
        has_input_order: whether the file keeps the order of its input, see Dataset.extract.
        errors_are_bounds: whether nothing is further off than is stated; else errors are what the build has seen.
        overlaps_itself: whether some of the original's tets were found to lie in one another; errors there are those of
            each part by itself.
        fields: a FieldInfo each.
        box_min, box_max, diagonal: of the original's bounding box, mesh units.
        max_field_error: the largest of any level, by governing field, in its units.
        max_domain_error: the largest of any level, mesh units.
        base_rms_error: of the coarsest mesh, by governing field, in its units.
        base_covered: the part of the original's volume that the coarsest mesh covers, see Extraction.covered.
        provenance: what made the file, with which options, and from what.
    """

    vertices: int
    tets: int
    base_vertices: int
    base_tets: int
    records: int
    blocks: int
    file_bytes: int
    memory_for_all: int
    point_dtype: np.dtype[Any]
    has_input_order: bool
    errors_are_bounds: bool
    overlaps_itself: bool
    fields: list[FieldInfo]
    box_min: tuple[float, float, float]
    box_max: tuple[float, float, float]
    diagonal: float
    max_field_error: dict[str, float]
    max_domain_error: float
    base_rms_error: dict[str, float]
    base_covered: float | None
    provenance: dict[str, Any]

    @property
    def governing(self) -> list[str]:
        """Names of the governing fields."""
        return [field.name for field in self.fields if field.governing]

    def field(self, name: str) -> FieldInfo:
        """The field of that name; KeyError when there is none."""
        for field in self.fields:
            if field.name == name:
                return field
        raise KeyError(name)


def _described(core: _core.OpenFile) -> DatasetInfo:
    info = core.info
    info["fields"] = [FieldInfo(*field) for field in info["fields"]]
    info["provenance"] = json.loads(info.pop("provenance_json"))
    return DatasetInfo(**info)


class Dataset:
    """An opened file. Any number of threads may use it at a time. See `ptet.open`.

    Attributes:
        info: a DatasetInfo.
        salvage: whether damaged or unreadable blocks make answers coarser instead of raising.
    """

    def __init__(self, core: _core.OpenFile, salvage: bool) -> None:
        self._core = core
        self.info = _described(core)
        self.salvage = salvage

    def extract(self, *, error: ErrorBounds | None = None, domain_error: Bound | None = None,
                focus: Region | Iterable[Region] | None = None, values: Values | Iterable[Values] | None = None,
                view: View | None = None, budget: Budget | int | None = None, origins: bool = False,
                input_order: bool = False, progress: Optional[Callable[[str, int, int], Any]] = None) -> Extraction:
        """The mesh that answers a request: conforming, as coarse as what is asked allows. With nothing asked it is
        the original, bit for bit. Same request, same mesh, whatever was asked before.

        Args:
            error: largest field error, everywhere: field units or "2%" of the range; one for every governing field, or
                by name.
            domain_error: largest distance between the boundaries: mesh units, or "1%" of the diagonal.
            focus: Box, Sphere, OrientedBox, HalfSpace, one or several: the original (or what their `error` allows) in
                there, whatever else is asked.
            values: where given, bounds hold only where a field may take these; with no bound the tets there are
                original ones.
            view: what a camera sees is sharp to so many pixels. Outside the picture the bounds hold no more, but for
                its `outside`.
            budget: a Budget, or a number of tets; refining stops where it would be passed, after what keeps errors
                small.
            origins: fills Extraction.made_by, and states errors as tightly as they are known. Reads all of the file.
            input_order: vertices in the order of the mesh that the file was built from, and, where all of it is there,
                its tets and their corners, too, however oriented: what was given, byte for byte. Fills
                Extraction.input_vertex. Only of a file that keeps it: `build(keep_order=True)`.
            progress: called as of `build`; returning False, not 0 or None, raises Cancelled.

        Warns:
            UnmetWarning: a focus that no tet of the mesh meets, values that no point of it has, a view with nothing in
                it. Where the answer is incomplete, or ended by time or a budget, what is missing may have them: then only
                a focus or a view that is farther from the mesh than its domain error.

        Raises:
            ArgumentError (an unknown field, a bound that is negative or not finite, an empty region), Cancelled,
            MemoryError; and unless the dataset was opened with `salvage`, where blocks cannot be had: FormatError,
            FileError, LimitError (memory). Ctrl-C raises KeyboardInterrupt.
        """
        intervals: list[Values] = as_list(values, (Values,), "values")  # type: ignore[assignment]
        request = make_request(self.info.vertices, self.info.tets, error=error, domain_error=domain_error, focus=focus,
                               values=intervals, view=view, budget=budget, origins=origins)
        request.input_order = bool(input_order)
        core = self._core.extract(request, as_callback(progress))
        extraction = Extraction(core, self.info, origins, request.input_order)
        if not (extraction.complete or self.salvage):
            _raise_shortfall(extraction, self.info)
        self._warn_of_unmet(request, core, intervals)
        return extraction

    def _warn_of_unmet(self, request: _core.Request, core: _core.Extraction, wanted: list[Values]) -> None:
        focus, values, view = _core.unmet_wishes(request, core)
        if focus:
            warnings.warn(f"no tet of the mesh meets focus {_places(focus)}: the mesh is in the box "
                          f"{self.info.box_min} to {self.info.box_max}", UnmetWarning, stacklevel=3)
        if values:
            texts = ", ".join(_interval(wanted[i]) for i in values)
            warnings.warn(f"nothing of the mesh has the values asked for: {texts}", UnmetWarning, stacklevel=3)
        if view:
            warnings.warn(f"nothing of the mesh is in the view: the mesh is in the box {self.info.box_min} to "
                          f"{self.info.box_max}", UnmetWarning, stacklevel=3)

    def session(self) -> Session:
        """A mesh that follows its requests, beginning with the coarsest. See Session."""
        from ._session import Session
        return Session(self)

    def origin_values(self, made_by: npt.ArrayLike, what: str, field: str | None = None) -> npt.NDArray[np.float64]:
        """What the records that made tets say of them: (n,) for (n,) of Extraction.made_by or Session.made_by, 0 for
        original tets, NaN for records that are not in memory.

        Args:
            made_by: uint32, numbers of records.
            what: "field error" (largest among the tets that the record made, field units), "domain error" (likewise of
                the boundary faces, mesh units), "level" (n: a budget undoes the collapse when it has room for between
                1/2^n and 1/2^(n-1) of the vertices) or "generation" (how many splits must be made one after the other
                before the record's).
            field: the name of a governing field, for its error.

        Raises:
            ArgumentError.
        """
        if what not in ("field error", "domain error", "level", "generation"):
            raise ArgumentError(f"there is no origin value {what!r}")
        if what == "field error" and field not in self.info.governing:
            raise ArgumentError(f"there is no governing field {field!r}")
        place = self.info.governing.index(field) if what == "field error" and field is not None else 0
        records = np.asarray(made_by)
        if records.ndim != 1:
            raise ArgumentError(f"records by tet are wanted, not an array of shape {records.shape}")
        if records.size and (records.dtype.kind not in "iu" or int(records.min()) < 0 or int(records.max()) >= 2**32):
            raise ArgumentError("made_by: numbers of records are wanted, whole and from 0 to 0xFFFFFFFF")
        return self._core.origin_values(np.ascontiguousarray(records, np.uint32), what, place)

    def wait_until_loaded(self, *, progress: Optional[Callable[[str, int, int], Any]] = None) -> None:
        """Waits until the blocks that extractions asked for are there, or found not to be had; see `background` of
        `ptet.open`. Where the next extraction is still limited by "loading", wait and ask again."""
        self._core.wait_until_loaded(as_callback(progress))

    def __repr__(self) -> str:
        names = ", ".join(field.name for field in self.info.fields)
        return (f"<ptet.Dataset: {self.info.vertices} vertices, {self.info.tets} tets, "
                f"fields {names or 'none'}, {self.info.file_bytes} bytes>")


def _interval(values: Values) -> str:
    if values.max is None or values.max == values.min:
        return f"{values.field} = {values.min}"
    return f"{values.field} from {values.min} to {values.max}"


def _places(indices: list[int]) -> str:
    return ", ".join(str(i) for i in indices)


def _raise_shortfall(extraction: Extraction, info: DatasetInfo) -> None:
    """What cannot be had is an error; what is only not there yet is none."""
    what = "the mesh cannot be had in full: "
    hint = "; ptet.open(..., salvage=True) gives what is left, coarser"
    if extraction.limited_by == "unreadable" and extraction.failures:
        first = extraction.failures[0]
        others = len(extraction.failures) - 1
        blocks = f"block {first.block}" + (f" and {others} other{'s' if others > 1 else ''}" if others else "")
        kind = FileError if first.retriable else FormatError
        raise kind(f"{what}{blocks} failed, {first.message}{hint}", first.offset)
    if extraction.limited_by == "memory":
        raise LimitError(f"{what}its blocks do not fit the limit of memory; memory_limit, where one is set, and "
                         f"max_bytes of {info.memory_for_all} are enough for all of the file{hint}")


Source = Union[str, "os.PathLike[str]", "os.PathLike[bytes]", bytes, bytearray, memoryview, "npt.NDArray[Any]",
               ByteSource]


def _size_of(source: Any) -> int:
    size = source.size() if callable(source.size) else source.size
    return as_whole(size, 0, 2**63 - 1, "the source's size", "a number of bytes")


def _as_bytes(source: object) -> memoryview | None:
    """The memory of what has bytes; None of other objects."""
    try:
        return memoryview(source)  # type: ignore[arg-type]
    except TypeError:
        return None


def open(source: Source, *, memory_limit: int = 0, background: bool = False, max_gap: int = 0,
         max_bytes: int | None = None, max_vertices: int | None = None, max_tets: int | None = None,
         salvage: bool = False) -> Dataset:
    """Opens a .ptet file: reads header, provenance, block table and coarsest mesh; the rest is read as it is needed.

    Args:
        source: a path (str or os.PathLike); the file's bytes in memory (bytes, memoryview, uint8 array), which are read
            where they are; or an object with `read(offset, size)` and `size`, see ByteSource.
        memory_limit: bytes that decoded blocks may take; 0: as many as max_bytes leaves. A request whose own blocks
            would pass it raises LimitError, or with `salvage` is answered coarser.
        background: a thread reads and decodes; `extract` answers at once with what is there, limited by "loading". A
            forked process (multiprocessing) has no such thread, and must open the file anew.
        max_gap: blocks so many bytes or less apart are read at once; for a server far away some 500,000.
        max_bytes: memory for what opening holds for good and for decoded blocks; None: 32 GiB.
        max_vertices, max_tets: of the original; a file with more is refused.
        salvage: blocks that cannot be had make answers coarser instead of raising; Extraction.complete and failures
            tell. The errors stated are true in any case.

    Raises:
        FileError (MissingFileError where there is none), FormatError (a damaged header, table or coarsest mesh),
        LimitError, ArgumentError.
    """
    def count(value: int | None, what: str) -> int | None:
        return None if value is None else as_whole(value, 0, 2**64 - 1, what, "a whole number that is not negative")

    options = _core.OpenOptions(memory_limit=count(memory_limit, "memory_limit") or 0, background=bool(background),
                                max_gap=count(max_gap, "max_gap") or 0, max_bytes=count(max_bytes, "max_bytes"),
                                max_vertices=count(max_vertices, "max_vertices"), max_tets=count(max_tets, "max_tets"))
    if isinstance(source, (str, os.PathLike)):
        path = as_path(source)
        try:
            core = _core.open_path(path, options)
        except FileError as error:
            if os.path.exists(path):
                raise
            raise MissingFileError(str(error)) from None
        return Dataset(core, salvage)
    view = _as_bytes(source)
    if view is None:
        if not (callable(getattr(source, "read", None)) and hasattr(source, "size")):
            raise ArgumentError(f"{source!r} is neither a path nor bytes, nor has it read(offset, size) and size")
        return Dataset(_core.open_reader(source.read, _size_of(source), options), salvage)  # type: ignore[union-attr]
    if not view.c_contiguous:
        raise ArgumentError("the bytes are not contiguous")
    return Dataset(_core.open_buffer(view, options), salvage)
