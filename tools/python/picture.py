#!/usr/bin/env python3
"""Draws tetrahedral meshes, cut open along a plane so that whole tetrahedra show, coloured by a point field.

    picture.py MESH.vtu [MESH.vtu ...] --field NAME -o picture.png

Several meshes are drawn side by side with one camera and one colour scale; what has no value (NaN) is grey. Opens no
window; without a display it draws on a virtual one (xvfb-run). Needs VTK's Python modules (Debian: python3-vtk9) and
NumPy.
"""

import argparse
import decimal
import json
import math
import os
import shutil
import sys

import numpy as np
import vtkmodules.vtkInteractionStyle  # noqa: F401  (registers factories)
import vtkmodules.vtkRenderingFreeType  # noqa: F401
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkDataObject
from vtkmodules.vtkFiltersCore import vtkCellCenters, vtkThreshold
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
from vtkmodules.vtkFiltersModeling import vtkOutlineFilter
from vtkmodules.vtkFiltersSources import vtkCubeSource
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkColorTransferFunction,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTextActor,
    vtkWindowToImageFilter,
)

INK = (0.13, 0.14, 0.16)
EDGE = (0.20, 0.20, 0.24)
FOCUS = (0.00, 0.38, 0.75)
NO_VALUE = (0.62, 0.64, 0.68)
# Light to dark, of one hue family, so that the edges stay visible and a printed copy keeps the order.
SEQUENTIAL = [
    (0.00, 0.99, 0.97, 0.89),
    (0.20, 0.99, 0.87, 0.58),
    (0.40, 0.98, 0.69, 0.35),
    (0.60, 0.93, 0.46, 0.27),
    (0.80, 0.78, 0.25, 0.24),
    (1.00, 0.52, 0.10, 0.20),
]


def fail(message):
    sys.exit(f"picture.py: {message}")


def numbers(text, count, what):
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        fail(f"{what} wants {count} numbers with commas between them, not '{text}'")
    return values


def read_mesh(path):
    if not os.path.isfile(path):
        fail(f"there is no file {path}")
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    if not reader.CanReadFile(path):
        fail(f"{path} is no VTU file")
    reader.Update()
    mesh = reader.GetOutput()
    if mesh.GetNumberOfCells() == 0:
        fail(f"{path} holds no cells")
    return mesh


def field_of(mesh, name, path):
    array = mesh.GetPointData().GetArray(name)
    if array is None:
        data = mesh.GetPointData()
        there = ", ".join(data.GetArrayName(i) for i in range(data.GetNumberOfArrays()))
        fail(f"{path} has no point array '{name}'; it has: {there or 'none'}")
    return array


def colour_map(low, high):
    colours = vtkColorTransferFunction()
    colours.SetNanColor(NO_VALUE)
    for at, red, green, blue in SEQUENTIAL:
        colours.AddRGBPoint(low + at * (high - low), red, green, blue)
    return colours


def cut_open(mesh, axis, at):
    """The whole tetrahedra whose centres lie behind the plane, seen from the camera."""
    if axis is None:
        return mesh
    centres = vtkCellCenters()
    centres.SetInputData(mesh)
    centres.Update()
    along = vtk_to_numpy(centres.GetOutput().GetPoints().GetData())[:, "xyz".index(axis)]
    behind = numpy_to_vtk((along >= at if axis == "y" else along <= at).astype(np.uint8), deep=True)
    behind.SetName("behind the plane")
    marked = mesh.NewInstance()
    marked.ShallowCopy(mesh)
    marked.GetCellData().AddArray(behind)
    keep = vtkThreshold()
    keep.SetInputData(marked)
    keep.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_CELLS, behind.GetName())
    keep.SetThresholdFunction(vtkThreshold.THRESHOLD_UPPER)
    keep.SetUpperThreshold(0.5)
    keep.Update()
    return keep.GetOutput()


def lines_actor(source, colour, width):
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetRepresentationToWireframe()
    actor.GetProperty().SetColor(colour)
    actor.GetProperty().SetLineWidth(width)
    actor.GetProperty().LightingOff()
    return actor


def mesh_actor(mesh, name, component, colours, edge_width):
    surface = vtkDataSetSurfaceFilter()
    surface.SetInputData(mesh)
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(surface.GetOutputPort())
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray(name)
    mapper.SetLookupTable(colours)
    if component > 1:
        colours.SetVectorModeToMagnitude()
    mapper.InterpolateScalarsBeforeMappingOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetInterpolationToFlat()
    look.SetAmbient(0.60)
    look.SetDiffuse(0.45)
    look.SetEdgeVisibility(True)
    look.SetEdgeColor(EDGE)
    look.SetLineWidth(edge_width)
    return actor


