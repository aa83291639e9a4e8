"""Draws a .ptet file in ParaView, cut open: coarse outside a focus box, the original inside.

    xvfb-run -a pvbatch tools/paraview/picture.py FILE.ptet -o PICTURE.png     (without xvfb-run where there is a display)

It is also an example of how a script uses the reader.
"""
import argparse
import decimal
import math
import pathlib
import sys

from paraview import simple

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
INK, EDGE, FOCUS = [0.13, 0.14, 0.16], [0.20, 0.20, 0.24], [0.00, 0.38, 0.75]
# Light to dark, of one hue family, so that the edges stay visible and a printed copy keeps the order.
SEQUENTIAL = [(0.00, 0.99, 0.97, 0.89), (0.20, 0.99, 0.87, 0.58), (0.40, 0.98, 0.69, 0.35), (0.60, 0.93, 0.46, 0.27),
              (0.80, 0.78, 0.25, 0.24), (1.00, 0.52, 0.10, 0.20)]


def numbers(count):
    def parse(text):
        values = [float(part) for part in text.split(",")]
        if len(values) != count:
            raise argparse.ArgumentTypeError(f"{count} numbers with commas between them")
        return values
    return parse


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", help="the .ptet file")
    parser.add_argument("-o", "--output", default="picture.png", help="default: picture.png")
    parser.add_argument("--plugin", help="default: the one that tools/paraview/build.sh made")
    parser.add_argument("--field", help="gives the colour; default: the first field")
    parser.add_argument("--range", type=numbers(2), metavar="LOW,HIGH", help="of the colours; default: of the field")
    parser.add_argument("--tets", type=int, default=0, help="at most so many, the focus excepted; default: as few as may be")
    parser.add_argument("--box", type=numbers(6), metavar="X0,Y0,Z0,X1,Y1,Z1",
                        help="the focus; default: a third of each length, in the middle")
    parser.add_argument("--normal", choices="xyz", default="y", help="of the cut through the middle of the box; default: y")
    parser.add_argument("--towards", type=numbers(3), metavar="X,Y,Z",
                        help="from the middle to the camera; default: along the normal, a little from the side and above")
    parser.add_argument("--zoom", type=float, default=1, help="default: 1")
    return parser.parse_args()


def scalar(grid, name):
    return grid.GetFieldData().GetAbstractArray(name).GetVariantValue(0)


