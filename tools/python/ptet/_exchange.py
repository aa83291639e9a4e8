"""To and from the structures of VTK and meshio, which are imported when they are wanted."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._errors import ArgumentError, InputError

if TYPE_CHECKING:
    from ._extraction import Extraction

MeshArrays = tuple["npt.NDArray[Any]", "npt.NDArray[Any]", dict[str, "npt.NDArray[Any]"]]
"""points, tets, fields, as `build` takes them."""

_VERTEX_ID = "vertex id"


def _shared(array: npt.NDArray[Any], name: str | None = None) -> Any:
    """A VTK array over the same memory, which it keeps alive."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    made = numpy_to_vtk(array)
    if name is not None:
        made.SetName(name)
    return made


def _cells(rows: npt.NDArray[np.uint32]) -> Any:
    """Copies: vtkCellArray keeps the memory that it is given, but not who owns it."""
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray
    count, corners = rows.shape
    offsets = np.arange(0, count * corners + 1, corners, dtype=np.int64)
    connectivity = rows.reshape(-1).astype(np.int64)
    cells = vtkCellArray()
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(connectivity, deep=True))
    return cells


def _fill(grid: Any, cut: Extraction) -> None:
    from vtkmodules.vtkCommonCore import vtkPoints
    points = vtkPoints()
    points.SetData(_shared(cut.points))
    grid.SetPoints(points)
    for name, values in cut.fields.items():
        grid.GetPointData().AddArray(_shared(values, name))
    if _VERTEX_ID not in cut.fields:
        grid.GetPointData().AddArray(_shared(cut.vertex_ids, _VERTEX_ID))
    errors = {f"error of {name}": error for name, error in cut.field_error.items()}
    errors.update({f"rms error of {name}": error for name, error in cut.rms_error.items()})
    errors["domain error"] = cut.domain_error
    if cut.covered is not None:
        errors["covered"] = cut.covered
    for name, error in errors.items():
        grid.GetFieldData().AddArray(_shared(np.array([error]), name))


def to_vtk(cut: Extraction) -> Any:
    """See Extraction.to_vtk."""
    from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkUnstructuredGrid
    grid = vtkUnstructuredGrid()
    _fill(grid, cut)
    grid.SetCells(VTK_TETRA, _cells(cut.tets))
    if cut.made_by is not None:
        grid.GetCellData().AddArray(_shared(cut.made_by, "made by"))
    return grid


