// What the viewer's keys do: one table, for the viewer, its help and the program's --help.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace ptet::view {

enum class Command : std::uint8_t {
  kSurface,
  kCells,
  kSlice,
  kIsosurface,
  kVolume,
  kNextColour,
  kFiner,
  kCoarser,
  kBack,
  kForth,
  kPlaneX,
  kPlaneY,
  kPlaneZ,
  kFlipPlane,
  kFocusBox,
  kFocusSphere,
  kNoFocus,
  kEdges,
  kSplit,
  kResetCamera,
  kPicture,
  kHelp,
  kQuit,
};

struct Key {
  std::string_view symbol; ///< as X names it
  std::string_view shown;
  Command command;
  std::string_view what;
};

[[nodiscard]] std::span<const Key> keys();
[[nodiscard]] std::optional<Command> command_of(std::string_view symbol);
/// A line for each key.
[[nodiscard]] std::string help_on_keys();

} // namespace ptet::view
