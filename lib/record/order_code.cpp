#include "record/order_code.hpp"

#include "record/error_code.hpp"

namespace ptet {

// Error codes are 16 an octave: those of the square are 32.
OrderCode encode_order(std::uint64_t original, std::uint64_t left) {
  const double ratio = static_cast<double>(original) / static_cast<double>(left);
  return static_cast<OrderCode>(encode_error(ratio * ratio, 1) - encode_error(1, 1));
}

} // namespace ptet