def boundary_to_vtk(cut: Extraction) -> Any:
    """See Extraction.boundary_to_vtk."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    surface = vtkPolyData()
    _fill(surface, cut)
    surface.SetPolys(_cells(cut.boundary_faces))
    return surface


def to_meshio(cut: Extraction) -> Any:
    """See Extraction.to_meshio."""
    import meshio
    data = dict(cut.fields)
    data.setdefault(_VERTEX_ID, cut.vertex_ids)
    cells = {} if cut.made_by is None else {"made by": [cut.made_by]}
    return meshio.Mesh(cut.points, [("tetra", cut.tets.astype(np.int64))], point_data=data, cell_data=cells)


# Cells that stand for another piece's, for finer ones, or for nothing: vtkDataSetAttributes' DUPLICATECELL, REFINEDCELL
# and HIDDENCELL. `ptet build` leaves out the same ones.
_GHOST_CELL = 1 | 8 | 32
_GHOST_ARRAY = "vtkGhostType"


def _warn(message: str) -> None:
    """Of the function that called, to its caller."""
    warnings.warn(message, stacklevel=3)


def _ghost_message(count: int) -> str:
    return (f"{count} ghost {'cell is' if count == 1 else 'cells are'} left out ({_GHOST_ARRAY}: duplicate, refined or "
            "hidden)")


def _kept_rows(flags: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    rows: npt.NDArray[np.bool_] = (np.asarray(flags).astype(np.uint8).reshape(-1) & _GHOST_CELL) == 0
    return rows


def _vtk_array(array: Any) -> npt.NDArray[Any] | None:
    """Over the same memory; None of what holds no numbers that numpy could share, such as strings and bits."""
    from vtkmodules.util.numpy_support import get_vtk_to_numpy_typemap, vtk_to_numpy
    from vtkmodules.vtkCommonCore import VTK_BIT, vtkDataArray
    is_numeric = (isinstance(array, vtkDataArray) and array.GetDataType() != VTK_BIT
                  and array.GetDataType() in get_vtk_to_numpy_typemap() and array.GetNumberOfComponents() > 0)
    return vtk_to_numpy(array) if is_numeric else None


def _are_tets(kinds: npt.NDArray[Any], points: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """By cell: of VTK's kind, or linear ones of Lagrange's."""
    from vtkmodules.vtkCommonDataModel import VTK_LAGRANGE_TETRAHEDRON, VTK_TETRA
    tets: npt.NDArray[np.bool_] = (kinds == VTK_TETRA) | ((kinds == VTK_LAGRANGE_TETRAHEDRON) & (points == 4))
    return tets


def _are_volumes(kinds: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """By cell: of three dimensions, or of a kind that VTK does not know."""
    from vtkmodules.vtkCommonDataModel import vtkGenericCell
    cell = vtkGenericCell()
    volumes = []
    for kind in np.unique(kinds):
        cell.SetCellType(int(kind))
        is_known = cell.GetCellType() == kind
        if not is_known or cell.GetCellDimension() == 3:
            volumes.append(kind)
    return np.isin(kinds, volumes)


def from_vtk(grid: Any) -> MeshArrays:
    """points, tets and fields of a vtkUnstructuredGrid of tetrahedra, for `build(*...)`. Arrays are shared where they
    can be; cells of lower dimension, cell fields, and arrays of no name are left out. So are ghost cells (duplicate,
    refined or hidden), with a warning that says how many, and point arrays that are not numeric, with a warning that
    names them.

    Raises:
        ArgumentError: no vtkUnstructuredGrid.
        InputError: volume cells of another kind. The program `ptet build` splits them conformingly, and
            vtkDataSetTriangleFilter those of linear meshes.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
    if not isinstance(grid, vtkUnstructuredGrid):
        raise ArgumentError(f"a vtkUnstructuredGrid is wanted, not {type(grid).__name__}")
    points = vtk_to_numpy(grid.GetPoints().GetData()) if grid.GetPoints() else np.empty((0, 3), np.float32)
    tets = np.empty((0, 4), np.int64)
    if grid.GetNumberOfCells():
        kinds = vtk_to_numpy(grid.GetCellTypesArray())
        offsets = vtk_to_numpy(grid.GetCells().GetOffsetsArray())
        connectivity = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
        ghosts = grid.GetCellGhostArray()
        kept = np.ones(len(kinds), bool) if ghosts is None else _kept_rows(vtk_to_numpy(ghosts))
        wanted = kept & _are_tets(kinds, np.diff(offsets))
        others = int((kept & ~wanted & _are_volumes(kinds)).sum())
        if others:
            raise InputError(f"{others} cells are no tetrahedra: split them, by the program `ptet build` or with "
                             "vtkDataSetTriangleFilter")
        if wanted.all():
            tets = connectivity.reshape(-1, 4)
        else:
            tets = connectivity[offsets[:-1][wanted][:, None] + np.arange(4)]
        if not kept.all():
            _warn(_ghost_message(int((~kept).sum())))
    data = grid.GetPointData()
    fields = {}
    for i in range(data.GetNumberOfArrays()):
        array = data.GetAbstractArray(i)
        name = array.GetName()
        if not name or name == _GHOST_ARRAY:
            continue
        values = _vtk_array(array)
        if values is None:
            _warn(f"point array {name!r} is not numeric ({array.GetDataTypeAsString()}) and is left out")
        else:
            fields[name] = values
    return points, tets, fields


def from_meshio(mesh: Any) -> MeshArrays:
    """points, tets and fields of a meshio.Mesh of tetrahedra, for `build(*...)`; cells of lower dimension and cell
    fields are left out, and ghost cells as by from_vtk.

    Raises:
        InputError: cells of another kind; the program `ptet build` splits them, conformingly.
    """
    flags = mesh.cell_data.get(_GHOST_ARRAY)
    blocks, left_out = [], 0
    for i, block in enumerate(mesh.cells):
        kept = np.ones(len(block.data), bool) if flags is None else _kept_rows(flags[i])
        left_out += int((~kept).sum())
        if kept.all():
            blocks.append((block.type, block.data))
        elif kept.any():
            blocks.append((block.type, np.asarray(block.data)[kept]))
    others = {kind for kind, _ in blocks} - {"tetra", "vertex", "line", "triangle", "quad"}
    if others:
        raise InputError(f"cells of type {', '.join(sorted(others))}: split them into tetrahedra first; the program "
                         "`ptet build` does")
    if left_out:
        _warn(_ghost_message(left_out))
    tets = [rows for kind, rows in blocks if kind == "tetra"]
    corners = np.concatenate(tets) if tets else np.empty((0, 4), np.int64)
    fields = {name: values for name, values in mesh.point_data.items() if name != _GHOST_ARRAY}
    return np.asarray(mesh.points), corners, fields
