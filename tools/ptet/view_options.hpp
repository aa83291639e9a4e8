// The options of ptet view. Two programs know them: ptet, which explains them and starts the viewer, and ptet-view, the
// viewer itself, which is apart so that no other command waits for VTK's drawing libraries.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace ptet::cli {

struct ViewArguments {
  std::string input;
  std::optional<std::string> show;
  std::optional<std::string> colour;
  std::optional<std::string> range;
  std::optional<std::string> error;
  std::optional<std::string> tets;
  std::optional<std::string> vertices;
  std::optional<std::string> focus;
  std::optional<std::string> plane;
  std::optional<std::string> isovalue;
  std::optional<std::string> camera;
  std::optional<std::string> size;
  std::optional<std::string> screenshot;
  bool split = false;
  bool no_edges = false;
  bool no_text = false;
};

/// Adds the options, and the help, to `command`. `arguments` must live as long.
void add_view_options(CLI::App& command, ViewArguments& arguments);

} // namespace ptet::cli
