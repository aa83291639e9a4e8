#include "compare.hpp"

#include "console.hpp"
#include "mesh/predicates.hpp"
#include "plain_output.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

namespace ptet::cli {
namespace {

/// Rows of bytes: a vertex's position and all its values, arrays in one order for both meshes.
class VertexRows {
public:
  VertexRows(const TetMesh& mesh, const std::vector<std::string>& array_names) : rows_(mesh.vertex_count()) {
    columns_.push_back(&mesh.positions);
    for (const std::string& name : array_names)
      columns_.push_back(mesh.find(name));
  }

  [[nodiscard]] std::size_t size() const { return rows_; }
  [[nodiscard]] static int compare(const VertexRows& a, std::size_t i, const VertexRows& b, std::size_t j) {
    for (std::size_t c = 0; c < a.columns_.size(); ++c) {
      const std::size_t bytes = a.columns_[c]->row_bytes();
      const int order =
          std::memcmp(a.columns_[c]->bytes.data() + i * bytes, b.columns_[c]->bytes.data() + j * bytes, bytes);
      if (order != 0) return order;
    }
    return 0;
  }
  [[nodiscard]] std::vector<std::uint32_t> sorted() const {
    std::vector<std::uint32_t> order(rows_);
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](auto i, auto j) { return compare(*this, i, *this, j) < 0; });
    return order;
  }

private:
  std::size_t rows_;
  std::vector<const PointArray*> columns_;
};

std::string describe(const PointArray& array) {
  return "'" + on_one_line(array.name) + "' (" + name_of(array.type) + " x " + std::to_string(array.components) + ")";
}

bool same_layout(const PointArray& a, const PointArray& b) {
  return a.type == b.type && a.components == b.components;
}

/// Whether both have the same arrays, in name and type.
bool compare_layout(const TetMesh& original, const TetMesh& copy, Findings& findings) {
  const std::size_t before = findings.wrong.size();
  if (!same_layout(original.positions, copy.positions)) {
    findings.wrong.push_back(std::string("positions are ") + name_of(original.positions.type) + " in the original, " +
                             name_of(copy.positions.type) + " in the file");
  }
  for (const PointArray& array : original.point_arrays) {
    const PointArray* const found = copy.find(array.name);
    if (found == nullptr || !same_layout(array, *found)) {
      findings.wrong.push_back("the original's array " + describe(array) +
                               (found == nullptr ? " is not in the file" : " is " + describe(*found) + " in the file"));
    }
  }
  for (const PointArray& array : copy.point_arrays) {
    if (original.find(array.name) == nullptr) {
      findings.wrong.push_back("the file's array " + describe(array) + " is not in the original");
    }
  }
  return findings.wrong.size() == before;
}

/// For each vertex its class, the same number in both meshes for the same bits.
struct Classes {
  std::vector<std::uint32_t> original, copy;
  std::uint64_t only_in_original = 0, only_in_copy = 0; ///< vertices without a partner
  std::uint64_t alike = 0;                              ///< vertices of the original that share their class
  std::uint32_t first_missing = 0;                      ///< a vertex of the original without a partner
};

Classes classify(const VertexRows& original, const VertexRows& copy) {
  const auto a = original.sorted();
  const auto b = copy.sorted();
  Classes classes{std::vector<std::uint32_t>(a.size()), std::vector<std::uint32_t>(b.size()), 0, 0, 0, 0};
  std::size_t i = 0, j = 0;
  for (std::uint32_t number = 0; i < a.size() || j < b.size(); ++number) {
    const bool from_copy = i == a.size() || (j < b.size() && VertexRows::compare(original, a[i], copy, b[j]) > 0);
    const VertexRows& rows = from_copy ? copy : original;
    const std::uint32_t sample = from_copy ? b[j] : a[i];
    const std::size_t i_begin = i, j_begin = j;
    for (; i < a.size() && VertexRows::compare(original, a[i], rows, sample) == 0; ++i)
      classes.original[a[i]] = number;
    for (; j < b.size() && VertexRows::compare(copy, b[j], rows, sample) == 0; ++j)
      classes.copy[b[j]] = number;
    const std::size_t in_original = i - i_begin, in_copy = j - j_begin;
    if (in_original > in_copy) {
      if (classes.only_in_original == 0) classes.first_missing = a[i_begin + in_copy];
      classes.only_in_original += in_original - in_copy;
    }
    if (in_copy > in_original) classes.only_in_copy += in_copy - in_original;
    if (in_original > 1) classes.alike += in_original;
  }
  return classes;
}

