// What the viewer draws, without a window: against brute force, and against VTK's own filters.
#include "formats/ptet/writer.hpp"
#include "support/file_parts.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "tools/view/caption.hpp"
#include "tools/view/number.hpp"
#include "tools/view/scene.hpp"
#include "tools/view/to_vtk.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <optional>
#include <thread>

#include <catch2/catch.hpp>
#include <vtkCellArray.h>
#include <vtkContourFilter.h>
#include <vtkCutter.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTriangleFilter.h>
#include <vtkUnstructuredGrid.h>

using namespace ptet;
using namespace ptet::view;

namespace {

const std::vector<std::byte>& content() {
  static const std::vector<std::byte> bytes = [] {
    const TetMesh mesh = test::grid({{6, 5, 5}, {}, 2, 3});
    return file::encode(mesh, test::simplify_naively(mesh), {});
  }();
  return bytes;
}

std::shared_ptr<const Dataset> dataset() {
  static const auto opened = Dataset::open_memory(content());
  return opened;
}

Point middle() {
  const DatasetInfo& info = dataset()->info();
  Point p{};
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = (info.box_min[i] + info.box_max[i]) / 2;
  return p;
}

Plane tilted_plane() {
  const Point p = middle();
  return {{0.3, -1, 0.2}, 0.3 * p[0] - p[1] + 0.2 * p[2] + 0.37};
}

Settings settings_for(Show show) {
  Settings settings;
  settings.show = show;
  settings.plane = tilted_plane();
  settings.error = 0.2;
  settings.focus = Sphere{middle(), 0.2 * dataset()->info().diagonal};
  return settings;
}

Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Sums over polygons cut into triangles: area, first moments, the value's integral, the volume inside.
struct Sums {
  double area = 0, value = 0, volume = 0;
  Point moment{};

  void add(const Point& a, const Point& b, const Point& c, double mean_value) {
    const Point normal = cross(minus(b, a), minus(c, a));
    const double triangle = std::sqrt(dot(normal, normal)) / 2;
    area += triangle;
    value += triangle * mean_value;
    volume += dot(a, normal) / 6;
    for (std::size_t i = 0; i < 3; ++i)
      moment[i] += triangle * (a[i] + b[i] + c[i]) / 3;
  }
};

Sums sums_of(const Polygons& polygons) {
  Sums sums;
  for (std::size_t p = 0; p < polygons.count(); ++p) {
    const auto row = [&](std::int64_t i) { return static_cast<std::size_t>(polygons.corners.at(std::size_t(i))); };
    for (std::int64_t i = polygons.offsets[p] + 1; i + 1 < polygons.offsets[p + 1]; ++i) {
      const std::size_t a = row(polygons.offsets[p]), b = row(i), c = row(i + 1);
      const double value = polygons.cell_values.empty()
                               ? (polygons.point_values[a] + polygons.point_values[b] + polygons.point_values[c]) / 3
                               : polygons.cell_values[p];
      sums.add(polygons.points[a], polygons.points[b], polygons.points[c], value);
    }
  }
  return sums;
}

Sums sums_of(vtkAlgorithm& filter) {
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputConnection(filter.GetOutputPort());
  triangles->Update();
  vtkPolyData* const data = triangles->GetOutput();
  vtkDataArray* const values = data->GetPointData()->GetArray("colour");
  Sums sums;
  vtkNew<vtkIdList> corners;
  for (vtkIdType t = 0; t < data->GetNumberOfPolys(); ++t) {
    data->GetCellPoints(t, corners);
    std::array<Point, 3> p{};
    double value = 0;
    for (vtkIdType i = 0; i < 3; ++i) {
      data->GetPoint(corners->GetId(i), p[static_cast<std::size_t>(i)].data());
      value += values->GetTuple1(corners->GetId(i)) / 3;
    }
    sums.add(p[0], p[1], p[2], value);
  }
  return sums;
}

void check_alike(const Sums& a, const Sums& b) {
  const auto near = [](double x) { return Approx(x).epsilon(1e-9).margin(1e-9); };
  CHECK(a.area == near(b.area));
  CHECK(a.value == Approx(b.value).epsilon(0).margin(1e-7 * a.area)); // signs cancel, values are up to hundreds
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(a.moment[i] == near(b.moment[i]));
}

double pressure(const TetMesh& mesh, std::size_t v) {
  return mesh.find("pressure")->value(v, 0);
}

/// The extraction as VTK's grid, coloured by "colour", with "level" to contour.
vtkSmartPointer<vtkUnstructuredGrid> grid_of(const TetMesh& mesh) {
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkDoubleArray> colour, level;
  colour->SetName("colour");
  level->SetName("level");
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    points->InsertNextPoint(mesh.position(VertexId{v}).data());
    colour->InsertNextValue(pressure(mesh, v));
    level->InsertNextValue(pressure(mesh, v));
  }
  vtkNew<vtkCellArray> cells;
  for (const Tet& tet : mesh.tets) {
    cells->InsertNextCell(4);
    for (const VertexId v : tet)
      cells->InsertCellPoint(v.index());
  }
  grid->SetPoints(points);
  grid->SetCells(VTK_TETRA, cells);
  grid->GetPointData()->AddArray(colour);
  grid->GetPointData()->SetScalars(level);
  return grid;
}

