"""The mesh that answers a request."""

from __future__ import annotations

import decimal
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core, _exchange

if TYPE_CHECKING:
    from ._dataset import DatasetInfo


@dataclass(frozen=True)
class PartErrors:
    """The largest errors among the tets and boundary faces of a part of the mesh.

    Attributes:
        field_error: by governing field, in its units.
        domain_error: mesh units.
    """

    field_error: dict[str, float]
    domain_error: float


@dataclass(frozen=True)
class BlockFailure:
    """A block of the file that could not be had.

    Attributes:
        block: row of the block table.
        offset: of the block in the file, bytes.
        retriable: reading failed, and later requests try again; else the block is damaged, and left out for good.
        message: what went wrong.
    """

    block: int
    offset: int
    retriable: bool
    message: str


class Extraction:
    """A conforming mesh out of a file, with the errors that it has.

    Arrays are read-only views of memory that the extraction owns: nothing is copied, and an array keeps the memory
    alive when extraction, dataset and file are gone. `array.copy()` gives one to write to.

    Attributes:
        points: (n, 3) of the original's type, mesh units.
        fields: by name (n,) or (n, components), of the original's types.
        tets: (m, 4) uint32, rows of `points`, positively oriented; as they were given where `input_order` was asked for.
        boundary_faces: (k, 3) uint32, rows of `points`, counter-clockwise seen from outside.
        vertex_ids: (n,) uint32: the vertices' numbers in the file, the same in every extraction.
        input_vertex: (n,) uint32: the vertices' rows in the mesh that the file was built from, ascending; None unless
            `input_order` was asked for.
        made_by: (m,) uint32: the record that made each tet, 0xFFFFFFFF when it is an original one, whose error is 0;
            None unless `origins` was asked for.
        errors_are_bounds: whether the file was built with evaluation "exact", as of DatasetInfo.
        field_error: by governing field the largest error, in its units. Where errors are bounds, no point that the mesh
            covers has a larger one.
        rms_error: by governing field the root mean square error over that part of the original domain which the mesh
            covers; empty when the build measured none.
        covered: so much of the original's volume the mesh covers at least, from 0 to 1; None when the build did not
            measure it. No bound where the original overlaps itself.
        domain_error: largest distance between the mesh's boundary and the original one, either way, mesh units.
        in_focus: PartErrors of what meets each focus region, with the boundary faces that may stand for a part of the
            original there.
        at_values: PartErrors of what may take each of the values of interest, with such faces.
        in_view: PartErrors of what the view sees, with such faces; None without a view.
        pixels_in_view: largest domain error in the picture, pixels; 0 without a view.
        limited_by: what kept the mesh from being finer: "nothing" (it is the original), "error", "focus", "budget",
            "time", "loading", "memory", "unreadable".
        complete: whether no block is missing. If not, the mesh is coarser there than was asked for. (Where "time" is
            what limited it, asking again may give more all the same.)
        failures: a BlockFailure each.
        bytes_read, read_requests: for the dataset so far, opening included.
        seconds: wall time of the call.
    """

    errors_are_bounds: bool
    points: npt.NDArray[Any]
    fields: dict[str, npt.NDArray[Any]]
    tets: npt.NDArray[np.uint32]
    boundary_faces: npt.NDArray[np.uint32]
    vertex_ids: npt.NDArray[np.uint32]
    input_vertex: npt.NDArray[np.uint32] | None
    made_by: npt.NDArray[np.uint32] | None
    field_error: dict[str, float]
    rms_error: dict[str, float]
    covered: float | None
    domain_error: float
    in_focus: list[PartErrors]
    at_values: list[PartErrors]
    in_view: PartErrors | None
    pixels_in_view: float
    limited_by: str
    complete: bool
    failures: list[BlockFailure]
    bytes_read: int
    read_requests: int
    seconds: float

    def __init__(self, core: _core.Extraction, info: DatasetInfo, origins: bool, input_order: bool = False) -> None:
        names = info.governing

        def part(errors: tuple[list[float], float]) -> PartErrors:
            return PartErrors(dict(zip(names, errors[0])), errors[1])

        self.errors_are_bounds = info.errors_are_bounds
        self.points = core.points
        self.fields = core.fields
        self.tets = core.tets
        self.boundary_faces = core.boundary_faces
        self.vertex_ids = core.vertex_ids
        self.input_vertex = core.input_vertex if input_order else None
        self.made_by = core.made_by if origins else None
        self.field_error = dict(zip(names, core.field_error))
        self.rms_error = dict(zip(names, core.rms_error))
        self.covered = core.covered
        self.domain_error = core.domain_error
        self.in_focus = [part(errors) for errors in core.in_focus]
        self.at_values = [part(errors) for errors in core.at_values]
        self.in_view = next((part(errors) for errors in core.in_view), None)
        self.pixels_in_view = core.pixels_in_view
        self.limited_by = core.limited_by
        self.complete = core.complete
        self.failures = [BlockFailure(*failure) for failure in core.failures]
        self.bytes_read = core.bytes_read
        self.read_requests = core.read_requests
        self.seconds = core.seconds

    def to_vtk(self) -> Any:
        """A vtkUnstructuredGrid of the tets with their fields, "vertex id" among the point arrays, and the errors as
        field data. Points and fields are shared, not copied; cells are copied. Needs VTK's Python modules."""
        return _exchange.to_vtk(self)

    def boundary_to_vtk(self) -> Any:
        """A vtkPolyData of the boundary faces, over the same points as to_vtk. Needs VTK's Python modules."""
        return _exchange.boundary_to_vtk(self)

    def to_meshio(self) -> Any:
        """A meshio.Mesh of the tets with their fields. Points and fields are shared. Needs meshio."""
        return _exchange.to_meshio(self)

    def __repr__(self) -> str:
        up = decimal.Context(prec=4, rounding=decimal.ROUND_CEILING)
        is_within = "within" if self.errors_are_bounds else "about"
        errors = ", ".join(f"{name} {is_within} {float(up.create_decimal(repr(error))):.4g}"
                           for name, error in self.field_error.items())
        return (f"<ptet.Extraction: {len(self.points)} vertices, {len(self.tets)} tets, "
                f"{errors + ', ' if errors else ''}limited by {self.limited_by}"
                f"{'' if self.complete else ', not complete'}>")
