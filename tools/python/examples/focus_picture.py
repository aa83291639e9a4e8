#!/usr/bin/env python3
"""A picture of a mesh that is the original inside a box and coarse outside, cut open through the box.

    focus_picture.py [MESH.vtu | FILE.ptet] [--field NAME] [--focus X0,Y0,Z0,X1,Y1,Z1] [-o focus.png]

Without a file a mesh is made up; without a box it is about the place where the field is largest. Without a display the
picture is drawn on a virtual one (xvfb-run).
"""
import argparse
import os
import shutil
import sys

import numpy as np
from example_mesh import load

import ptet

BLUE, INK, EDGE = (0.0, 0.38, 0.75), (0.13, 0.14, 0.16), (0.2, 0.2, 0.24)
LIGHT_TO_DARK = [(0.99, 0.97, 0.89), (0.99, 0.87, 0.58), (0.98, 0.69, 0.35), (0.93, 0.46, 0.27), (0.78, 0.25, 0.24),
                 (0.52, 0.10, 0.20)]


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?")
    parser.add_argument("--field", help="a governing one (default: the first)")
    parser.add_argument("--focus", help="corners of the box")
    parser.add_argument("--error", default="20%", help="largest error outside, of the field's range (default: 20%%)")
    parser.add_argument("--axis", choices="xyz", default="y", help="across which it is cut open (default: y)")
    parser.add_argument("--size", default="1400x800", help="of the picture (default: 1400x800)")
    parser.add_argument("-o", "--output", default="focus.png")
    return parser.parse_args()


def on_a_display():
    """VTK draws on a display; where there is none, this program starts again on a virtual one."""
    if not os.environ.get("DISPLAY") and shutil.which("xvfb-run"):
        os.execvp("xvfb-run", ["xvfb-run", "-a", sys.executable, *sys.argv])


def box_about_the_largest(data, field):
    """A quarter of the bounding box along each axis, about the place of the field's largest value."""
    mesh = data.extract(budget=ptet.Budget(vertices="20%"))
    values = mesh.fields[field]
    size = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
    least, most = np.array(data.info.box_min), np.array(data.info.box_max)
    half = (most - least) / 8
    centre = np.clip(mesh.points[np.argmax(size)], least + half, most - half)
    return ptet.Box(tuple(centre - half), tuple(centre + half))


def behind_plane(grid, axis, at):
    """The whole tets whose corners are not all in front of the plane."""
    from vtkmodules.vtkCommonDataModel import vtkPlane
    from vtkmodules.vtkFiltersExtraction import vtkExtractGeometry
    normal = [0, 0, 0]
    normal[axis] = -1 if axis == 1 else 1  # away from the camera's side
    plane = vtkPlane()
    plane.SetOrigin([at if i == axis else 0 for i in range(3)])
    plane.SetNormal(normal)
    extract = vtkExtractGeometry()
    extract.SetInputData(grid)
    extract.SetImplicitFunction(plane)
    extract.Update()
    return extract.GetOutput()


