// Everything that the run-time library makes of .ptet files, as text: one line for each table that it decodes and each
// mesh that it cuts out, numbers by their bits. The same on every machine, whatever its byte order and word size are.
//
//   decode FILE...
//
// Lines of tables end with a checksum (FNV-1a, 64 bits) of their numbers from the lowest byte to the highest.
#include "formats/ptet/reader.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"

#include <bit>
#include <cinttypes>
#include <cstdio>
#include <type_traits>

using namespace ptet;

namespace {

/// A checksum of numbers.
class Sum {
public:
  void add(std::uint64_t number) {
    for (int byte = 0; byte < 8; ++byte)
      sum_ = (sum_ ^ (number >> (8 * byte) & 0xFF)) * 0x100000001B3;
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  void add(const std::string& text) {
    add(std::uint64_t{text.size()});
    for (const char c : text)
      add(std::uint64_t{static_cast<unsigned char>(c)});
  }
  void add(const PointArray& array) {
    add(array.name);
    add(std::uint64_t{array.components});
    for (std::size_t at = 0; at < array.bytes.size(); at += size_of(array.type)) {
      dispatch(array.type, [&]<class T>(T) {
        const T number = load<T>(array.bytes.data() + at);
        if constexpr (std::is_same_v<T, float>)
          add(std::uint64_t{std::bit_cast<std::uint32_t>(number)});
        else if constexpr (std::is_same_v<T, double>)
          add(number);
        else
          add(static_cast<std::uint64_t>(number));
      });
    }
  }
  template <class Numbers>
  void add_all(const Numbers& numbers) {
    add(std::uint64_t{numbers.size()});
    for (const auto& number : numbers) {
      if constexpr (std::is_integral_v<std::decay_t<decltype(number)>>)
        add(static_cast<std::uint64_t>(number));
      else if constexpr (std::is_floating_point_v<std::decay_t<decltype(number)>>)
        add(number);
      else
        add(std::uint64_t{number.index()});
    }
  }
  [[nodiscard]] std::uint64_t sum() const { return sum_; }

private:
  std::uint64_t sum_ = 0xCBF29CE484222325;
};

void print_number(const char* name, double number) {
  std::printf(" %s=%.17g", name, number);
}

void print_errors(const char* name, std::span<const double> errors) {
  for (const double error : errors)
    print_number(name, error);
}

void print_sum(const char* name, const Sum& sum) {
  std::printf(" %s=%016" PRIx64, name, sum.sum());
}

/// The tables of the file as they are decoded.
void print_content(const std::string& path) {
  file::Reader reader(file::open_file(path));
  file::Content content = reader.read_base();
  std::vector<std::uint32_t> all(reader.blocks().size());
  for (std::uint32_t b = 0; b < all.size(); ++b)
    all[b] = b;
  reader.load(all, content);

  Sum table, values, versions, codes;
  for (const file::BlockInfo& block : reader.blocks()) {
    table.add(block.offset);
    table.add_all(block.box_min);
    table.add_all(block.box_max);
    table.add_all(block.max_error);
    table.add_all(block.squared_error);
    table.add_all(block.needs);
  }
  values.add(content.positions);
  for (const PointArray& array : content.arrays)
    values.add(array);
  const Refinement& refinement = content.refinement;
  for (std::uint32_t place = 0; place < refinement.base_place_count(); ++place)
    versions.add_all(refinement.base_tet(place));
  for (RecordId r{0}; r.index() < refinement.record_count(); r = RecordId{r.index() + 1}) {
    for (const Tet& tet : refinement.fine_tets(r))
      versions.add_all(tet);
    versions.add_all(refinement.parents(r));
  }
  codes.add_all(content.own);
  codes.add_all(content.monotone);
  codes.add_all(content.order);
  codes.add_all(content.squared_error);
  codes.add_all(content.generation);
  std::printf("content");
  print_sum("table", table);
  print_sum("values", values);
  print_sum("versions", versions);
  print_sum("codes", codes);
  std::printf("\n");
}

void print_extraction(const char* name, const Dataset& data, const Request& request) {
  const Extraction cut = data.extract(request);
  Sum vertices, tets, faces, origins;
  vertices.add(cut.mesh.positions);
  for (const PointArray& array : cut.mesh.point_arrays)
    vertices.add(array);
  vertices.add_all(cut.vertex_in_file);
  vertices.add_all(cut.input_vertex);
  for (const Tet& tet : cut.mesh.tets)
    tets.add_all(tet);
  for (const auto& face : cut.boundary_faces)
    faces.add_all(face);
  origins.add_all(cut.made_by);
  std::printf("%s: %zu vertices, %zu tets, %zu faces, %s", name, cut.mesh.vertex_count(), cut.mesh.tets.size(),
              cut.boundary_faces.size(), name_of(cut.limited_by));
  print_sum("vertices", vertices);
  print_sum("tets", tets);
  print_sum("faces", faces);
  print_sum("origins", origins);
  print_errors("error", cut.field_error);
  print_errors("rms", cut.rms_error);
  print_number("domain", cut.domain_error);
  print_number("read", static_cast<double>(cut.bytes_read));
  std::printf("\n");
}

void print_session(const char* name, Session& session, const Request& request) {
  const SessionUpdate& now = session.update(request);
  Sum tets, changed;
  for (const auto& tet : session.tets())
    tets.add_all(tet);
  changed.add_all(now.changed_tets);
  changed.add_all(now.changed_faces);
  changed.add_all(now.changed_vertices);
  std::printf("session, %s: %" PRIu64 " tets, %" PRIu64 " splits, %" PRIu64 " collapses", name, now.tets, now.splits,
              now.collapses);
  print_sum("tets", tets);
  print_sum("changed", changed);
  print_errors("error", now.field_error);
  print_errors("rms", now.rms_error);
  std::printf("\n");
}

void print_file(const std::string& path) {
  std::printf("== %s\n", path.substr(path.find_last_of('/') + 1).c_str());
  print_content(path);
  const auto data = Dataset::open(path);
  const DatasetInfo& info = data->info();
  std::printf("info: %" PRIu64 " vertices, %" PRIu64 " tets, %" PRIu64 " records, %" PRIu64 " blocks", info.vertices,
              info.tets, info.records, info.blocks);
  print_errors("most", info.max_field_error);
  print_number("domain", info.max_domain_error);
  std::printf(" %s\n", info.provenance_json.c_str());

  const Point middle{(info.box_min[0] + info.box_max[0]) / 2, (info.box_min[1] + info.box_max[1]) / 2,
                     (info.box_min[2] + info.box_max[2]) / 2};
  std::vector<std::pair<const char*, Request>> requests(7);
  requests[0].first = "the original";
  requests[1].first = "the base";
  requests[1].second.max_tets = 0;
  requests[2].first = "errors up to 5%";
  requests[2].second.field_error = {{"", {0.05, true}}};
  requests[2].second.origins = true;
  requests[3].first = "half of the vertices";
  requests[3].second.max_vertices = info.vertices / 2;
  requests[4].first = "a ball, and what is near it";
  requests[4].second.focus = {{Sphere{middle, 0.2 * info.diagonal}, {0, true}, Bound{0.3, true}}};
  requests[5].first = "some bytes";
  requests[5].second.max_bytes = 10000;
  requests[6].first = "boundaries up to 1%";
  requests[6].second.domain_error = Bound{0.01, true};
  Session session(data);
  for (const auto& [name, request] : requests)
    print_extraction(name, *data, request);
  Request ordered;
  ordered.input_order = true;
  if (info.has_input_order) print_extraction("in the order of the input", *data, ordered);
  for (const auto& [name, request] : requests)
    print_session(name, session, request);
}

} // namespace

int main(int count, char** arguments) {
  try {
    for (int i = 1; i < count; ++i)
      print_file(arguments[i]);
  } catch (const std::exception& error) {
    std::printf("error: %s\n", error.what());
    return 1;
  }
  return 0;
}