double volume_of(const TetMesh& mesh, const Tet& tet) {
  const Point a = mesh.position(tet[0]);
  return dot(minus(mesh.position(tet[1]), a), cross(minus(mesh.position(tet[2]), a), minus(mesh.position(tet[3]), a))) /
         6;
}

using PointFace = std::array<Point, 3>; // ascending

/// The faces that one of the tets has alone, with the tet.
std::map<PointFace, std::size_t> outer_faces(const TetMesh& mesh, const std::vector<char>& is_kept) {
  std::map<PointFace, std::vector<std::size_t>> tets_at;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t left_out = 0; is_kept[t] != 0 && left_out < 4; ++left_out) {
      PointFace face{};
      for (std::size_t i = 0, n = 0; i < 4; ++i)
        if (i != left_out) face[n++] = mesh.position(mesh.tets[t][i]);
      std::sort(face.begin(), face.end());
      tets_at[face].push_back(t);
    }
  }
  std::map<PointFace, std::size_t> outer;
  for (const auto& [face, tets] : tets_at)
    if (tets.size() == 1) outer[face] = tets.front();
  return outer;
}

/// Each polygon is one of `outer`, and all of those are there.
void check_faces(const Polygons& polygons, const std::map<PointFace, std::size_t>& outer) {
  REQUIRE(polygons.count() == outer.size());
  std::map<PointFace, std::size_t> seen;
  for (std::size_t p = 0; p < polygons.count(); ++p) {
    REQUIRE(polygons.offsets[p + 1] - polygons.offsets[p] == 3);
    PointFace face{};
    for (std::size_t i = 0; i < 3; ++i)
      face[i] = polygons.points.at(static_cast<std::size_t>(polygons.corners.at(3 * p + i)));
    std::sort(face.begin(), face.end());
    REQUIRE(outer.count(face) == 1);
    REQUIRE(seen.emplace(face, p).second);
  }
}

std::vector<Point> sorted_corners(const Polygons& polygons) {
  std::vector<Point> corners;
  for (const std::int64_t row : polygons.corners)
    corners.push_back(polygons.points[static_cast<std::size_t>(row)]);
  std::sort(corners.begin(), corners.end());
  return corners;
}

