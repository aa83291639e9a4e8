// VTK's reader of VTU, without the trust that it puts in a file.
#pragma once

#include "formats/vtk/polyhedron_faces.hpp"
#include "formats/vtk/sources.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUnstructuredGridReader.h>

namespace ptet::vtkio {

/// VTK's reader of VTU, with what it takes on trust checked first, and arrays named apart: it finds an array by its
/// place among the enabled ones, and takes type and size of every piece's arrays from the first piece.
class CheckedReader : public vtkXMLUnstructuredGridReader {
public:
  static CheckedReader* New() { VTK_STANDARD_NEW_BODY(CheckedReader); }
  using Superclass = vtkXMLUnstructuredGridReader;

  using vtkXMLUnstructuredGridReader::GetNumberOfPieces;

  std::uint64_t file_bytes = 0;
  AnnouncedMesh announced;              ///< by every piece
  std::vector<std::string> cell_arrays; ///< of every piece: those left out
  std::vector<std::string> notes;       ///< of every piece
  PolyhedronFaces faces;                ///< of the piece that was read last

protected:
  void CreateXMLParser() override;

  /// VTK's reader takes the first grid, and says nothing of others.
  int ReadVTKFile(vtkXMLDataElement* file) override;

  using vtkXMLUnstructuredGridReader::ReadPiece;
  int ReadPiece(vtkXMLDataElement* piece) override;

  using vtkXMLUnstructuredGridReader::ReadPieceData;
  int ReadPieceData() override { return Superclass::ReadPieceData() && read_faces() ? 1 : 0; }

  /// The length of the connectivity is what the offsets say. One so long that its bytes cannot be counted would be read
  /// into a buffer that is too small.
  int ReadArrayValues(vtkXMLDataElement* element, vtkIdType array_index, vtkAbstractArray* array, vtkIdType start,
                      vtkIdType values, FieldType type) override;

private:
  bool can_hold(vtkXMLDataElement& element, std::int64_t values, vtkAbstractArray& array);

  /// VTK's reader takes numbers out of the range of some types for others, and of what it cannot read it says only that
  /// there is too little.
  int read_text(vtkXMLDataElement* element, vtkIdType array_index, vtkAbstractArray* array, vtkIdType start,
                vtkIdType values, FieldType type);

  /// More than an array should have is not to be told from values that belong elsewhere, as when their number of
  /// components is missing.
  bool has_all(vtkXMLDataElement& array, std::uint64_t there, vtkIdType values, FieldType type);

  /// VTK's writer puts the arrays of all time steps side by side, under the same names; in some modes all are called
  /// step 0. VTK's reader then takes the first of a name, or leaves what is not of its step as it finds it in memory.
  bool keep_last_step(vtkXMLDataElement& data);

  /// The last of the steps that an array is for; -1 when it is for all of them.
  static int last_step_of(vtkXMLDataElement& array);

  /// Whether an array has ghost flags, or the degrees of Lagrange's cells: others are not read.
  /// Of files before version 2 the reader makes ghost flags of levels, where they are bytes.
  bool tells_of_cells(vtkXMLDataElement& cell_data, vtkXMLDataElement& array);
  static std::string components_of(vtkXMLDataElement& array);
  /// Of what a piece says of its cells, that which has to be the same for all.
  std::string layout_of_cell_flags(vtkXMLDataElement* cell_data);

  /// VTK asks the first piece, which may be empty, what arrays there are, and leaves what another piece has not as it
  /// finds it in memory.
  bool check_cell_flags(vtkXMLDataElement* cell_data);

  void leave_out(vtkXMLDataElement& data);

  void leave_out_field_data();

  /// VTK's reader puts as many strings as the file has where there is room for as many as it should have.
  void leave_out_text(vtkXMLDataElement& data);

  void name_apart(vtkXMLDataElement& data);

  /// VTK takes what is not a number for one.
  bool has_components(vtkXMLDataElement& data);

  /// Least bytes of a row of all arrays of the element; types that are not numeric count as one byte.
  static double point_row_bytes(vtkXMLDataElement* data);

  static std::string layout_of(vtkXMLDataElement* data);

  /// Points of all cells of the piece, as the head of their array tells.
  std::uint64_t ids_of_cells();

  /// As the head of an array tells, of which one value is read. Nothing of text.
  std::optional<std::uint64_t> length_of(vtkXMLDataElement& array);

  /// VTK's reader follows faces through their table without a look at where that ends, and that of 9.1 does not know
  /// the layout of 9.4. So it gets to see neither.
  void take_face_arrays();
  /// Of all polyhedra, as the heads of the arrays tell, and what else they take as if it were corners.
  std::uint64_t corners_of_faces();

  /// Those of the piece's polyhedra.
  bool read_faces();

  /// What an array has: not all faces need be used.
  std::int64_t count_values(const std::string& name);

  /// One of the arrays of faces.
  bool read_integers(const std::string& name, std::int64_t count, Integers& to);

  /// First those of VTK up to 9.3, then those of later versions.
  static constexpr std::array<const char*, 6> kFaceArrays = {
      "faceoffsets", "faces", "polyhedron_offsets", "polyhedron_to_faces", "face_offsets", "face_connectivity"};
  std::vector<std::map<std::string, vtkSmartPointer<vtkXMLDataElement>>> face_arrays_; ///< by piece
  std::optional<std::string> first_layout_;      ///< of the first piece that has points
  std::optional<std::string> first_flag_layout_; ///< of the first piece that has cells
};

} // namespace ptet::vtkio
