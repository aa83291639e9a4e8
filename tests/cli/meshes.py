"""Small meshes as VTU text, so that each test shows what it feeds to the program."""
import itertools

TRIANGLE, TETRA = 5, 10


def vtu(path, points, cells, fields=None, cell_type=TETRA, precision="Float64"):
    """Writes an ASCII VTU. fields: name -> (VTK type, one value per point, or one tuple)."""

    def array(name, vtk_type, rows):
        rows = [row if isinstance(row, (tuple, list)) else (row,) for row in rows]
        components = len(rows[0]) if rows else 1
        text = "\n".join(" ".join(map(repr, row)) for row in rows)
        return (f'<DataArray type="{vtk_type}" Name="{name}" NumberOfComponents="{components}" format="ascii">\n'
                f'{text}\n</DataArray>\n')

    offsets = list(itertools.accumulate(map(len, cells)))
    with open(path, "w", encoding="ascii") as file:
        file.write('<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">\n<UnstructuredGrid>\n'
                   f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}">\n<PointData>\n')
        for name, (vtk_type, rows) in (fields or {}).items():
            file.write(array(name, vtk_type, rows))
        file.write("</PointData>\n<Points>\n" + (array("Points", precision, points) if points else
                   '<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="ascii"></DataArray>\n'))
        file.write("</Points>\n<Cells>\n" + array("connectivity", "Int64", cells).replace(
            'NumberOfComponents="4"', "").replace('NumberOfComponents="3"', ""))
        file.write(array("offsets", "Int64", offsets) + array("types", "UInt8", [cell_type] * len(cells)))
        file.write("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")
    return path


def grid(n, origin=(0.0, 0.0, 0.0)):
    """A cube of n x n x n cells, each cut into the six tets of Kuhn's triangulation: points and tets."""
    points = [tuple(origin[axis] + index[axis] / n for axis in range(3))
              for index in itertools.product(range(n + 1), repeat=3)]
    stride = ((n + 1) ** 2, n + 1, 1)
    tets = []
    for cell in itertools.product(range(n), repeat=3):
        corner = sum(c * s for c, s in zip(cell, stride))
        for order in itertools.permutations(range(3)):
            tet = [corner]
            for axis in order:
                tet.append(tet[-1] + stride[axis])
            if order in ((1, 0, 2), (0, 2, 1), (2, 1, 0)):  # an odd permutation mirrors
                tet[2], tet[3] = tet[3], tet[2]
            tets.append(tet)
    return points, tets


def wave(points):
    """A smooth field and a bumpy one."""
    return {"smooth": ("Float64", [x + 2 * y - z for x, y, z in points]),
            "bumpy": ("Float32", [(x * 3.7) % 1 * y + (z - 0.4) ** 2 for x, y, z in points])}


SINGLE_TET = ([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)], [[0, 1, 2, 3]])


def read_vtu(path):
    """By VTK: positions, point arrays by name, tets, all with their types."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    data = grid.GetPointData()
    arrays = {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
    cells = grid.GetCells()
    return (vtk_to_numpy(grid.GetPoints().GetData()), arrays,
            vtk_to_numpy(cells.GetConnectivityArray()).reshape(-1, 4))
