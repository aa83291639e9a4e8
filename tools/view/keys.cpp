#include "keys.hpp"

#include <algorithm>
#include <array>

namespace ptet::view {
namespace {

constexpr std::array<Key, 23> kKeys = {{
    {"1", "1", Command::kSurface, "boundary surface"},
    {"2", "2", Command::kCells, "cells, cut open along the plane"},
    {"3", "3", Command::kSlice, "slice"},
    {"4", "4", Command::kIsosurface, "isosurface"},
    {"5", "5", Command::kVolume, "volume"},
    {"c", "c", Command::kNextColour, "colour by the next field, by error, by level"},
    {"Down", "down", Command::kFiner, "a smaller error bound"},
    {"Up", "up", Command::kCoarser, "a larger error bound"},
    {"Left", "left", Command::kBack, "plane back, or a smaller isovalue"},
    {"Right", "right", Command::kForth, "plane forth, or a larger isovalue"},
    {"x", "x", Command::kPlaneX, "plane across x"},
    {"y", "y", Command::kPlaneY, "plane across y"},
    {"z", "z", Command::kPlaneZ, "plane across z"},
    {"f", "f", Command::kFlipPlane, "keep the other side of the plane"},
    {"b", "b", Command::kFocusBox, "focus in a box: the original inside"},
    {"o", "o", Command::kFocusSphere, "focus in a sphere"},
    {"n", "n", Command::kNoFocus, "no focus"},
    {"e", "e", Command::kEdges, "edges on and off"},
    {"s", "s", Command::kSplit, "split screen with the original"},
    {"r", "r", Command::kResetCamera, "all of it in view"},
    {"p", "p", Command::kPicture, "write a picture, ptet-view.png or -2.png ..."},
    {"h", "h", Command::kHelp, "these keys on and off"},
    {"q", "q", Command::kQuit, "quit"},
}};

} // namespace

std::span<const Key> keys() {
  return kKeys;
}

std::optional<Command> command_of(std::string_view symbol) {
  const auto* const key =
      std::find_if(kKeys.begin(), kKeys.end(), [&](const Key& candidate) { return candidate.symbol == symbol; });
  if (key == kKeys.end()) return std::nullopt;
  return key->command;
}

std::string help_on_keys() {
  std::string text;
  for (const Key& key : kKeys) {
    text += "  " + std::string(key.shown) + std::string(key.shown.size() < 7 ? 7 - key.shown.size() : 1, ' ') +
            std::string(key.what) + '\n';
  }
  return text;
}

} // namespace ptet::view
