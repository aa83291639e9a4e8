// What a request asks of each record by itself, everything but budgets: which splits must be applied whatever else is.
// With all that they depend on they are the answer's cut.
//
//            block table           record: codes          star: box           star: each tet
//   of_block ----------->  wants ------------->  codes --------------->  box ------------------> yes
//              kNone                  no                      no                      no
#pragma once

#include "lod/camera.hpp"
#include "lod/hierarchy.hpp"
#include "record/error_code.hpp"

#include <optional>
#include <variant>
#include <vector>

#include <boost/container/small_vector.hpp>

namespace ptet {

/// Something for each governing field and, last, the domain. Few, and made anew for every request: on the stack.
template <class T>
using PerCode = boost::container::small_vector<T, 8>;
/// The largest codes that are allowed.
using CodeLimits = PerCode<ErrorCode16>;

/// Does any error pass its limit? `codes` has as many as there are limits.
[[nodiscard]] inline bool exceeds(const ErrorCode16* codes, const CodeLimits& limits) {
  for (std::size_t i = 0; i < limits.size(); ++i)
    if (codes[i] > limits[i]) return true;
  return false;
}

/// Which records of a block are wanted, as far as the block table tells.
enum class BlockDemand { kNone, kSome, kAll };

/// Every split.
struct WantAll {
  friend bool operator==(const WantAll&, const WantAll&) = default;
};
// Wants with bounds go by the monotone errors of fields: only they know of original vertices outside of the mesh. So a
// star stands for what is there, too, and for what is as far from it as its domain error.

/// The splits of records whose star, by its box, meets the region and of whose errors one passes its limit; with no
/// limits those of all records there.
struct WantInside {
  Region region;
  CodeLimits limits;
  double domain_scale = 0; ///< of the domain's code

  friend bool operator==(const WantInside&, const WantInside&) = default;
};
/// The splits of records of whose errors one passes what is allowed at the distance of the star from the region.
struct WantNear {
  Region region;
  PerCode<double> at_region;    ///< allowed in the region, absolute
  PerCode<double> per_distance; ///< and so much more for each mesh unit away from it
  PerCode<double> scale;        ///< of the codes

  friend bool operator==(const WantNear&, const WantNear&) = default;
};
/// An interval of values of a field.
struct Interval {
  std::size_t array = 0; ///< its place among the file's arrays
  std::size_t code = 0;  ///< its place among the error codes
  double scale = 0;      ///< of that code
  double min = 0;
  double max = 0;

  friend bool operator==(const Interval&, const Interval&) = default;
};
using Intervals = boost::container::small_vector<Interval, 2>;
/// The splits of records of whose errors one passes its limit. With values, only those whose star may take one of them;
/// with a camera the limits hold for stars that are in the picture, and looser ones, or none, for those that are not.
struct WantBounded {
  CodeLimits limits; ///< empty: whatever the errors are
  Intervals values;
  std::optional<Camera> camera;
  CodeLimits limits_unseen; ///< with a camera: outside the picture; empty where nothing is asked there
  double max_pixels = 0;    ///< with a camera: of the domain error
  double max_pixels_unseen = 0;
  double domain_scale = 0; ///< of the domain's code
  [[nodiscard]] bool is_plain() const { return values.empty() && !camera; }

  friend bool operator==(const WantBounded&, const WantBounded&) = default;
};
using Want = std::variant<WantAll, WantInside, WantNear, WantBounded>;

/// What WantsOfBlock::find() finds, in memory that it keeps.
class WantedRecords {
public:
  /// `r`: a record of the block.
  [[nodiscard]] bool contain(std::uint32_t r) const { return found_[r - first_] != 0; }

private:
  friend class WantsOfBlock;

  std::uint32_t first_ = 0;
  std::vector<char> found_;
  std::vector<Box> boxes_;
};

/// Of some wants those that the records of one block may be asked for by: few, of however many. They must outlive it.
class WantsOfBlock {
public:
  /// What the block table tells.
  [[nodiscard]] BlockDemand demand() const { return demand_; }
  /// Which of the block's records are wanted. The lock must be held and the block be loaded. Depends on the records
  /// alone: not on what else is in memory.
  void find(const Hierarchy& hierarchy, const file::BlockInfo& block, WantedRecords& wanted) const;

private:
  friend class Wants;

  BlockDemand demand_ = BlockDemand::kNone;
  boost::container::small_vector<const Want*, 8> wants_;
};

/// The splits that any of some wants asks for.
class Wants {
public:
  void clear() { wants_.clear(); }
  void add(Want want) { wants_.push_back(std::move(want)); }
  [[nodiscard]] bool empty() const { return wants_.empty(); }
  /// Whether with every record that is wanted its parents are, too.
  [[nodiscard]] bool are_closed() const;

  [[nodiscard]] BlockDemand demand_in(const file::BlockInfo& block) const;
  /// Makes `those` the wants of the block, in the memory that it has.
  void narrow_to(const file::BlockInfo& block, WantsOfBlock& those) const;

  friend bool operator==(const Wants&, const Wants&) = default;

private:
  std::vector<Want> wants_;
};

/// All that a request asks for but its budgets.
struct Demand {
  Wants promised; ///< whatever the budgets for size are
  Wants wished;   ///< as far as they go

  friend bool operator==(const Demand&, const Demand&) = default;
};

/// Whether a version with these errors, or the original where it stands for that, may have values in the interval. A
/// "no" is certain as far as the errors are true. The lock must be held.
[[nodiscard]] bool may_take(const Interval& interval, const Hierarchy& hierarchy, const Tet& tet,
                            const ErrorCode16* errors);

} // namespace ptet
