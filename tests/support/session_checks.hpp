// A session's mesh against a fresh extraction, compared as sets by the ids in the file.
#pragma once

#include "ptet/session.hpp"

#include <optional>
#include <random>
#include <string>
#include <vector>

namespace ptet::test {

/// The first difference between the session's mesh, or what its last update said, and `fresh`; empty when there is
/// none. All of Extraction but bytes and seconds is compared, and Session::extraction() array by array.
[[nodiscard]] std::string difference(const Session& session, const SessionUpdate& update, const Extraction& fresh);

/// The first tet of the session's mesh of which it says another maker than its own extraction; empty when there is
/// none. The last request must have had origins.
[[nodiscard]] std::string differing_origin(const Session& session);

/// A copy of a session's slots that is brought up to date from the changed ones alone, as on a graphics card.
class SlotCopy {
public:
  /// To be called after every update.
  void follow(const Session& session, const SessionUpdate& update);
  /// The first difference; empty when there is none.
  [[nodiscard]] std::string difference(const Session& session) const;

private:
  std::vector<std::array<std::uint32_t, 4>> tets_;
  std::vector<std::array<std::uint32_t, 3>> faces_;
  std::vector<VertexId> vertices_;
  std::vector<RecordId> made_by_;
};

/// Requests of every kind and size, none like the last; regions are small ones mostly. One in `without_origins` does
/// not ask for origins, or one in eight does.
class RandomRequests {
public:
  RandomRequests(const DatasetInfo& info, unsigned seed, std::optional<unsigned> without_origins = {})
      : info_(info), random_(seed), without_origins_(without_origins) {}
  [[nodiscard]] Request next();

private:
  double uniform() { return static_cast<double>(random_() % 1000001) / 1e6; }
  [[nodiscard]] Point point();
  [[nodiscard]] Region region();
  [[nodiscard]] View view();
  [[nodiscard]] ValuesOfInterest values();

  const DatasetInfo& info_;
  std::mt19937 random_;
  std::optional<unsigned> without_origins_;
};

} // namespace ptet::test
