// generate_mesh: large meshes with known fields, as VTU, for benchmarks; see its --help.
#include "formats/vtk/read.hpp"
#include "formats/vtk/write.hpp"
#include "generate/fields.hpp"
#include "generate/shapes.hpp"
#include "mesh/topology.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include <CLI/CLI.hpp>
#include <unistd.h>

using namespace ptet;

namespace {

struct Arguments {
  std::string tets;
  std::uint32_t holes = bench::kMostHoles;
  std::string input;
  std::uint32_t times = 1;
  double detail = 0;
  std::string output;
  bool doubles = false;
  bool compress = false;
};

/// 2000000, 2000k or 2M.
std::uint64_t parse_tets(const std::string& text) {
  std::size_t used = 0;
  double number = -1;
  try {
    number = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  const std::string unit = text.substr(used);
  const double scale = unit == "M" ? 1e6 : unit == "k" ? 1e3 : unit.empty() ? 1 : 0;
  if (used == 0 || scale == 0 || !(number * scale >= 6) || number * scale > static_cast<double>(kMaxTets))
    throw Error(ErrorCode::kBadArgument, "--tets '" + text + "': a number from 6 to " + std::to_string(kMaxTets) +
                                             " is wanted, such as 500k or 10M");
  return static_cast<std::uint64_t>(number * scale);
}

/// One line on a terminal, rewritten when the stage or the share changes.
class Line {
public:
  Line() : enabled_(isatty(STDERR_FILENO) == 1) {}
  ~Line() {
    if (!shown_.empty()) std::fputs("\r\x1b[K", stderr);
  }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  ProgressCallback callback() {
    return [this](const Progress& progress) {
      if (!enabled_) return true;
      std::string text(progress.stage);
      if (progress.total > 0) text += " " + std::to_string(100 * progress.done / progress.total) + "%";
      if (text != shown_) std::fprintf(stderr, "\r%s\x1b[K", text.c_str());
      shown_ = text;
      return true;
    };
  }

private:
  bool enabled_;
  std::string shown_;
};

TetMesh make(const CLI::App& kind, const Arguments& arguments, const ProgressCallback& progress) {
  const ScalarType type = arguments.doubles ? ScalarType::kFloat64 : ScalarType::kFloat32;
  if (kind.get_name() == "cube")
    return bench::with_known_fields(bench::graded_cube(parse_tets(arguments.tets), progress), type, progress);
  if (kind.get_name() == "ball")
    return bench::with_known_fields(bench::ball_with_holes(parse_tets(arguments.tets), arguments.holes, progress), type,
                                    progress);
  TetMesh mesh = read_mesh(arguments.input, nullptr, progress);
  for (std::uint32_t i = 0; i < arguments.times; ++i)
    mesh = bench::refined(mesh, progress);
  if (arguments.detail > 0) bench::add_detail(mesh, arguments.detail, progress);
  return mesh;
}

int run(const CLI::App& kind, const Arguments& arguments) {
  const auto begin = std::chrono::steady_clock::now();
  Line line;
  const TetMesh mesh = make(kind, arguments, line.callback());
  WriteOptions options;
  options.compressor = arguments.compress ? Compressor::kZlib : Compressor::kNone;
  write_mesh(arguments.output, mesh, options, line.callback());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::printf("{\"vertices\": %zu, \"tets\": %zu, \"seconds\": %.2f}\n", mesh.vertex_count(), mesh.tets.size(),
              took.count());
  return 0;
}

/// The exit codes of ptet.
int exit_code_of(ErrorCode code) {
  switch (code) {
  case ErrorCode::kBadArgument: return 2;
  case ErrorCode::kBadInput: return 3;
  case ErrorCode::kCorruptFile: return 4;
  case ErrorCode::kLimit: return 5;
  case ErrorCode::kIo: return 6;
  case ErrorCode::kCancelled: return 130;
  }
  return 1;
}

} // namespace

int main(int argc, char** argv) {
  CLI::App program(
      "Makes large meshes with known fields, to measure with. The same arguments give the same mesh.\n"
      "Fields of cube and ball: smooth; layer, sharp at the surface of a small ball; velocity, a vector.\n",
      "generate_mesh");
  program.require_subcommand(1);
  Arguments arguments;
  const auto add_output = [&](CLI::App& kind) {
    kind.add_option("-o,--output", arguments.output, "the file to write")->required()->option_text("OUT.vtu");
    kind.add_flag("--compress", arguments.compress, "zlib; without it arrays are raw");
  };
  const auto add_size = [&](CLI::App& kind) {
    kind.add_option("--tets", arguments.tets, "about how many: 1500000, 1500k or 1.5M")->required()->option_text("N");
    kind.add_flag("--double", arguments.doubles, "positions and fields as float64 instead of float32");
    add_output(kind);
  };
  CLI::App* const cube =
      program.add_subcommand("cube", "the unit cube, six tets a cell, the finest cells around (.35, .35, .35)");
  add_size(*cube);
  CLI::App* const ball = program.add_subcommand("ball", "a ball of radius 1 with round holes in it");
  add_size(*ball);
  ball->add_option("--holes", arguments.holes, "how many (5)")
      ->check(CLI::Range(0U, bench::kMostHoles))
      ->option_text("N");
  CLI::App* const refine = program.add_subcommand("refine", "a given mesh, every tet in eight");
  refine->add_option("IN", arguments.input, "the mesh: .vtu, .pvtu, .vtk or Exodus")->required()->option_text(" ");
  refine->add_option("--times", arguments.times, "again and again (1)")->check(CLI::Range(1, 4))->option_text("N");
  refine
      ->add_option(
          "--detail", arguments.detail,
          "add waves of so much of a field's range to the fields, which\nare linear in the tets given otherwise")
      ->check(CLI::Range(0.0, 1.0))
      ->option_text("X");
  add_output(*refine);
  try {
    program.parse(argc, argv);
    return run(*program.get_subcommands().front(), arguments);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : 2;
  } catch (const Error& error) {
    std::fprintf(stderr, "generate_mesh: error: %s\n", error.what());
    return exit_code_of(error.code());
  } catch (const std::bad_alloc&) {
    std::fputs("generate_mesh: error: there is not enough memory for this\n", stderr);
    return 5;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "generate_mesh: error: %s\n", error.what());
    return 1;
  }
}
