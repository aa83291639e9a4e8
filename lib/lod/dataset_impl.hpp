// What an opened dataset holds; shared by extractions and sessions.
#pragma once

#include "lod/hierarchy.hpp"
#include "ptet/dataset.hpp"

namespace ptet {

class Dataset::Impl {
public:
  explicit Impl(std::unique_ptr<file::Source> source);

  Hierarchy hierarchy; ///< what is read grows behind a const Dataset
  DatasetInfo info;
};

} // namespace ptet
