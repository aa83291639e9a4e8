#include "view_options.hpp"

#include "tools/view/keys.hpp"

namespace ptet::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  ptet view fire.ptet
  ptet view fire.ptet --error 2% --show cells --plane y:1.7 --colour t
  ptet view fire.ptet --error none --focus sphere:1,1,1,0.5 --show slice --split
  ptet view fire.ptet --show iso --isovalue t=320 --colour error
  ptet view fire.ptet --show cells --screenshot fire.png --size 1600x1000
  ptet view fire.ptet --camera eye=9,-40,20:at=0,0,5 --screenshot seen.png

Without a bound or a budget the error is 1%, or nothing is asked outside of a --focus. While blocks of the file are still
being read the mesh is coarser, and refines as they come.

--screenshot draws without a window, and where there is no display on one of its own (that takes Xvfb, Debian's package
xvfb). Nothing is written where a block of the file is damaged.

Planes: x, y or z, a sign before it for the side that is kept (+y:1.7 keeps what is below 1.7, -y:1.7 what is above; with
none it is the side that the first camera sees cut), a place after it (without: the middle); or nx,ny,nz,d: kept are the
points with n.x <= d.

Colours: a field (of vectors the length); error: of each tet by what was collapsed there, percent of the field's range, the
worst of all fields; level: 0 for original tets, n for those made when the mesh was down to between 1/2^(n-1) and 1/2^n
of its vertices. The last two read all of the file.

The mouse: left turns, middle moves, right (or the wheel) zooms; the focus is dragged by its handles or its surface.

Keys:
)";

} // namespace

void add_view_options(CLI::App& command, ViewArguments& arguments) {
  command.add_option("FILE", arguments.input, "the .ptet file")->required()->option_text(" ");
  command.add_option("--show", arguments.show, "surface, cells (cut open), slice, iso or volume (surface)")
      ->option_text("WHAT");
  command.add_option("--colour,--color", arguments.colour, "a field's name, error or level (the first field)")
      ->option_text("WHAT");
  command.add_option("--range", arguments.range, "of the colours (of the values seen so far)")->option_text("MIN..MAX");
  command
      .add_option("--error", arguments.error,
                  "largest error, of the fields' ranges and of the\nbounding-box diagonal; or none: nothing is asked")
      ->option_text("X%");
  command.add_option("--tets", arguments.tets, "at most so many tets")->option_text("N|N%");
  command.add_option("--vertices", arguments.vertices, "at most so many vertices")->option_text("N|N%");
  command
      .add_option("--focus", arguments.focus,
                  "box:..., sphere:..., obox:... or half:..., as for\nptet extract: the original inside")
      ->option_text("REGION");
  command.add_option("--plane", arguments.plane, "of slice and cells: x, y, z, with a place y:1.7, or\nnx,ny,nz,d (y)")
      ->option_text("PLANE");
  command.add_option("--isovalue", arguments.isovalue, "of the isosurface")->option_text("FIELD=V");
  command
      .add_option("--camera", arguments.camera,
                  "eye=x,y,z:at=x,y,z, and if need be :up=x,y,z\n:angle=DEGREES (all of it, from the front)")
      ->option_text("VIEW");
  command.add_option("--size", arguments.size, "of the window or picture, pixels (1280x800)")->option_text("WxH");
  command.add_option("--screenshot", arguments.screenshot, "write a picture and open no window")
      ->option_text("OUT.png");
  command.add_flag("--split", arguments.split, "the original beside it");
  command.add_flag("--no-edges", arguments.no_edges, "draw no edges");
  command.add_flag("--no-text", arguments.no_text, "write no captions");
  command.footer(kExamples + view::help_on_keys());
}

} // namespace ptet::cli