def draw(cut, field, box, axis, size, caption, path):
    import vtkmodules.vtkRenderingFreeType  # noqa: F401
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    from vtkmodules.vtkFiltersModeling import vtkOutlineFilter
    from vtkmodules.vtkFiltersSources import vtkCubeSource
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
    from vtkmodules.vtkRenderingCore import (vtkActor, vtkColorTransferFunction, vtkDataSetMapper, vtkPolyDataMapper,
                                             vtkRenderer, vtkRenderWindow, vtkTextActor, vtkWindowToImageFilter)
    grid = cut.to_vtk()
    array = grid.GetPointData().GetArray(field)
    low, high = array.GetRange(-1 if array.GetNumberOfComponents() > 1 else 0)
    colours = vtkColorTransferFunction()
    for i, colour in enumerate(LIGHT_TO_DARK):
        colours.AddRGBPoint(low + (high - low) * i / (len(LIGHT_TO_DARK) - 1), *colour)
    if array.GetNumberOfComponents() > 1:
        colours.SetVectorModeToMagnitude()

    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    mapper = vtkDataSetMapper()
    mapper.SetInputData(behind_plane(grid, axis, (box.min[axis] + box.max[axis]) / 2))
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray(field)
    mapper.SetLookupTable(colours)
    mapper.InterpolateScalarsBeforeMappingOn()
    tets = vtkActor()
    tets.SetMapper(mapper)
    tets.GetProperty().EdgeVisibilityOn()
    tets.GetProperty().SetEdgeColor(EDGE)
    tets.GetProperty().SetLineWidth(0.6)
    tets.GetProperty().SetAmbient(0.45)
    tets.GetProperty().SetDiffuse(0.55)
    renderer.AddActor(tets)

    cube, edges, frame = vtkCubeSource(), vtkPolyDataMapper(), vtkActor()
    cube.SetBounds([corner[i] for i in range(3) for corner in (box.min, box.max)])
    outline = vtkOutlineFilter()
    outline.SetInputConnection(cube.GetOutputPort())
    edges.SetInputConnection(outline.GetOutputPort())
    edges.SetResolveCoincidentTopologyToPolygonOffset()
    frame.SetMapper(edges)
    frame.GetProperty().SetColor(BLUE)
    frame.GetProperty().SetLineWidth(4)
    frame.GetProperty().LightingOff()
    renderer.AddActor(frame)

    bar = vtkScalarBarActor()
    bar.SetLookupTable(colours)
    bar.SetTitle(field)
    bar.SetPosition(0.9, 0.1)
    bar.SetWidth(0.07)
    bar.SetHeight(0.75)
    bar.UnconstrainedFontSizeOn()
    for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        text.SetColor(INK)
        text.SetFontSize(16)
        text.ItalicOff()
        text.ShadowOff()
    renderer.AddActor2D(bar)
    words = vtkTextActor()
    words.SetInput(caption)
    words.GetTextProperty().SetColor(INK)
    words.GetTextProperty().SetFontSize(19)
    words.GetTextProperty().SetVerticalJustificationToTop()
    words.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    words.SetPosition(0.02, 0.97)
    renderer.AddActor2D(words)

    camera = renderer.GetActiveCamera()
    middle = grid.GetCenter()
    camera.SetFocalPoint(middle)
    direction = [(1, -0.45, 0.35), (0.3, -1, 0.38), (0.25, -0.55, 1)][axis]
    camera.SetPosition([m + d for m, d in zip(middle, direction)])
    camera.SetViewUp(0, 0, 1)
    renderer.ResetCamera()
    camera.Zoom(1.4)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(size)
    window.AddRenderer(renderer)
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.SetInputConnection(image.GetOutputPort())
    writer.SetFileName(path)
    writer.Write()


def main():
    options = parse_arguments()
    on_a_display()
    data = load(options.file, govern=options.field)
    if not data.info.governing:
        sys.exit("no field of the file has errors: build it with one")
    field = options.field or data.info.governing[0]
    if options.focus:
        corners = [float(number) for number in options.focus.split(",")]
        box = ptet.Box(corners[:3], corners[3:])
    else:
        box = box_about_the_largest(data, field)
    cut = data.extract(focus=box, error={field: options.error}, origins=True)

    inside = cut.points[cut.tets].mean(axis=1)
    inside = ((inside >= box.min) & (inside <= box.max)).all(axis=1)
    assert (cut.made_by[inside] == 0xFFFFFFFF).all()  # original ones
    scale = data.info.field(field).range or 1
    caption = (f"{len(cut.tets):,} of {data.info.tets:,} tetrahedra\n"
               f"in the box: the original, {inside.sum():,} tetrahedra\n"
               f"elsewhere: {field} within {cut.field_error[field] / scale:.1%} of its range")
    print(caption)
    size = [int(number) for number in options.size.split("x")]
    draw(cut, field, box, "xyz".index(options.axis), size, caption, options.output)
    print(f"wrote {options.output}")


if __name__ == "__main__":
    main()
