// Checkpoints: what a build has decided so far, in a file from which the same build goes on after an interruption.
//
//   magic      8   "PTETCKP" and a line feed
//   size       8   bytes of what follows the hash
//   hash       8   XXH64 of these
//   identity       program, mesh and options: a checkpoint is of one build alone
//   records        the collapses made and their errors
//   rest           candidates, counters, measured integrals: what collapsing again does not bring back
//
// The collapses are made again on the input, without the search that found them: so the complex, the boundary with what
// its faces stand for, the predictors and the removed vertices come out as they were, and none of them needs to be
// written. What is written is described once, by serialize() functions of Boost.Serialization's form, and goes through
// the archives of formats/ptet/archive.hpp, values only.
//
// A checkpoint is a local file that is trusted: the hash finds accidents, not intent.
#pragma once

#include "formats/ptet/archive.hpp"
#include "ptet/build.hpp"
#include "ptet/error.hpp"
#include "ptet/ids.hpp"

#include <bit>
#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace ptet {

template <class Archive, class Tag>
void serialize(Archive& archive, Id<Tag>& id, unsigned /*version*/) {
  std::uint32_t index = id.index();
  archive& index;
  id = Id<Tag>{index};
}

/// What is known at the end of a round; the errors are filled in after the last.
template <class Archive>
void serialize(Archive& archive, RoundReport& step, unsigned /*version*/) {
  archive& step.vertices& step.cost;
}

} // namespace ptet

namespace ptet::build {

/// What a build is: as long as these are the same it makes the same decisions.
struct BuildIdentity {
  std::string program;                                      ///< version, sources, compiler
  std::string mesh;                                         ///< hash of positions, tets and arrays
  std::vector<std::pair<std::string, std::string>> options; ///< describe_options()

  template <class Archive>
  void serialize(Archive& archive, unsigned /*version*/) {
    archive& program& mesh& options;
  }
  friend bool operator==(const BuildIdentity&, const BuildIdentity&) = default;
};

/// Of this program and `mesh`.
[[nodiscard]] BuildIdentity identity_of(const TetMesh& mesh, std::vector<std::pair<std::string, std::string>> options);

/// Numbers many of which are 0, in a list that has its size already: (zeros, others, these) again and again.
template <class Archive>
void serialize_sparse(Archive& archive, std::span<double> values) {
  const auto is_zero = [](double value) { return std::bit_cast<std::uint64_t>(value) == 0; };
  for (std::size_t i = 0; i < values.size();) {
    std::uint64_t zeros = 0, others = 0;
    if constexpr (Archive::is_saving::value) {
      while (i + zeros < values.size() && is_zero(values[i + zeros]))
        ++zeros;
      while (i + zeros + others < values.size() && !is_zero(values[i + zeros + others]))
        ++others;
    }
    archive& zeros& others;
    if (zeros + others == 0 || zeros > values.size() - i || others > values.size() - i - zeros)
      throw Error(ErrorCode::kCorruptFile, "the checkpoint is corrupt: its numbers do not fit the mesh");
    for (i += zeros; others > 0; ++i, --others)
      archive& values[i];
  }
}

/// A checkpoint that was read: its state, to be loaded once.
class StoredState {
public:
  /// Throws Error: kIo when it cannot be read, kCorruptFile when it is damaged or no checkpoint, kBadArgument when it
  /// is of another build than `identity`, with what differs.
  StoredState(const std::string& path, const BuildIdentity& identity);
  StoredState(const StoredState&) = delete;
  StoredState& operator=(const StoredState&) = delete;

  [[nodiscard]] file::InputArchive& archive() { return archive_; }
  /// Throws Error(kCorruptFile) with what does not fit.
  [[noreturn]] void refuse(const std::string& what) const;
  /// Nothing may be left. Throws Error(kCorruptFile).
  void finish() const { in_.finish(); }

private:
  std::string path_;
  std::vector<std::byte> bytes_;
  file::ByteReader in_;
  file::InputArchive archive_;
};

/// Writes the checkpoints of one build when it is time.
class CheckpointWriter {
public:
  /// Writes nothing when `options.path` is empty. Throws Error: kBadArgument when there is a file of that name already
  /// that nobody asked to go on from, kIo when none can be written there.
  explicit CheckpointWriter(const CheckpointOptions& options);

  [[nodiscard]] bool enabled() const { return !options_.path.empty(); }
  /// Whether so much time has passed since the last one.
  [[nodiscard]] bool due() const;
  /// The file appears whole, in place of the one before. Throws Error(kIo).
  void write(const BuildIdentity& identity, const std::function<void(file::OutputArchive&)>& save_state,
             BuildReport& report);
  /// Not due again before as much time has passed as after one.
  void put_off() { last_ = Clock::now(); }

private:
  using Clock = std::chrono::steady_clock;

  const CheckpointOptions& options_;
  Clock::time_point last_ = Clock::now();
};

} // namespace ptet::build