def text(content, size, x, y, bold=False):
    actor = vtkTextActor()
    actor.SetInput(content)
    actor.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    actor.SetPosition(x, y)
    look = actor.GetTextProperty()
    look.SetFontSize(size)
    look.SetColor(INK)
    look.SetBold(bold)
    look.SetVerticalJustificationToTop()
    return actor


def digits_between(low, high):
    """So many significant digits tell numbers apart that differ by a hundredth of the range."""
    largest, apart = max(abs(low), abs(high)), high - low
    return min(15, 4 + max(0, math.floor(math.log10(largest / apart)))) if largest > 0 and apart > 0 else 7


def scalar_bar(colours, has_gaps):
    bar = vtkScalarBarActor()
    bar.SetLookupTable(colours)
    digits = digits_between(*colours.GetRange())
    bar.SetNumberOfLabels(5 if digits < 6 else 3)
    bar.SetMaximumNumberOfColors(256)
    bar.SetLabelFormat(f"%.{digits}g")
    bar.SetDrawNanAnnotation(has_gaps)
    bar.SetOrientationToHorizontal()
    bar.GetPositionCoordinate().SetValue(0.25, 0.03)
    bar.SetWidth(0.5)
    bar.SetHeight(0.08)
    bar.UnconstrainedFontSizeOn()
    for look in (bar.GetLabelTextProperty(), bar.GetAnnotationTextProperty()):
        look.SetColor(INK)
        look.SetFontSize(14)
        look.SetBold(False)
        look.SetItalic(False)
        look.SetShadow(False)
    return bar


def count(number):
    return f"{number:,}".replace(",", " ")


def bound(error):
    """In four digits, and never below it."""
    up = decimal.Context(prec=4, rounding=decimal.ROUND_CEILING)
    return f"{float(up.create_decimal(repr(error))):.4g}"


def read_report(path, field):
    """A line on what was achieved, from what `ptet extract --json` printed."""
    try:
        with open(path, encoding="utf-8") as file:
            achieved = json.load(file)["achieved"]
        error = achieved["field_error"].get(field)
        domain = achieved["domain_error"]
    except (OSError, ValueError, KeyError) as problem:
        fail(f"{path} is no report of ptet extract --json: {problem!r}")
    about_field = f"field error of {field}: {bound(error)}, " if error is not None else ""
    return f"{about_field}domain error: {bound(domain)}"


def panel(whole, shown, title, report, field, colours, box, edge_width):
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    name, components = field
    renderer.AddActor(mesh_actor(shown, name, components, colours, edge_width))
    outline = vtkOutlineFilter()
    outline.SetInputData(whole)
    renderer.AddActor(lines_actor(outline, (0.6, 0.6, 0.62), 1.0))
    if box:
        cube = vtkCubeSource()
        cube.SetBounds(box[0], box[3], box[1], box[4], box[2], box[5])
        outline = vtkOutlineFilter()
        outline.SetInputConnection(cube.GetOutputPort())
        renderer.AddActor(lines_actor(outline, FOCUS, 3.0))
    tets = sum(1 for i in range(whole.GetNumberOfCells()) if whole.GetCellType(i) == VTK_TETRA)
    cells = f"{count(tets)} tetrahedra" if tets == whole.GetNumberOfCells() else f"{count(whole.GetNumberOfCells())} cells"
    renderer.AddViewProp(text(title, 22, 0.04, 0.975, bold=True))
    renderer.AddViewProp(text(f"{cells}, {count(whole.GetNumberOfPoints())} vertices", 17, 0.04, 0.925))
    if report:
        renderer.AddViewProp(text(report, 17, 0.04, 0.885))
    has_gaps = bool(np.isnan(vtk_to_numpy(whole.GetPointData().GetArray(name))).any())
    renderer.AddViewProp(scalar_bar(colours, has_gaps))
    bar_title = text(name, 16, 0.5, 0.145)
    bar_title.GetTextProperty().SetJustificationToCentered()
    renderer.AddViewProp(bar_title)
    return renderer


def place_camera(renderer, bounds, axis, zoom):
    centre = [(bounds[2 * i] + bounds[2 * i + 1]) / 2 for i in range(3)]
    # From the side that the plane takes away, a little from the right and from above (z is up).
    direction = {"x": (1.0, -0.45, 0.35), "y": (0.30, -1.0, 0.38), "z": (0.25, -0.55, 1.0), None: (0.5, -1.0, 0.5)}[axis]
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(centre)
    camera.SetPosition([c + d for c, d in zip(centre, direction)])
    camera.SetViewUp(0, 0, 1)
    camera.SetViewAngle(25)
    renderer.ResetCamera(bounds)
    camera.Zoom(zoom)
    renderer.ResetCameraClippingRange()
    camera.SetWindowCenter(0.0, -0.02)


