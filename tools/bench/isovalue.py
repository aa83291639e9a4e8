"""What an isovalue request costs and keeps: against the same error everywhere, and VTK's contour of either mesh.

Usage: isovalue.py --ptet build/ptet FIELD=V BOUND% FILE.ptet

Prints the tets of the answer and of the mesh with the same bound everywhere, and how far the field of the original is
from V on the contour of the answer, and the field of the answer from V on the contour of the original (at the points
of the contours that both meshes cover), as parts of the bound. Needs numpy and VTK's Python module.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataObject
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


def difference(points, mesh, field, value):
    """|field of the mesh - value| at the points that it covers; how many of all these are."""
    if points.GetNumberOfPoints() == 0:
        return numpy.zeros(0), 0
    probe = vtkProbeFilter()
    probe.SetInputData(points)
    probe.SetSourceData(mesh)
    probe.Update()
    found = probe.GetOutput().GetPointData()
    valid = vtk_to_numpy(found.GetArray("vtkValidPointMask")) > 0
    return numpy.abs(vtk_to_numpy(found.GetArray(field)).astype(float)[valid] - value), len(valid)


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
        found, count = difference(points, meshes[against], field, value)
        if len(found):
            print(f"  contour of the {name}: {len(found):,} of {count:,} points compared, difference at most "
                  f"{found.max() / allowed:.3f}, median {numpy.median(found) / allowed:.3f} of the bound; "
                  f"{int((found > allowed).sum())} above it")


if __name__ == "__main__":
    main()