/// Each cell as its corners with what colours them, and it.
std::vector<std::vector<double>> sorted_cells(const Cells& cells) {
  std::vector<std::vector<double>> rows;
  for (std::size_t t = 0; t < cells.tets.size(); ++t) {
    std::vector<std::array<double, 4>> corners;
    for (const std::int64_t v : cells.tets[t]) {
      const auto row = static_cast<std::size_t>(v);
      const Point& p = cells.points[row];
      corners.push_back({p[0], p[1], p[2], cells.point_values.empty() ? 0 : cells.point_values[row]});
    }
    std::sort(corners.begin(), corners.end());
    std::vector<double> cell{cells.cell_values.empty() ? 0 : cells.cell_values[t]};
    for (const auto& corner : corners)
      cell.insert(cell.end(), corner.begin(), corner.end());
    rows.push_back(cell);
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

} // namespace

TEST_CASE("the boundary is drawn whole, outward") {
  Scene scene(dataset());
  const Settings settings = settings_for(Show::kSurface);
  const Frame& frame = scene.step(settings);
  REQUIRE(frame.is_complete);
  const Extraction expected = dataset()->extract(request_of(settings));
  REQUIRE(expected.mesh.tets.size() < dataset()->info().tets);
  CHECK(frame.tets == expected.mesh.tets.size());
  check_faces(frame.polygons, outer_faces(expected.mesh, std::vector<char>(expected.mesh.tets.size(), 1)));
  double volume = 0;
  for (const Tet& tet : expected.mesh.tets)
    volume += volume_of(expected.mesh, tet);
  CHECK(sums_of(frame.polygons).volume == Approx(volume));
}

TEST_CASE("cells cut open are the whole cells behind the plane") {
  for (const ColourKind kind : {ColourKind::kField, ColourKind::kLevel}) {
    Settings settings = settings_for(Show::kCells);
    settings.colour.kind = kind;
    for (const double shift : {-20.0, 0.0, 13.0, 1000.0}) {
      settings.plane = tilted_plane();
      settings.plane.offset += shift;
      Scene scene(dataset());
      const Frame& frame = scene.step(settings);
      Request request = request_of(settings);
      request.origins = true;
      const Extraction expected = dataset()->extract(request);
      const TetMesh& mesh = expected.mesh;
      std::vector<char> is_kept;
      double volume = 0;
      for (const Tet& tet : mesh.tets) {
        double sum = 0;
        for (const VertexId v : tet)
          sum += settings.plane.distance(mesh.position(v));
        is_kept.push_back(sum <= 0 ? 1 : 0);
        if (sum <= 0) volume += volume_of(mesh, tet);
      }
      const auto outer = outer_faces(mesh, is_kept);
      check_faces(frame.polygons, outer);
      CHECK(sums_of(frame.polygons).volume == Approx(volume));
      if (kind == ColourKind::kField) continue;
      const std::vector<double> levels = levels_of_tets(*dataset(), expected.made_by);
      REQUIRE(frame.polygons.cell_values.size() == outer.size());
      for (std::size_t p = 0; p < frame.polygons.count(); ++p) {
        PointFace face{};
        for (std::size_t i = 0; i < 3; ++i)
          face[i] = frame.polygons.points[static_cast<std::size_t>(frame.polygons.corners[3 * p + i])];
        std::sort(face.begin(), face.end());
        REQUIRE(frame.polygons.cell_values[p] == levels[outer.at(face)]);
      }
    }
  }
}

TEST_CASE("slices are those of VTK's cutter") {
  Scene scene(dataset());
  const Settings settings = settings_for(Show::kSlice);
  const Frame& frame = scene.step(settings);
  const Extraction expected = dataset()->extract(request_of(settings));
  vtkNew<vtkPlane> plane;
  plane->SetNormal(settings.plane.normal[0], settings.plane.normal[1], settings.plane.normal[2]);
  const double scale = settings.plane.offset / dot(settings.plane.normal, settings.plane.normal);
  plane->SetOrigin(scale * settings.plane.normal[0], scale * settings.plane.normal[1],
                   scale * settings.plane.normal[2]);
  vtkNew<vtkCutter> cutter;
  cutter->SetInputData(grid_of(expected.mesh));
  cutter->SetCutFunction(plane);
  const Sums sums = sums_of(frame.polygons);
  REQUIRE(sums.area > 1000);
  check_alike(sums, sums_of(*cutter));
}

TEST_CASE("isosurfaces are those of VTK's contour filter") {
  Scene scene(dataset());
  Settings settings = settings_for(Show::kIsosurface);
  CHECK(scene.step(settings).polygons.count() == 0); // at no value
  const Range range = scene.frame().range;
  settings.isovalue = 0.6 * range.least + 0.4 * range.most;
  const Frame& frame = scene.step(settings);
  const Extraction expected = dataset()->extract(request_of(settings));
  vtkNew<vtkContourFilter> contour;
  contour->SetInputData(grid_of(expected.mesh));
  contour->SetValue(0, *settings.isovalue);
  const Sums sums = sums_of(frame.polygons);
  REQUIRE(sums.area > 100);
  check_alike(sums, sums_of(*contour));
  CHECK(sums.value == Approx(sums.area * *settings.isovalue));
}

TEST_CASE("a scene that followed a focus shows what a new one shows") {
  Scene surface(dataset());
  const Range range = surface.step(settings_for(Show::kSurface)).range;
  for (const Show show : {Show::kSurface, Show::kCells, Show::kSlice, Show::kIsosurface, Show::kVolume})
    for (const ColourKind kind : {ColourKind::kField, ColourKind::kError, ColourKind::kLevel}) {
      Scene moving(dataset());
      Settings settings = settings_for(show);
      settings.colour.kind = kind;
      for (int i = 0; i < 14; ++i) {
        Point centre = middle();
        centre[0] += (i - 6) * 6;
        settings.focus = Sphere{centre, 0.15 * dataset()->info().diagonal};
        settings.error = i % 3 == 0 ? std::nullopt : std::optional(0.05 * i);
        settings.isovalue = 0.6 * range.least + 0.4 * range.most;
        if (i == 9) settings.error = 0; // and from the original back to few tets
        if (i == 4) settings.colour.kind = ColourKind::kField;
        if (i == 6) settings.colour.kind = kind;
        if (i == 7) settings.plane.offset += 0.5;
        // In bounded steps, the last of which changes nothing.
        while (!moving.step(settings, 0.02).is_complete) {
        }
      }
      CHECK(moving.frame().number > 6);
      Scene fresh(dataset());
      (void)fresh.step(settings);
      CHECK(moving.frame().tets == fresh.frame().tets);
      CHECK(moving.frame().field_error == fresh.frame().field_error);
      if (kind != ColourKind::kField) CHECK(moving.frame().range == fresh.frame().range);
      if (show == Show::kVolume) {
        CHECK(moving.frame().cells.tets.size() == fresh.frame().tets);
        CHECK(sorted_cells(moving.frame().cells) == sorted_cells(fresh.frame().cells));
        continue;
      }
      CHECK(moving.frame().polygons.count() > 0);
      CHECK(sorted_corners(moving.frame().polygons) == sorted_corners(fresh.frame().polygons));
      CHECK(sums_of(moving.frame().polygons).value == Approx(sums_of(fresh.frame().polygons).value));
    }
}

TEST_CASE("a scene does not wait for blocks, and gets there") {
  std::atomic<bool> is_held = true;
  const auto source = std::make_shared<test::FailingSource>(content());
  OpenOptions options;
  options.background = true;
  const auto slow = Dataset::open(source, options);
  source->set([&](std::uint64_t, std::uint64_t) {
    while (is_held)
      std::this_thread::yield();
    return false;
  });
  Scene scene(slow);
  const Settings settings = settings_for(Show::kSurface);
  const Frame& frame = scene.step(settings);
  CHECK_FALSE(frame.is_complete);
  CHECK(frame.limited_by == LimitedBy::kLoading);
  CHECK(frame.tets == slow->info().base_tets);
  CHECK(frame.polygons.count() > 0);
  CHECK(caption("a", slow->info(), settings, frame).find("\nloading ...") != std::string::npos);
  is_held = false;
  while (!scene.step(settings).is_complete)
    slow->wait_until_loaded();
  CHECK(frame.tets == dataset()->extract(request_of(settings)).mesh.tets.size());
}

TEST_CASE("blocks that cannot be had are told of, and not waited for") {
  const auto source = std::make_shared<test::FailingSource>(content());
  const auto broken = Dataset::open(source);
  source->set([](std::uint64_t, std::uint64_t) { return true; });
  Scene scene(broken);
  const Settings settings = settings_for(Show::kSurface);
  const Frame& frame = scene.step(settings);
  CHECK(frame.is_complete);
  CHECK(frame.limited_by == LimitedBy::kUnreadable);
  CHECK(frame.failure_code == ErrorCode::kIo);
  CHECK(caption("a", broken->info(), settings, frame).find("the line is dead") != std::string::npos);
}

TEST_CASE("the same again makes nothing new") {
  Scene scene(dataset());
  Settings settings = settings_for(Show::kSlice);
  const std::uint64_t number = scene.step(settings).number;
  CHECK(scene.step(settings).number == number);
  settings.isovalue = 1; // not of a slice
  CHECK(scene.step(settings).number == number);
  settings.plane.offset += 1;
  CHECK(scene.step(settings).number == number + 1);
}

TEST_CASE("errors and levels of tets") {
  Settings settings;
  settings.error = 0.15;
  settings.colour.kind = ColourKind::kError;
  Scene scene(dataset());
  const Frame& frame = scene.step(settings);
  const Extraction extraction = dataset()->extract(request_of(settings));
  const std::vector<double> errors = errors_of_tets(*dataset(), extraction.made_by);
  const std::vector<double> levels = levels_of_tets(*dataset(), extraction.made_by);
  double largest = 0, achieved = 0;
  for (std::size_t t = 0; t < errors.size(); ++t) {
    CHECK((levels[t] == 0) == extraction.made_by[t].is_none());
    if (extraction.made_by[t].is_none()) CHECK(errors[t] == 0);
    largest = std::max(largest, errors[t]);
  }
  for (std::size_t f = 0; f < extraction.field_error.size(); ++f)
    achieved = std::max(achieved, 100 * extraction.field_error[f] / dataset()->info().fields[f].range);
  CHECK(largest <= 15);
  CHECK(largest > 1);
  CHECK(largest == Approx(achieved));
  CHECK(frame.range.least == 0);
  CHECK(frame.range.most == largest);
  // Of the base mesh the last collapses: it has an eighth of the vertices or less.
  Request base;
  base.max_tets = 0;
  base.origins = true;
  const Extraction coarse = dataset()->extract(base);
  const std::vector<double> of_base = levels_of_tets(*dataset(), coarse.made_by);
  const double expected =
      std::floor(std::log2(double(dataset()->info().vertices) / double(coarse.mesh.vertex_count())));
  CHECK(*std::max_element(of_base.begin(), of_base.end()) >= expected);
  CHECK(*std::max_element(of_base.begin(), of_base.end()) <= expected + 1);
}

TEST_CASE("nothing asked is the base mesh, and 0 the original") {
  Scene scene(dataset());
  CHECK(scene.step({}).tets == dataset()->info().base_tets);
  Settings settings;
  settings.error = 0;
  CHECK(scene.step(settings).tets == dataset()->info().tets);
  CHECK(scene.frame().limited_by == LimitedBy::kNothing);
}

TEST_CASE("VTK is handed the frame's own memory") {
  Scene scene(dataset());
  const Frame& frame = scene.step(settings_for(Show::kSlice));
  const auto surface = to_vtk(frame.polygons);
  CHECK(surface->GetNumberOfPolys() == static_cast<vtkIdType>(frame.polygons.count()));
  CHECK(surface->GetPoints()->GetVoidPointer(0) == static_cast<const void*>(frame.polygons.points.data()));
  CHECK(surface->GetPointData()->GetScalars()->GetNumberOfTuples() == surface->GetNumberOfPoints());
  const auto volume = to_vtk(scene.step(settings_for(Show::kVolume)).cells);
  CHECK(volume->GetNumberOfCells() == static_cast<vtkIdType>(frame.tets));
}

TEST_CASE("numbers have the digits that tell them apart") {
  CHECK(brief_within(1, 0.123456) == "0.1235");
  CHECK(brief_within(1e4, 9999) == "9999");
  CHECK(brief_within(9, 101326.5) == "101326.5");
  CHECK(brief_within(0.08, 293.1532) == "293.1532");
  CHECK(brief_within(0, 101326.5) == "101326.5");
  CHECK(brief_within(1e-30, 1) == "1");
  CHECK(digits_within(1, 0) == 4);
}

TEST_CASE("a plane across an axis is told by its place on it, whichever way it points") {
  Plane plane{{0, -2, 0}, -3};
  CHECK(plane.axis() == std::optional<std::size_t>(1));
  CHECK(plane.place() == 1.5);
  plane.move_to(-0.25);
  CHECK(plane.distance({7, -0.25, 7}) == 0);
  CHECK(plane.normal == Point{0, -2, 0});
  Plane askew{{1, 1, 0}, 4};
  CHECK_FALSE(askew.axis());
  CHECK(askew.place() == 4);
  askew.move_to(2);
  CHECK(askew.offset == 2);
}

TEST_CASE("the caption says what was asked and achieved") {
  Scene scene(dataset());
  Settings settings = settings_for(Show::kCells);
  settings.error = 0.015;
  const std::string text = caption("room.ptet", dataset()->info(), settings, scene.step(settings));
  CHECK(text.find("room.ptet: cells cut open\nasked: error 1.5%, the original in the focus\n") == 0);
  CHECK(text.find("\nachieved: pressure ") != std::string::npos);
  CHECK(text.find(" of " + std::to_string(dataset()->info().tets) + " tets") != std::string::npos);
  CHECK(text.find("loading") == std::string::npos);
  CHECK(text.find("beside the mesh") == std::string::npos);
  settings.focus = Sphere{{100, 100, 100}, 1};
  CHECK(
      caption("room.ptet", dataset()->info(), settings, scene.step(settings)).find("\nthe focus is beside the mesh") !=
      std::string::npos);
}
