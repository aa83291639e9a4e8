"""Meshes for the examples: a file that is named, or one that is made up."""
import pathlib

import numpy as np

import ptet


def jet(n=20):
    """Temperature where a hot jet enters a channel: points, tets, fields. 2n x n x n cells of six tets."""
    nx, ny, nz = 2 * n, n, n
    index = np.stack(np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), np.arange(nz + 1), indexing="ij"), axis=-1)
    inner = ((index > 0) & (index < (nx, ny, nz))).reshape(-1, 3)
    jitter = np.random.default_rng(1).uniform(-0.18, 0.18, inner.shape)
    points = ((index.reshape(-1, 3) + jitter * inner) / n).astype(np.float32)
    number = np.arange(len(points)).reshape(nx + 1, ny + 1, nz + 1)
    tets = []
    for way in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (1, 0, 2), (0, 2, 1), (2, 1, 0)):
        corner, corners = np.zeros(3, int), []
        for axis in (None, *way):  # along the edges of a cell to its opposite corner
            if axis is not None:
                corner[axis] += 1
            x, y, z = corner
            corners.append(number[x:nx + x, y:ny + y, z:nz + z].ravel())
        tets.append(np.stack(corners, axis=1))
    x, y, z = points.T
    calm = 20 * np.sin(5 * x) * np.cos(4 * y) * np.sin(3 * z)
    path = 0.5 * np.sqrt(np.maximum(x - 0.3, 0))  # the jet is blown along x as it rises
    away = (y - 0.5) ** 2 + (z - path) ** 2
    begin = np.where(x > 0.3, 1, np.exp(-((x - 0.3) / 0.05) ** 2))
    temperature = 300 + calm + 400 * begin * np.exp(-away / (0.004 + 0.02 * x))
    return points, np.concatenate(tets), {"temperature": temperature.astype(np.float32)}


def read(path):
    """points, tets, fields of a VTU file, by VTK or else by meshio."""
    try:
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    except ImportError:
        import meshio
        return ptet.from_meshio(meshio.read(path))
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return ptet.from_vtk(reader.GetOutput())


def load(path, **options):
    """A Dataset: of a .ptet file, or of one that is built in memory from a VTU file or from the made-up mesh."""
    if path is not None and pathlib.Path(path).suffix == ".ptet":
        return ptet.open(path)
    mesh = jet() if path is None else read(path)
    if path is None:
        options = {"method": "QN", "evaluate": "exact"} | options  # quick
    built = ptet.build(*mesh, **options)
    print(built)
    return built.open()
