// The builder: from a prepared mesh to the records of its collapses.
//
//   resume      the collapses of a checkpoint      \  made again,
//   follow      what pieces of the mesh decided    /  without searching (replay.hpp)
//   rounds      all other collapses (rounds.hpp)
//   certify     where they are to be exact and were not measured before: field errors (certify.hpp)
//   cut         dependencies between records (cut_conflicts.hpp)
//
// Who waits is told how far it is; checkpoints are kept between rounds and while errors are certified.
//
// Source: Cignoni et al. 2000, sections 3 and 4.
#pragma once

#include "build/field_samples.hpp"
#include "build/mesh_scales.hpp"
#include "mesh/prepare.hpp"
#include "ptet/build.hpp"
#include "record/stream.hpp"

namespace ptet::build {

struct Decisions;

/// Throws Error(kBadArgument) for options that are out of range or contradict one another.
void check_options(const BuildOptions& options);

/// Collapses `prepared` as far as the options allow. `report` receives what is known after the collapses.
/// `decided`: what was decided in pieces of the mesh, to be made first; null: nothing. Every piece is followed as far
/// as its collapses are possible here, that is to its end but where the limit on the domain error is near: bounds of it
/// are sharper or blunter by what else of the boundary is at hand. options.pieces is not looked at.
/// The tets of `prepared` are put away while it is collapsed, to save their memory, and there again afterwards, unless
/// it throws. Throws Error: kBadArgument (options, unknown field, a checkpoint of another build), kBadInput (values
/// that are not finite), kLimit, kCorruptFile and kIo (of checkpoints), kCancelled.
[[nodiscard]] RecordStream build_records(PreparedMesh& prepared, const BuildOptions& options, BuildReport& report,
                                         const ProgressCallback& progress, const Decisions* decided = nullptr);

/// The collapses of a part of a mesh alone, with the errors known while collapsing: nothing is measured afterwards, and
/// there are no dependencies beyond the versions.
/// The stream has no slots, and so is not valid. `part`: its tets are gone afterwards. `whole`: the mesh that it is a
/// part of. `samples`: in tets of the part, where the evaluation looks at samples. Throws Error as build_records does.
[[nodiscard]] RecordStream collapse_part(PreparedMesh& part, const BuildOptions& options, const MeshScales& whole,
                                         std::span<const Sample> samples, BuildReport& report,
                                         const ProgressCallback& progress);

} // namespace ptet::build
