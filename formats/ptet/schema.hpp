// What the records of a file are made of: the types of their numbers, how those are ranked, and which context of the
// range coder stands for what. Reader and writer derive it from the header alone.
#pragma once

#include "formats/ptet/numbers.hpp"
#include "formats/ptet/reader.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace ptet::file {

// Format constants: PTET.md, "Limits".
inline constexpr std::uint32_t kMaxRecordsPerBlock = 4096;
inline constexpr std::uint32_t kDefaultRecordsPerBlock = 512;
inline constexpr std::uint32_t kMaxArrays = 1024;
/// What a block's bytes may stand for at most; the writer pads a block that says more.
inline constexpr std::uint32_t kMaxVersionsPerByte = 32;
inline constexpr std::uint32_t kMaxValueBytesPerByte = 256;
/// No sum of squared error codes over a block is larger: 4096 records of 2^56.
inline constexpr double kMaxSquaredErrorSum = 0x1p68;
/// What a zstd frame may expand to, by its size.
inline constexpr std::uint32_t kMaxExpansion = 1024;

/// One scalar column: a component of the positions or of an array.
struct Column {
  ScalarType type = ScalarType::kFloat32;
  unsigned bits = 32;
  const DecimalRanking* decimals = nullptr; ///< null: none
  unsigned zero_bits = 0;                   ///< see Precision
  // First contexts.
  std::uint32_t escape = 0;
  std::uint32_t sign = 0;
  std::uint32_t mantissa = 0; ///< 2 bits below the leading one: 3 contexts for each length
  std::uint32_t length = 0;   ///< trees of 2^length_levels contexts, one for each spread class
  unsigned length_levels = 6;
};

class Schema {
public:
  /// `precisions`: of the positions, then of each array. Throws Error(kLimit) when the contexts are too many.
  Schema(const Header& header, const std::vector<Precisions>& precisions);

  [[nodiscard]] std::uint32_t context_count() const { return context_count_; }
  /// Those of seeds, which are the first.
  [[nodiscard]] std::uint32_t seed_contexts() const { return growth; }

  // Trees of contexts, laid one behind the other in this order.
  static constexpr std::uint32_t kUintContexts = 128; ///< 32 lengths in a tree, 3 for each length
  std::uint32_t source = 0;                           ///< 2 x uint
  std::uint32_t index = 0;                            ///< 2 x (uint, 32 signs)
  std::uint32_t fine = 0;                             ///< 2 x tree of 5 bits
  std::uint32_t fine_rest = 0;                        ///< uint
  std::uint32_t corner = 0;                           ///< 2 x tree of 2 bits: base, others
  std::uint32_t more_seeds = 0;                       ///< 1
  std::uint32_t growth = 0;                           ///< kGrowthContexts
  std::uint32_t same = 0;                             ///< 3 axes x 4 candidates x 4 multiplicities x 4 earlier axes
  std::uint32_t own_zero = 0;                         ///< per code: 4
  std::uint32_t own = 0;                              ///< per code: kErrorClasses x kErrorContexts
  std::uint32_t above_zero = 0;                       ///< per code: 4
  std::uint32_t above = 0;                            ///< per code: uint
  std::uint32_t squared_zero = 0;                     ///< per code: 4; these three only where measured
  std::uint32_t squared_negative = 0;                 ///< per code: 6
  std::uint32_t squared = 0;                          ///< per code: 4 x kErrorContexts
  std::uint32_t order = 0;                            ///< kOrderClasses x uint
  static constexpr std::uint32_t kGrowthContexts = 8 * 64 * 4;
  static constexpr std::uint32_t kErrorClasses = 8;
  static constexpr std::uint32_t kOrderClasses = 8;
  static constexpr std::uint32_t kErrorContexts = 16 + 16 * 3 + 1; ///< length tree, mantissa, sign

  std::array<Column, 3> position;
  std::vector<std::vector<Column>> arrays;
  std::vector<std::uint32_t> governing; ///< arrays, ascending: the order of the error codes, domain last
  [[nodiscard]] std::uint32_t code_count() const { return static_cast<std::uint32_t>(governing.size()) + 1; }
  std::vector<double> scale; ///< of each error code
  bool has_squared_errors = false;
  double volume = 0;
  std::uint32_t record_count = 0;

private:
  std::uint32_t context_count_ = 0;
};

} // namespace ptet::file
