#include "vtkPtetReader.h"

#include "grid.hpp"
#include "opened_file.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkTransform.h>
#include <vtkUnstructuredGrid.h>

// NOLINTBEGIN(readability-identifier-naming): VTK's way
vtkStandardNewMacro(vtkPtetReader);

class vtkPtetReader::Internals {
public:
  std::optional<ptet::paraview::OpenedFile> File;
  std::string OpenedName;
  std::vector<std::string> Arrays;                ///< of the file
  std::map<std::string, bool> Statuses;           ///< as they were set, whether there are such arrays or not
  std::map<std::string, double> FieldErrorBounds; ///< percent
  std::array<double, 6> BoxPositionRange{0, 1, 0, 1, 0, 1};
  std::array<double, 6> BoxLengthRange{0, 1, 0, 1, 0, 1};
  std::array<double, 6> SphereCenterRange{0, 1, 0, 1, 0, 1};
  std::array<double, 2> SphereRadiusRange{0, 1};

  [[nodiscard]] bool IsWanted(const std::string& array) const {
    const auto found = Statuses.find(array);
    return found == Statuses.end() || found->second;
  }

  void Open(const char* name) {
    if (File && OpenedName == name) return;
    File.reset();
    File.emplace(name);
    OpenedName = name;
    OfferRegions();
  }

  [[nodiscard]] ptet::Request RequestOf(const vtkPtetReader& reader) const;

private:
  void OfferRegions() {
    const ptet::DatasetInfo& info = File->info();
    double least = info.diagonal;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double low = info.box_min[axis], length = info.box_max[axis] - low;
      SphereCenterRange[2 * axis] = BoxPositionRange[2 * axis] = low;
      BoxPositionRange[2 * axis + 1] = low + length / 2;
      BoxLengthRange[2 * axis + 1] = length;
      SphereCenterRange[2 * axis + 1] = info.box_max[axis];
      least = std::min(least, length);
    }
    SphereRadiusRange[1] = least / 2;
  }
};

namespace {

ptet::Bound percent(double value) {
  return {value / 100, true};
}

ptet::Region box_of(const double* position, const double* rotation, const double* length) {
  if (rotation[0] == 0 && rotation[1] == 0 && rotation[2] == 0) {
    ptet::Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.min[axis] = std::min(position[axis], position[axis] + length[axis]);
      box.max[axis] = std::max(position[axis], position[axis] + length[axis]);
    }
    return box;
  }
  vtkNew<vtkTransform> transform;
  transform->Translate(position);
  transform->RotateZ(rotation[2]);
  transform->RotateX(rotation[0]);
  transform->RotateY(rotation[1]);
  transform->Scale(length);
  ptet::OrientedBox box;
  transform->TransformPoint(ptet::Point{0.5, 0.5, 0.5}.data(), box.centre.data());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ptet::Point half{};
    half[axis] = 0.5;
    transform->TransformVector(half.data(), box.half_axes[axis].data());
  }
  return box;
}

} // namespace

ptet::Request vtkPtetReader::Internals::RequestOf(const vtkPtetReader& reader) const {
  ptet::Request request;
  for (const auto& [name, bound] : FieldErrorBounds)
    request.field_error.push_back({name, percent(bound)});
  for (const ptet::FieldInfo& field : File->info().fields)
    if (reader.BoundFieldErrors && field.governing && FieldErrorBounds.find(field.name) == FieldErrorBounds.end())
      request.field_error.push_back({field.name, percent(reader.FieldError)});
  if (reader.BoundDomainError) request.domain_error = percent(reader.DomainError);
  if (reader.LimitTets) request.max_tets = static_cast<std::uint64_t>(reader.MaximumTets);
  if (reader.FocusShape == NO_FOCUS) return request;

  ptet::Focus focus;
  if (reader.FocusShape == BOX)
    focus.region = box_of(reader.BoxPosition, reader.BoxRotation, reader.BoxLength);
  else
    focus.region =
        ptet::Sphere{{reader.SphereCenter[0], reader.SphereCenter[1], reader.SphereCenter[2]}, reader.SphereRadius};
  focus.error = percent(reader.FocusError);
  if (reader.UseFalloff) focus.falloff = percent(reader.Falloff);
  request.focus.push_back(focus);
  return request;
}