def draw(panels, columns, bounds, axis, size, zoom, path):
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    rows = (len(panels) + columns - 1) // columns
    window.SetSize(size[0] * columns, size[1] * rows)
    for i, renderer in enumerate(panels):
        column, row = i % columns, rows - 1 - i // columns
        renderer.SetViewport(column / columns, row / rows, (column + 1) / columns, (row + 1) / rows)
        window.AddRenderer(renderer)
        place_camera(renderer, bounds, axis, zoom)
    if len(panels) < rows * columns:
        rest = vtkRenderer()
        rest.SetBackground(1, 1, 1)
        rest.SetViewport((len(panels) % columns) / columns, 0, 1, 1 / rows)
        window.AddRenderer(rest)
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    image.Update()
    writer = vtkPNGWriter()
    writer.SetFileName(path)
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()
    if not os.path.isfile(path):
        fail(f"could not write {path}")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="+", help="VTU files")
    parser.add_argument("-o", "--output", required=True, help="the PNG file to write")
    parser.add_argument("--field", required=True, help="point array that gives the colour (vectors: their length)")
    parser.add_argument("--title", action="append", default=[], help="one for each mesh, in order; default: file name")
    parser.add_argument("--report", action="append", default=[], help="output of ptet extract --json, in order; - for none")
    parser.add_argument("--clip", default="y", metavar="AXIS[:AT]", help="x, y or z, and where; or none (default: y)")
    parser.add_argument("--box", metavar="X0,Y0,Z0,X1,Y1,Z1", help="draw this box, such as a focus region")
    parser.add_argument("--box-on", type=int, action="append", metavar="N", help="only on mesh number N (from 1)")
    parser.add_argument("--range", metavar="LOW,HIGH", help="of the colours; default: of the field in the first mesh")
    parser.add_argument("--size", default="1200x720", metavar="WxH", help="pixels of one panel")
    parser.add_argument("--columns", type=int, help="panels in a row; default: all")
    parser.add_argument("--zoom", type=float, default=1.45, help="default: 1.45")
    return parser.parse_args()


def main():
    options = parse_arguments()
    if not options.output.lower().endswith(".png"):
        fail(f"-o wants a name that ends in .png, not '{options.output}'")
    if not os.environ.get("DISPLAY") and shutil.which("xvfb-run"):  # VTK draws on a display, or on a virtual one
        os.execvp("xvfb-run", ["xvfb-run", "-a", sys.executable, *sys.argv])
    if len(options.title) > len(options.mesh):
        fail("more titles than meshes")
    if len(options.report) > len(options.mesh):
        fail("more reports than meshes")
    titles = options.title + [os.path.basename(path) for path in options.mesh[len(options.title):]]
    meshes = [read_mesh(path) for path in options.mesh]
    arrays = [field_of(mesh, options.field, path) for mesh, path in zip(meshes, options.mesh)]
    reports = [read_report(path, options.field) if path != "-" else "" for path in options.report]
    reports += [""] * (len(meshes) - len(reports))
    components = arrays[0].GetNumberOfComponents()
    if options.range:
        low, high = numbers(options.range, 2, "--range")
        if not low < high:
            fail(f"--range wants LOW below HIGH, not '{options.range}'")
    else:
        low, high = arrays[0].GetRange(-1 if components > 1 else 0)
    box = numbers(options.box, 6, "--box") if options.box else None
    bounds = meshes[0].GetBounds()
    axis, _, at = options.clip.partition(":")
    if axis == "none":
        axis = None
    elif axis not in ("x", "y", "z"):
        fail(f"--clip wants x, y, z or none, not '{options.clip}'")
    if axis is not None:
        middle = meshes[0].GetCenter()["xyz".index(axis)]
        at = numbers(at, 1, "--clip")[0] if at else middle
    try:
        size = [int(part) for part in options.size.split("x")]
        width, height = size
    except ValueError:
        fail(f"--size wants a width and a height such as 1200x760, not '{options.size}'")

    panels = []
    for i, (mesh, title, report) in enumerate(zip(meshes, titles, reports)):
        shown = cut_open(mesh, axis, at)
        if shown.GetNumberOfCells() == 0:
            print(f"picture.py: note: nothing of {title} is behind {axis} = {at:g}", file=sys.stderr)
        fine = shown.GetNumberOfCells() > 20000
        box_here = box if not options.box_on or i + 1 in options.box_on else None
        colours = colour_map(low, high)
        field = (options.field, components)
        panels.append(panel(mesh, shown, title, report, field, colours, box_here, 0.6 if fine else 1.0))
    columns = min(max(options.columns or len(panels), 1), len(panels))
    draw(panels, columns, bounds, axis, (width, height), options.zoom, options.output)


if __name__ == "__main__":
    main()
