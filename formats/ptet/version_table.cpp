#include "formats/ptet/version_table.hpp"

#include "record/dependency_order.hpp"

namespace ptet::file {

VersionTable::VersionTable(const Refinement& refinement)
    : refinement_(refinement), first_fine_(refinement.record_count()), creator_(refinement.version_count()) {
  std::uint32_t next = refinement.base_place_count();
  for (std::uint32_t r = 0; r < first_fine_.size(); ++r) {
    first_fine_[r] = next;
    next += refinement.fine_count(RecordId{r});
  }
  std::vector<std::uint32_t> held(refinement.place_count()); // by place: the version
  for (std::uint32_t place = 0; place < refinement.base_place_count(); ++place)
    held[place] = place;
  DependencyOrder order(refinement);
  order.visit([&](std::uint32_t r) { return refinement.applied(RecordId{r}); },
              [&](std::uint32_t r) {
                for (const Place place : refinement.modified(RecordId{r}))
                  creator_[held[place.index()]] = RecordId{r};
                for (std::uint32_t k = 0; k < refinement.fine_count(RecordId{r}); ++k)
                  held[refinement.fine_place(RecordId{r}, k)] = number(RecordId{r}, k);
              });
}

} // namespace ptet::file
