// An extraction in the order of the mesh that its file was built from.
#pragma once

#include "formats/ptet/input_order.hpp"
#include "ptet/dataset.hpp"

namespace ptet {

/// Sorts the vertices by their ids in the input and fills Extraction::input_vertex. Where the extraction is the whole
/// original, tets and their corners are put in the order in which they stood there; else they stay as they are.
void put_in_input_order(Extraction& extraction, const file::InputOrder& order);

} // namespace ptet