/// A tet by the classes of its corners, ascending, and whether sorting them was an odd permutation.
struct TetKey {
  std::array<std::uint32_t, 4> corners{};
  bool odd = false;
  std::uint32_t tet = 0;
};

std::vector<TetKey> keys_of(const TetMesh& mesh, const std::vector<std::uint32_t>& classes) {
  std::vector<TetKey> keys(mesh.tets.size());
  for (std::uint32_t t = 0; t < keys.size(); ++t) {
    TetKey& key = keys[t];
    key.tet = t;
    for (std::size_t c = 0; c < 4; ++c)
      key.corners[c] = classes[mesh.tets[t][c].index()];
    for (std::size_t end = 3; end > 0; --end) {
      for (std::size_t c = 0; c < end; ++c) {
        if (key.corners[c] <= key.corners[c + 1]) continue;
        std::swap(key.corners[c], key.corners[c + 1]);
        key.odd = !key.odd;
      }
    }
    // With two corners that cannot be told apart both orders are the same tet.
    if (std::adjacent_find(key.corners.begin(), key.corners.end()) != key.corners.end()) key.odd = false;
  }
  std::sort(keys.begin(), keys.end(),
            [](const TetKey& a, const TetKey& b) { return std::pair(a.corners, a.odd) < std::pair(b.corners, b.odd); });
  return keys;
}

void compare_tets(const TetMesh& original, const TetMesh& copy, const Classes& classes, Findings& findings) {
  const auto a = keys_of(original, classes.original);
  const auto b = keys_of(copy, classes.copy);
  std::uint64_t missing = 0, added = 0, turned = 0, mirrored = 0;
  std::uint32_t first_missing = 0, first_mirrored = 0;
  for (std::size_t i = 0, j = 0; i < a.size() || j < b.size();) {
    if (j == b.size() || (i < a.size() && a[i].corners < b[j].corners)) {
      if (missing++ == 0) first_missing = a[i].tet;
      ++i;
    } else if (i == a.size() || b[j].corners < a[i].corners) {
      ++added;
      ++j;
    } else {
      if (a[i].odd != b[j].odd) {
        const Tet& tet = original.tets[a[i].tet];
        const int sign = orientation(original.position(tet[0]), original.position(tet[1]), original.position(tet[2]),
                                     original.position(tet[3]));
        if (sign <= 0) {
          ++turned;
        } else if (mirrored++ == 0) {
          first_mirrored = a[i].tet;
        }
      }
      ++i;
      ++j;
    }
  }
  if (missing > 0) {
    findings.wrong.push_back(counted(missing, "tet") + " of the original missing after full refinement, the first is " +
                             std::to_string(first_missing));
  }
  if (added > 0) findings.wrong.push_back(counted(added, "tet") + " after full refinement not in the original");
  if (mirrored > 0) {
    findings.wrong.push_back(counted(mirrored, "tet") + " of the original mirrored, the first is " +
                             std::to_string(first_mirrored));
  }
  if (turned > 0) findings.notes.push_back(counted(turned, "inverted or flat tet") + " of the original turned");
}

} // namespace

void compare_meshes(const TetMesh& original, const TetMesh& copy, Findings& findings) {
  if (!compare_layout(original, copy, findings)) return;
  std::vector<std::string> names;
  for (const PointArray& array : original.point_arrays)
    names.push_back(array.name);
  const Classes classes = classify(VertexRows(original, names), VertexRows(copy, names));
  if (classes.only_in_original > 0) {
    findings.wrong.push_back(counted(classes.only_in_original, "vertex") +
                             " of the original not in the file bit for bit, the first is " +
                             std::to_string(classes.first_missing));
  }
  if (classes.only_in_copy > 0) {
    findings.wrong.push_back(counted(classes.only_in_copy, "vertex") +
                             " after full refinement not in the original bit for bit");
  }
  if (classes.alike > 0) {
    findings.notes.push_back(counted(classes.alike, "vertex") +
                             " of the original equal another in position and all values; tets on them are compared "
                             "without telling these apart");
  }
  compare_tets(original, copy, classes, findings);
}

void add_reading_notes(const std::string& path, const ReadReport& read, std::vector<std::string>& notes) {
  for (const std::string& note : read.notes)
    if (!note.ends_with(" not carried")) notes.push_back("'" + path + "': " + note);
}

} // namespace ptet::cli
