#include "ptet/validate.hpp"

#include "mesh/box_tree.hpp"
#include "mesh/examination.hpp"
#include "mesh/governing.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "mesh/value_offset.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>

#include <oneapi/tbb/task_arena.h>

namespace ptet {

namespace {

using namespace vec;

void measure_topology(const Examination& found, MeshReport& report) {
  const auto count = [](std::uint64_t n) { return static_cast<std::int64_t>(n); };
  report.boundary_faces = found.boundary.faces.size();
  report.boundary_vertices = found.boundary.vertex_count;
  report.components = count_components(found.tets, found.faces);
  report.boundary_components = found.boundary.components;
  report.euler_characteristic = count(found.links.used_count) - count(found.links.edge_count) +
                                count(found.faces.face_count) - count(found.tets.size());
  report.boundary_euler_characteristic =
      count(found.boundary.vertex_count) - count(found.boundary.edge_count) + count(found.boundary.faces.size());
}

void measure_geometry(const Examination& found, MeshReport& report) {
  const auto at = [&](VertexId v) -> const Point& { return found.points[v.index()]; };
  for (const auto& [a, b, c, d] : found.tets)
    report.volume += std::abs(dot(cross(at(b) - at(a), at(c) - at(a)), at(d) - at(a))) / 6;
  for (const auto& [a, b, c] : found.boundary.faces)
    report.boundary_area += norm(cross(at(b) - at(a), at(c) - at(a))) / 2;
  BoundingBox box;
  for (std::size_t v = 0; v < found.points.size(); ++v)
    if (found.links.used[v]) box.add(found.points[v]);
  if (found.links.used_count == 0) return;
  report.box_min = box.low;
  report.box_max = box.high;
}

FieldSummary summarise(const PointArray& array, const Examination& found) {
  FieldSummary summary{array.name, array.type, array.components};
  if (array.components == 0 || array.bytes.size() != found.points.size() * array.row_bytes()) return summary;
  dispatch(array.type, [&]<class T>(T) {
    for (std::size_t v = 0; v < found.points.size(); ++v) {
      if (!found.links.used[v]) continue;
      const std::byte* row = array.bytes.data() + v * array.row_bytes();
      double value = static_cast<double>(load<T>(row));
      bool finite = std::isfinite(value);
      if (array.components > 1) {
        value = std::abs(value);
        for (std::size_t i = 1; i < array.components; ++i) {
          const auto component = static_cast<double>(load<T>(row + i * sizeof(T)));
          finite = finite && std::isfinite(component);
          value = std::hypot(value, component); // may pass a double where no component does
        }
      }
      if (!finite) {
        ++summary.not_finite;
        continue;
      }
      summary.min = std::fmin(summary.min, value);
      summary.max = std::fmax(summary.max, value);
    }
  });
  summary.can_govern = summary.not_finite == 0 && std::isfinite(range_of(array, found.links.used));
  return summary;
}

void find_fill_values(const PointArray& array, const Examination& found, MeshReport& report) {
  if (has_wide_integers(array)) return;
  std::vector<double> values;
  for (std::uint32_t component = 0; component < array.components; ++component) {
    values.clear();
    for (std::size_t v = 0; v < found.points.size(); ++v)
      if (found.links.used[v] != 0) values.push_back(array.value(v, component));
    if (const auto odd = odd_range(values)) {
      report.findings.push_back({"fill-values", Severity::kNote, 1, fill_values_note(array.name, *odd), {}});
      return;
    }
  }
}

} // namespace

double MeshReport::diagonal() const {
  return norm(box_max - box_min);
}

const Finding* MeshReport::first_error() const {
  const auto found = std::find_if(findings.begin(), findings.end(),
                                  [](const Finding& finding) { return finding.severity == Severity::kError; });
  return found == findings.end() ? nullptr : &*found;
}

MeshReport report_on(const TetMesh& mesh, const Examination& found) {
  MeshReport report;
  report.tets = mesh.tets.size();
  report.vertices = found.points.size();
  report.overlaps_examined = found.overlaps_examined;
  measure_topology(found, report);
  measure_geometry(found, report);
  for (const PointArray& array : mesh.point_arrays)
    report.fields.push_back(summarise(array, found));
  report.findings = found.findings;
  for (const std::uint32_t i : governing_by_default(mesh.point_arrays)) {
    report.fields[i].governs_by_default = true;
    if (report.fields[i].can_govern) find_fill_values(mesh.point_arrays[i], found, report);
  }
  return report;
}

MeshReport validate(const TetMesh& mesh, const ProgressCallback& progress) {
  // Where no threads were asked for none are started.
  oneapi::tbb::task_arena alone(1);
  return report_on(mesh, alone.execute([&] { return examine(mesh, progress); }));
}

} // namespace ptet
