// Numbers in text, held to the types that the file says they have: VTK's readers wrap some that do not fit, without a
// word.
#pragma once

#include "ptet/mesh.hpp"

#include <string_view>

namespace ptet::vtkio {

/// What keeps `text`, a word of a file, from being a value of `type`: "is not a number", "is not an integer" or "is out
/// of range"; null when nothing does. Not-a-number and infinity are values of floating-point types.
const char* unfitness(std::string_view text, ScalarType type);

} // namespace ptet::vtkio
