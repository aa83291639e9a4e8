// Where the growth of each record's region begins: the versions that are cheapest to name.
//
// Records are taken in groups that do not wait for one another (record_runs.hpp): the versions that they replace are
// all there before the first of them is split, and what a seed costs depends on nothing else but the seeds of its block
// before and the model. So the seeds of a group are chosen together, block by block in parallel, by the model as it was
// before.
#pragma once

#include "formats/ptet/ordering.hpp"
#include "formats/ptet/record_codec.hpp"
#include "formats/ptet/slot_match.hpp"

#include <cstdint>
#include <span>
#include <vector>

#include <oneapi/tbb/enumerable_thread_specific.h>

namespace ptet::file {

class SeedChoice {
public:
  /// `block_of`: by record of the file. All must outlive the object.
  SeedChoice(const RecordStream& records, const FileOrder& order, const Schema& schema,
             std::span<const BlockInfo> infos, std::span<const std::uint32_t> block_of, const SlotMatch& match,
             const FileStars& stars)
      : records_(records), order_(order), schema_(schema), infos_(infos), block_of_(block_of), match_(match),
        stars_(stars) {}

  /// Chooses for a group of records (of the file), none of which has been split: those of a block in a row, as they
  /// will be coded. `model`: of the first contexts, which are those of seeds. `states`: by block. Throws
  /// Error(kBadInput) when a version of a region has not appeared yet.
  void choose(const std::vector<Probability>& model, std::span<const BlockState> states, const Refinement& refinement,
              std::span<const std::uint32_t> group);
  /// The seeds of the group's record at this place.
  [[nodiscard]] std::span<const Seed> seeds(std::size_t place) const { return seeds_[place]; }

private:
  /// Of one thread.
  struct Scratch {
    std::vector<char> reached;
    std::vector<std::uint32_t> front;
  };
  /// Of all there is to choose from.
  struct Choice {
    std::uint32_t index; ///< among the modified slots
    Seed seed;
    std::uint32_t rank;
  };

  /// `number`: the block's.
  [[nodiscard]] Seed seed_at(const Refinement& refinement, std::uint32_t number, std::uint32_t place,
                             VertexId target) const;
  [[nodiscard]] VertexId target_of(RecordId r) const {
    return order_.file_vertex[records_.target[order_.stream_record[r.index()]].index()];
  }
  void choose_for(const std::vector<Probability>& model, std::uint32_t number, SeedHistory& history,
                  const Refinement& refinement, RecordId r, std::vector<Seed>& seeds, Scratch& scratch) const;
  [[nodiscard]] Choice cheapest(const std::vector<Probability>& model, std::uint32_t number, const SeedHistory& history,
                                const Refinement& refinement, RecordId r, const std::vector<char>& reached) const;
  [[nodiscard]] std::uint32_t reach(const Refinement& refinement, RecordId r, std::uint32_t index,
                                    Scratch& scratch) const;

  const RecordStream& records_;
  const FileOrder& order_;
  const Schema& schema_;
  std::span<const BlockInfo> infos_;
  std::span<const std::uint32_t> block_of_;
  const SlotMatch& match_;
  const FileStars& stars_;
  std::vector<std::vector<Seed>> seeds_;  ///< by place in the group
  std::vector<std::size_t> block_begins_; ///< places in the group where another block's records begin, and its end
  oneapi::tbb::enumerable_thread_specific<Scratch> scratch_;
};

} // namespace ptet::file