def main():
    options = parse_arguments()
    plugin = options.plugin or next(map(str, ROOT.glob("build-paraview/plugin/**/ptet.so")), None)
    if not plugin:
        sys.exit("picture.py: no plugin; build it with tools/paraview/build.sh, or name it with --plugin")
    simple.LoadPlugin(plugin, ns=globals())
    simple._DisableFirstRenderCameraReset()
    reader = simple.OpenDataFile(options.file)
    reader.LimitTetrahedra = 1
    reader.Tetrahedra = options.tets
    reader.Focus = "Box"
    if options.box:
        reader.Position = options.box[:3]
        reader.Length = [high - low for low, high in zip(options.box[:3], options.box[3:])]
    else:  # the reader's own is half of each length, in the middle
        reader.Position = [low + length / 6 for low, length in zip(reader.Position, reader.Length)]
        reader.Length = [length * 2 / 3 for length in reader.Length]
    simple.UpdatePipeline(proxy=reader)
    grid = simple.servermanager.Fetch(reader)
    field = options.field or reader.PointArrays.Available[0]

    axis = "xyz".index(options.normal)
    low, length = list(reader.Position), list(reader.Length)
    middle = [a + b / 2 for a, b in zip(low, length)]
    # What lies away from the camera stays, and on the cut polygons where it meets tetrahedra, a little in front.
    away = [float(i == axis) * (1 if axis == 1 else -1) for i in range(3)]
    kept = simple.Clip(Input=reader, ClipType="Plane", Invert=0)
    kept.ClipType.Origin, kept.ClipType.Normal = middle, away
    cut = simple.Slice(Input=reader, SliceType="Plane", Triangulatetheslice=0)
    cut.SliceType.Origin, cut.SliceType.Normal = middle, away
    bounds = reader.GetDataInformation().GetBounds()
    step = 1e-3 * math.dist(bounds[::2], bounds[1::2])
    frame = simple.Box(XLength=length[0], YLength=length[1], ZLength=length[2], Center=middle)
    frame = simple.Clip(Input=frame, ClipType="Plane", Invert=0)
    frame.ClipType.Origin, frame.ClipType.Normal = middle, away

    view = simple.CreateRenderView(ViewSize=[1280, 800], UseColorPaletteForBackground=0, Background=[1, 1, 1],
                                   OrientationAxesVisibility=0)
    for part, in_front in ((kept, 0), (cut, 1)):
        shown = simple.Show(part, view)
        shown.SetRepresentationType("Surface With Edges")
        shown.EdgeColor, shown.LineWidth, shown.Interpolation = EDGE, 1, "Flat"
        shown.Ambient, shown.Diffuse = 0.6, 0.45
        shown.Position = [-in_front * step * a for a in away]
        simple.ColorBy(shown, ("POINTS", field))
    colours = simple.GetColorTransferFunction(field)
    array = reader.PointData[field]
    low_value, high_value = options.range or array.GetRange(-1 if array.GetNumberOfComponents() > 1 else 0)
    colours.RGBPoints = [number for at, *colour in SEQUENTIAL
                         for number in (low_value + at * (high_value - low_value), *colour)]
    colours.ColorSpace = "RGB"
    bar = simple.GetScalarBar(colours, view)
    for what in ("Title", "Label"):
        setattr(bar, what + "Color", INK)
        setattr(bar, what + "FontSize", 18)
    bar.Title, bar.ComponentTitle = field, ""
    bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, "%.3g", "%.3g"
    bar.Orientation, bar.WindowLocation = "Horizontal", "Any Location"
    bar.ScalarBarLength, bar.Position = 0.4, [0.3, 0.04]
    shown.SetScalarBarVisibility(view, True)
    simple.Hide(frame, view)
    edges = simple.FeatureEdges(Input=simple.ExtractSurface(Input=frame), BoundaryEdges=1)
    border = simple.Show(edges, view)
    border.Position = [-2 * step * a for a in away]
    border.AmbientColor = border.DiffuseColor = FOCUS
    border.LineWidth, border.Ambient, border.Diffuse = 4, 1, 0
    whole = simple.Show(simple.Outline(Input=reader), view)
    whole.AmbientColor = whole.DiffuseColor = [0.6, 0.6, 0.62]

    errors = [name for name in (grid.GetFieldData().GetArrayName(i) for i in range(grid.GetFieldData().GetNumberOfArrays()))
              if name.startswith("error of ")]
    lines = [f"{grid.GetNumberOfCells():,} of {scalar(grid, 'tets of the original').ToLong():,} tetrahedra, "
             "the original ones in the blue box"]
    up = decimal.Context(prec=3, rounding=decimal.ROUND_CEILING)
    lines += [f"{name}: at most {float(up.create_decimal(repr(scalar(grid, name).ToDouble()))):.3g}" for name in errors]
    text = simple.Show(simple.Text(Text="\n".join(lines)), view)
    text.Color, text.FontSize, text.Justification = INK, 20, "Left"
    text.WindowLocation = "Upper Left Corner"

    towards = options.towards or {"x": (1, -0.45, 0.35), "y": (0.3, -1, 0.38), "z": (0.25, -0.55, 1)}[options.normal]
    view.CameraViewUp = [0, 0, 1]
    centre = [(bounds[2 * i] + bounds[2 * i + 1]) / 2 for i in range(3)]
    view.CameraFocalPoint = centre
    view.CameraPosition = [a + b for a, b in zip(centre, towards)]
    simple.ResetCamera(view)
    simple.GetActiveCamera().Zoom(options.zoom)
    simple.SaveScreenshot(options.output, view, ImageResolution=view.ViewSize, TransparentBackground=0)
    print("\n".join(lines + [options.output]))


if __name__ == "__main__":
    main()
