// An extraction in the order of the mesh that its file was built from.
#pragma once

#include "formats/ptet/input_order.hpp"
#include "ptet/dataset.hpp"

namespace ptet {

/// Vertices come by their ids in the input, whatever is there of them; tets and their corners as they stood there when
/// the extraction is all of it, else as they were. Fills Extraction::input_vertex.
void put_in_input_order(Extraction& extraction, const file::InputOrder& order);

} // namespace ptet