vtkPtetReader::vtkPtetReader() : Internal(std::make_unique<Internals>()) {
  SetNumberOfInputPorts(0);
}

vtkPtetReader::~vtkPtetReader() {
  delete[] FileName;
}

int vtkPtetReader::CanReadFile(const char* name) {
  static constexpr std::array<char, 8> kMagic = {'\x89', 'P', 'T', 'E', 'T', '\r', '\n', '\x1A'};
  std::array<char, 8> bytes{};
  std::ifstream file(name, std::ios::binary);
  return file.read(bytes.data(), bytes.size()) && bytes == kMagic ? 1 : 0;
}

int vtkPtetReader::GetNumberOfPointArrays() {
  return static_cast<int>(Internal->Arrays.size());
}

const char* vtkPtetReader::GetPointArrayName(int index) {
  return index >= 0 && index < GetNumberOfPointArrays() ? Internal->Arrays[static_cast<std::size_t>(index)].c_str()
                                                        : nullptr;
}

int vtkPtetReader::GetPointArrayStatus(const char* name) {
  return Internal->IsWanted(name) ? 1 : 0;
}

void vtkPtetReader::SetPointArrayStatus(const char* name, int status) {
  const bool was_wanted = Internal->IsWanted(name);
  Internal->Statuses[name] = status != 0;
  if (was_wanted != (status != 0)) Modified();
}

void vtkPtetReader::SetFieldErrorBound(const char* name, double bound) {
  // An empty row of a table that is being filled.
  if (!name || !*name) return;
  const auto [at, is_new] = Internal->FieldErrorBounds.try_emplace(name, bound);
  if (!is_new && at->second == bound) return;
  at->second = bound;
  Modified();
}

void vtkPtetReader::ClearFieldErrorBounds() {
  if (Internal->FieldErrorBounds.empty()) return;
  Internal->FieldErrorBounds.clear();
  Modified();
}

double* vtkPtetReader::GetBoxPositionRange() {
  return Internal->BoxPositionRange.data();
}
double* vtkPtetReader::GetBoxLengthRange() {
  return Internal->BoxLengthRange.data();
}
double* vtkPtetReader::GetSphereCenterRange() {
  return Internal->SphereCenterRange.data();
}
double* vtkPtetReader::GetSphereRadiusRange() {
  return Internal->SphereRadiusRange.data();
}

namespace {

unsigned long vtk_error_code(ptet::ErrorCode code) {
  switch (code) {
  case ptet::ErrorCode::kBadArgument: return vtkErrorCode::UserError;
  case ptet::ErrorCode::kCorruptFile: return vtkErrorCode::FileFormatError;
  case ptet::ErrorCode::kIo: return vtkErrorCode::CannotOpenFileError;
  default: return vtkErrorCode::UnknownError;
  }
}

/// What is missing and why.
std::string shortfall(const ptet::SessionUpdate& update) {
  std::string text = "the mesh is coarser than asked, its errors are true: ";
  if (update.failures.empty()) return text + "more blocks of the file do not fit into memory";
  const ptet::BlockFailure& first = update.failures.front();
  text += "block " + std::to_string(first.block);
  if (update.failures.size() > 1) text += " and " + std::to_string(update.failures.size() - 1) + " more";
  return text + " could not be had, " + first.message;
}

} // namespace

template <class Work>
int vtkPtetReader::Try(Work&& work) {
  const std::string name = FileName ? FileName : "";
  try {
    if (name.empty()) throw ptet::Error(ptet::ErrorCode::kBadArgument, "no file name");
    SetErrorCode(vtkErrorCode::NoError);
    work();
    return 1;
  } catch (const ptet::Error& error) {
    SetErrorCode(vtk_error_code(error.code()));
    vtkErrorMacro(<< name << ": " << error.what());
  } catch (const std::bad_alloc&) {
    SetErrorCode(vtkErrorCode::UnknownError);
    vtkErrorMacro(<< name << ": out of memory");
  }
  return 0;
}

