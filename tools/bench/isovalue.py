"""What an isovalue request costs and keeps: against the same error everywhere, and VTK's contour of either mesh.

Usage: isovalue.py --ptet build/ptet FIELD=V BOUND% FILE.ptet

Prints the tets of the answer and of the mesh with the same bound everywhere, and how far the field of the original is
from V on the contour of the answer, and the field of the answer from V on the contour of the original (at the points
of the contours that both meshes cover; where a mesh overlaps itself, as thin walls may, by that tet there which is
nearest), as parts of the bound. Needs numpy and VTK's Python module.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import reference, vtkIdList
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkStaticCellLocator
from vtkmodules.vtkFiltersCore import vtkContourFilter, vtkProbeFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def extract(ptet, file, *options):
    done = subprocess.run([ptet, "extract", file, "--json", *options], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def read(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def contour(mesh, field, value):
    filter_ = vtkContourFilter()
    filter_.SetInputData(mesh)
    filter_.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, field)
    filter_.SetValue(0, value)
    filter_.Update()
    return filter_.GetOutput()


def least_difference(point, mesh, locator, field, value):
    """The least of |field of a tet - value| over the tets that hold the point: of a mesh that overlaps itself several."""
    cells, closest, weights, inner, distance = vtkIdList(), [0.0] * 3, [0.0] * 4, [0.0] * 3, reference(0.0)
    size = 1e-6 * mesh.GetLength()
    locator.FindCellsWithinBounds([x + side * size for x in point for side in (-1, 1)], cells)
    values = mesh.GetPointData().GetArray(field)
    least = numpy.inf
    for i in range(cells.GetNumberOfIds()):
        cell = mesh.GetCell(cells.GetId(i))
        if cell.EvaluatePosition(point, closest, reference(0), inner, distance, weights) == 1:
            at_point = sum(w * values.GetTuple1(cell.GetPointId(k)) for k, w in enumerate(weights))
            least = min(least, abs(at_point - value))
    return least


def difference(points, mesh, field, value, allowed):
    """|field of the mesh - value| at the points that it covers; how many of all these are; how many of those that are
    above `allowed` by one tet are not by another one at the same point."""
    if points.GetNumberOfPoints() == 0:
        return numpy.zeros(0), 0, 0
    probe = vtkProbeFilter()
    probe.SetInputData(points)
    probe.SetSourceData(mesh)
    probe.ComputeToleranceOff()  # a point beside a thin wall is not to be sought behind it
    probe.SetTolerance(0)
    probe.Update()
    found = probe.GetOutput().GetPointData()
    valid = vtk_to_numpy(found.GetArray("vtkValidPointMask")) > 0
    result = numpy.abs(vtk_to_numpy(found.GetArray(field)).astype(float) - value)
    locator = vtkStaticCellLocator()
    locator.SetDataSet(mesh)
    twice = 0
    for row in numpy.flatnonzero(valid & (result > allowed)):
        least = least_difference(points.GetPoint(row), mesh, locator, field, value)
        twice += least <= allowed
        result[row] = min(result[row], least)
    return result[valid], len(valid), twice


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("isovalue", metavar="FIELD=V")
    parser.add_argument("bound", metavar="BOUND%")
    parser.add_argument("file", metavar="FILE.ptet")
    parser.add_argument("--ptet", default="build/ptet", help="the program (build/ptet)")
    arguments = parser.parse_args()
    field, value = arguments.isovalue.rsplit("=", 1)
    value = float(value)
    bound = f"{field}={arguments.bound}"
    with tempfile.TemporaryDirectory() as folder:
        paths = [str(pathlib.Path(folder) / name) for name in ["original.vtu", "answer.vtu"]]
        whole = extract(arguments.ptet, arguments.file, "-o", paths[0])
        answer = extract(arguments.ptet, arguments.file, "--field-error", bound, "--isovalue", arguments.isovalue, "-o",
                         paths[1])
        everywhere = extract(arguments.ptet, arguments.file, "--field-error", bound)
        meshes = [read(path) for path in paths]
    allowed = answer["asked"]["field_error"][field]
    stated = answer["achieved"]["at_values"][0]["field_error"][field]
    print(f"{pathlib.Path(arguments.file).stem} {arguments.isovalue} within {arguments.bound}: {answer['tets']:,} tets, "
          f"{answer['tets'] / everywhere['tets']:.1%} of the {everywhere['tets']:,} for that everywhere "
          f"({whole['tets']:,} in the original); stated there {stated / allowed:.3f} of the bound")
    for name, of, against in [("answer", 1, 0), ("original", 0, 1)]:
        points = contour(meshes[of], field, value)
        found, count, twice = difference(points, meshes[against], field, value, allowed)
        if len(found):
            print(f"  contour of the {name}: {len(found):,} of {count:,} points compared, difference at most "
                  f"{found.max() / allowed:.3f}, median {numpy.median(found) / allowed:.3f} of the bound; "
                  f"{int((found > allowed).sum())} above it"
                  + (f", {twice} where that mesh overlaps itself and only one of its tets is" if twice else ""))


if __name__ == "__main__":
    main()
