// A session's mesh as a VTK grid. Points come in the order of their ids in the file, tets in that of their points, so
// that the same mesh is the same grid, whatever the session's slots are.
#pragma once

#include <functional>
#include <string>

#include <ptet/dataset.hpp>
#include <ptet/session.hpp>

class vtkUnstructuredGrid;

namespace ptet::paraview {

/// Puts points, tets and those point arrays into `grid` of which `wanted(name)`; with `file_ids` also the ids of the
/// points in the file as global ids, called "vertex in file".
void fill_mesh(vtkUnstructuredGrid& grid, const Session& session, const DatasetInfo& info,
               const std::function<bool(const std::string&)>& wanted, bool file_ids);

/// Field data, one value each: "error of NAME" and "RMS error of NAME" for each governing field in its units (the
/// latter where the build measured it, as "covered", the part of the original's volume), "domain error" in those of the
/// mesh, "limited by" (name_of), "complete" (1, or 0 where the mesh is coarser than asked), "tets of the original",
/// "points of the original".
void fill_errors(vtkUnstructuredGrid& grid, const SessionUpdate& update, const DatasetInfo& info);

} // namespace ptet::paraview
