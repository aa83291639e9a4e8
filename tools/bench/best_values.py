#!/usr/bin/env python3
"""What better values at the same vertices would bring: the root mean square error of cuts with the values of the original
at their vertices, as ptet gives them, and with those that make the mean square least.

Usage: best_values.py --ptet build/ptet FIELD MESH.vtu FILE.ptet

For cuts of 50, 20, 10, 5 and 2% of the tets it prints both errors, RMS and greatest, as `ptet measure` finds them, and
their ratios. The best values are found by least squares over four points of each original tet (exact for squares of
linear functions where a tet lies in one of the cut's). Needs numpy and VTK's Python module.
"""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile

import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkGenericCell, vtkStaticCellLocator
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter

PERCENT = [50, 20, 10, 5, 2]
NEAR, FAR = 0.1381966011250105, 0.5854101966249685  # Keast's rule of degree 2


def read(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def tets_of(mesh):
    return vtk_to_numpy(mesh.GetCells().GetConnectivityArray()).reshape(-1, 4)


def samples(mesh, field):
    """Points, values and weights: four in each tet."""
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    values = vtk_to_numpy(mesh.GetPointData().GetArray(field)).astype(float)
    tets = tets_of(mesh)
    at = points[tets]
    volume = abs(numpy.linalg.det(at[:, 1:] - at[:, :1])) / 6
    rule = NEAR + (FAR - NEAR) * numpy.eye(4)
    where = numpy.concatenate([(row[None, :, None] * at).sum(axis=1) for row in rule])
    return where, numpy.concatenate([values[tets] @ row for row in rule]), numpy.tile(volume / 4, 4)


def shape_functions(mesh, points):
    """The tet of the mesh that holds each point (-1: none), and the weights of its corners."""
    locator, cell, weights = vtkStaticCellLocator(), vtkGenericCell(), [0.0] * 4
    locator.SetDataSet(mesh)
    locator.BuildLocator()
    inner, tet, weight = [0.0] * 3, numpy.full(len(points), -1), numpy.zeros((len(points), 4))
    for i, p in enumerate(points.tolist()):
        tet[i] = locator.FindCell(p, 0.0, cell, inner, weights)
        weight[i] = weights
    return tet, weight


def best_values(mesh, field, points, values, weights):
    """By conjugate gradients on the normal equations, from the values that are there."""
    tet, shape = shape_functions(mesh, points)
    inside = tet >= 0
    corners, shape = tets_of(mesh)[tet[inside]], shape[inside]
    wanted, weight = values[inside], weights[inside]
    x = vtk_to_numpy(mesh.GetPointData().GetArray(field)).astype(float)

    def gather(residual):
        return numpy.bincount(corners.ravel(), (shape * (weight * residual)[:, None]).ravel(), len(x))

    def apply(y):
        return gather((shape * y[corners]).sum(axis=1))

    scale = numpy.bincount(corners.ravel(), (shape * shape * weight[:, None]).ravel(), len(x))
    scale[scale == 0] = 1
    residual = gather(wanted) - apply(x)
    step = residual / scale
    along, product = step, residual @ step
    first = product
    for _ in range(300):
        if product <= 1e-16 * first or product == 0:
            break
        image = apply(along)
        length = product / (along @ image)
        x, residual = x + length * along, residual - length * image
        step = residual / scale
        product, before = residual @ step, product
        along = step + product / before * along
    return x


def measured(ptet, original, simplified, field):
    done = subprocess.run([ptet, "measure", original, simplified, "--field", field, "--json"], stdout=subprocess.PIPE,
                          check=True)
    inside = json.loads(done.stdout)["inside"]["fields"][field]
    return inside["max"], inside["rms"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ptet", default="build/ptet", help="the program")
    parser.add_argument("field")
    parser.add_argument("mesh")
    parser.add_argument("file")
    options = parser.parse_args()
    original = read(options.mesh)
    points, values, weights = samples(original, options.field)
    spread = numpy.ptp(vtk_to_numpy(original.GetPointData().GetArray(options.field)).astype(float))
    ratios = []
    print("tets, %    RMS, %: as they are / best   ratio    greatest, %: as they are / best   ratio")
    with tempfile.TemporaryDirectory() as folder:
        cut = str(pathlib.Path(folder) / "cut.vtu")
        for percent in PERCENT:
            subprocess.run([options.ptet, "extract", options.file, "-o", cut, "--tets", f"{percent}%", "--json"], stdout=subprocess.DEVNULL,
                           check=True)
            most, rms = measured(options.ptet, options.mesh, cut, options.field)
            mesh = read(cut)
            best = best_values(mesh, options.field, points, values, weights)
            array = numpy_to_vtk(best, deep=1)
            array.SetName(options.field)
            mesh.GetPointData().AddArray(array)
            writer = vtkXMLUnstructuredGridWriter()
            writer.SetFileName(cut)
            writer.SetInputData(mesh)
            writer.Write()
            best_most, best_rms = measured(options.ptet, options.mesh, cut, options.field)
            ratios.append((math.log(best_rms / rms), math.log(best_most / most)))
            print(f"{percent:7d}    {100 * rms / spread:10.4f} {100 * best_rms / spread:10.4f} {best_rms / rms:8.3f}"
                  f"    {100 * most / spread:14.3f} {100 * best_most / spread:10.3f} {best_most / most:8.3f}", flush=True)
    print("geometric means of the ratios: RMS %.3f, greatest %.3f" % tuple(math.exp(sum(x) / len(x)) for x in zip(*ratios)))


if __name__ == "__main__":
    main()