int vtkPtetReader::RequestInformation(vtkInformation* /*request*/, vtkInformationVector** /*inputs*/,
                                      vtkInformationVector* outputs) {
  return Try([&] {
    Internal->Open(FileName);
    Internal->Arrays.clear();
    for (const ptet::FieldInfo& field : Internal->File->info().fields)
      Internal->Arrays.push_back(field.name);
    // The first piece is all of it.
    outputs->GetInformationObject(0)->Set(CAN_HANDLE_PIECE_REQUEST(), 1);
  });
}

int vtkPtetReader::RequestData(vtkInformation* /*request*/, vtkInformationVector** /*inputs*/,
                               vtkInformationVector* outputs) {
  vtkInformation* const wanted = outputs->GetInformationObject(0);
  vtkUnstructuredGrid* const grid = vtkUnstructuredGrid::GetData(wanted);
  if (wanted->Get(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER()) > 0) return 1;
  return Try([&] {
    Internal->Open(FileName);
    ptet::paraview::OpenedFile& file = *Internal->File;
    bool is_stopped = false;
    const ptet::SessionUpdate& update = file.update(Internal->RequestOf(*this), [&](const char* stage, double part) {
      SetProgressText(stage);
      UpdateProgress(part);
      is_stopped = GetAbortExecute() != 0;
      return !is_stopped;
    });
    ptet::paraview::fill_mesh(
        *grid, file.session(), file.info(), [&](const std::string& name) { return Internal->IsWanted(name); },
        GiveFileIds);
    ptet::paraview::fill_errors(*grid, update, file.info());
    // The next update goes on where this one was stopped.
    if (is_stopped) Modified();
    if (update.complete || is_stopped) return;
    SetErrorCode(vtk_error_code(update.failures.empty() ? ptet::ErrorCode::kLimit : update.failures.front().code));
    vtkErrorMacro(<< FileName << ": " << shortfall(update));
  });
}

void vtkPtetReader::PrintSelf(ostream& os, vtkIndent indent) {
  Superclass::PrintSelf(os, indent);
  const auto triple = [](const double* values) {
    return std::to_string(values[0]) + ' ' + std::to_string(values[1]) + ' ' + std::to_string(values[2]);
  };
  os << indent << "FileName: " << (FileName ? FileName : "(none)") << '\n';
  for (const std::string& name : Internal->Arrays)
    os << indent << "PointArray: " << name << (Internal->IsWanted(name) ? "" : " (off)") << '\n';
  os << indent << "BoundFieldErrors: " << BoundFieldErrors << '\n';
  os << indent << "FieldError: " << FieldError << '\n';
  for (const auto& [name, bound] : Internal->FieldErrorBounds)
    os << indent << "FieldErrorBound: " << name << ' ' << bound << '\n';
  os << indent << "BoundDomainError: " << BoundDomainError << '\n';
  os << indent << "DomainError: " << DomainError << '\n';
  os << indent << "LimitTets: " << LimitTets << '\n';
  os << indent << "MaximumTets: " << MaximumTets << '\n';
  os << indent << "FocusShape: " << FocusShape << '\n';
  os << indent << "BoxPosition: " << triple(BoxPosition) << '\n';
  os << indent << "BoxRotation: " << triple(BoxRotation) << '\n';
  os << indent << "BoxLength: " << triple(BoxLength) << '\n';
  os << indent << "SphereCenter: " << triple(SphereCenter) << '\n';
  os << indent << "SphereRadius: " << SphereRadius << '\n';
  os << indent << "FocusError: " << FocusError << '\n';
  os << indent << "UseFalloff: " << UseFalloff << '\n';
  os << indent << "Falloff: " << Falloff << '\n';
  os << indent << "GiveFileIds: " << GiveFileIds << '\n';
}
// NOLINTEND(readability-identifier-naming)
