// The exact largest field error of a version: the maximum of |Phi - phi_t| over t and the domain, Phi the piecewise
// linear field of the original mesh, phi_t the linear field of tet t.
//
// On the part of t in one original tet the difference is linear, so its norm is greatest at a vertex of that part; and
// every such vertex that is not a vertex of t (where the difference is 0) lies on an original face clipped to t:
//
//            original faces near t            clipped to t: polygons; the maximum over their corners is exact
//
// The original tets are found by walking from a corner of t across faces that t may meet. Where the walk comes upon the
// original boundary inside t, t may hold parts of the domain that hang together only outside of it; each such part
// has a boundary face in t, so the walk starts again from every boundary face that meets t.
//
// Source: Cignoni et al. 2000, section 4.1 (the error), which takes the maximum over removed vertices only.
#pragma once

#include "mesh/prepare.hpp"
#include "mesh/topology.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace ptet {

/// Values at the vertices of the original mesh: `channels` numbers a vertex, grouped in fields.
struct ChannelView {
  std::span<const double> values;
  std::size_t channels = 0;
  /// By channel: the field it is a component of; ascending. A field's error is the Euclidean norm over its channels.
  std::span<const std::size_t> field_of;
};

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
    struct Vertex {
      std::array<double, 4> barycentric;
      std::uint32_t stamp = 0;
    };
    std::vector<Vertex> vertices_;
    std::vector<double> differences_; ///< vertex x channel
    std::vector<std::uint32_t> tet_stamp_;
    std::vector<std::uint32_t> queue_;
    std::vector<double> polygon_, clipped_;
    std::uint32_t stamp_ = 0;
  };

  /// Raises `errors` (one a field) to the largest errors over `version` and the domain, in the units of the values.
  /// Never below the truth by more than rounding (some 1e-15 of the largest difference met). A flat version has no
  /// interior: nothing is raised.
  /// Thread rule: const; one workspace a thread. Cost: the original tets that the version meets, some 0.3 us each.
  void measure(const Tet& version, Workspace& workspace, std::span<double> errors) const;

private:
  class Walk;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace ptet
