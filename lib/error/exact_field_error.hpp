// The exact field error of a version: the maximum of |Phi - phi_t| over t and the domain, the integral of its square
// there, and the volume of t outside of the domain; Phi is the piecewise linear field of the original mesh, phi_t the
// linear field of tet t.
//
// The original tets near t are clipped to it (measured_parts.hpp), from where t sees their vertices (version_view.hpp).
//
// A flat original tet has no part in space: Phi is told by the tets with volume beside it, and the walk passes on
// through it.
//
// A version so flat that even twice a double's digits do not tell its volume from none, though exact predicates do, is
// not measured; its error is bounded: by the greatest difference of a value at its corners and one at a corner of an
// original tet whose box meets its own. To integrals it adds the square of that everywhere in it, with as much volume
// as it may have; to the volume outside of the domain, nothing. In those that take twice the digits the corners of the
// original tets, too, are taken in the order of their places, for rounding makes parts where they touch that depend on
// the order.
//
// The original tets are found by walking from a corner of t, out of those that have a part in t, across faces that t
// may meet; t is convex, so its parts hang together by faces as long as the domain does. Where the walk comes upon the
// original boundary inside t, t may hold parts of the domain that hang together only outside of it; each such part
// has a boundary face in t, so the walk starts again from every boundary face that meets t.
// Original tets without volume, or so thin that they seem to have none, such as those between layers that fell together
// when coordinates were rounded, may lie beside t and hide what is behind them: faces between these and others count as
// boundary faces here.
//
// Source: Cignoni et al. 2000, sections 4.1 and 4.2 (the errors), which take the maximum over removed vertices only.
#pragma once

#include "error/channel_view.hpp"
#include "error/version_view.hpp"
#include "mesh/prepare.hpp"
#include "mesh/topology.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace ptet {

class ExactFieldError {
public:
  /// `prepared` and the channels must outlive the object. Tets must be positively oriented or flat.
  ExactFieldError(const PreparedMesh& prepared, ChannelView channels);
  ~ExactFieldError();
  ExactFieldError(const ExactFieldError&) = delete;
  ExactFieldError& operator=(const ExactFieldError&) = delete;

  /// What one thread needs while it measures; reusable.
  class Workspace {
  public:
    explicit Workspace(const ExactFieldError& original);

  private:
    friend class ExactFieldError;
    VersionView view_;
    std::vector<std::uint32_t> tet_stamp_;
    std::vector<std::uint32_t> queue_;
    std::vector<std::uint32_t> near_; ///< of a large star: the tets that may meet the version
    std::uint32_t stamp_ = 0;
  };

  /// Raises `errors` (one a field) to the largest errors over `version` and the domain, in the units of the values
  /// times the scale. Never below the truth by more than rounding: kValueRounding of the values met, relative to one
  /// another. Infinite where that cannot be computed. A version that is flat, exactly, has no interior: nothing is
  /// raised. Thread rule: const; one workspace a thread. Cost: the original tets that the version meets, some 0.1 us
  /// each; of one too flat for twice a double's digits, all of them.
  void measure(const Tet& version, Workspace& workspace, std::span<double> errors) const;

  /// The same, and adds to `squared` (one a field and one more) the integrals of the squared error over `version` and
  /// the domain, in squared units of the values times volume, and last the volume of `version` outside of the domain
  /// (where parts of the domain overlap: its volume less theirs, but no less than 0). Exact but for rounding, some
  /// 1e-15 of the integral over the original tets that `version` meets; up to kVolumeRounding of its volume counts as
  /// none. Cost: that of the errors alone. Gives up, and returns false, when an error passes its `limit` (one a field):
  /// errors and integrals are lower bounds then, and the volume says nothing.
  bool measure(const Tet& version, Workspace& workspace, std::span<double> errors, std::span<double> squared,
               std::span<const double> limit) const;
  void measure(const Tet& version, Workspace& workspace, std::span<double> errors, std::span<double> squared) const;

private:
  class Walk;
  std::unique_ptr<OriginalCells> original_;
};

} // namespace ptet
