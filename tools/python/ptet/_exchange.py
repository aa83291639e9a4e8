"""To and from the structures of VTK and meshio, which are imported when they are wanted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._errors import InputError

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


def from_vtk(grid: Any) -> MeshArrays:
    """points, tets and fields of a vtkUnstructuredGrid of tetrahedra, for `build(*...)`. Arrays are shared where they
    can be; cell fields, and arrays of no name, are left out.

    Raises:
        InputError: cells of another kind. vtkDataSetTriangleFilter splits them; so does the program `ptet build`,
        conformingly.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import VTK_TETRA
    kinds = vtk_to_numpy(grid.GetCellTypesArray()) if grid.GetNumberOfCells() else np.empty(0, np.uint8)
    if (kinds != VTK_TETRA).any():
        raise InputError(f"{int((kinds != VTK_TETRA).sum())} cells are no tetrahedra: split them, with "
                         "vtkDataSetTriangleFilter or by the program `ptet build`")
    points = vtk_to_numpy(grid.GetPoints().GetData()) if grid.GetPoints() else np.empty((0, 3), np.float32)
    tets = (vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4) if len(kinds)
            else np.empty((0, 4), np.int64))
    data = grid.GetPointData()
    arrays = [data.GetArray(i) for i in range(data.GetNumberOfArrays())]
    fields = {array.GetName(): vtk_to_numpy(array) for array in arrays if array is not None and array.GetName()}
    return points, tets, fields


def from_meshio(mesh: Any) -> MeshArrays:
    """points, tets and fields of a meshio.Mesh of tetrahedra, for `build(*...)`; cells of lower dimension and cell
    fields are left out.

    Raises:
        InputError: cells of another kind; the program `ptet build` splits them, conformingly.
    """
    kinds = {block.type for block in mesh.cells}
    others = kinds - {"tetra", "vertex", "line", "triangle", "quad"}
    if others:
        raise InputError(f"cells of type {', '.join(sorted(others))}: split them into tetrahedra first; the program "
                         "`ptet build` does")
    tets = [block.data for block in mesh.cells if block.type == "tetra"]
    corners = np.concatenate(tets) if tets else np.empty((0, 4), np.int64)
    return np.asarray(mesh.points), corners, dict(mesh.point_data)
