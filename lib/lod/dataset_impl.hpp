// What an opened dataset holds; shared by extractions and sessions.
#pragma once

#include "lod/hierarchy.hpp"
#include "ptet/dataset.hpp"

namespace ptet {

class Dataset::Impl {
public:
  Impl(std::shared_ptr<ByteSource> source, const OpenOptions& options);

  Hierarchy hierarchy; ///< what is read grows behind a const Dataset
  DatasetInfo info;
};

} // namespace ptet
