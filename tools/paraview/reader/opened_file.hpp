// A .ptet file that stays open, and the mesh that follows what is asked of it. Blocks are read by a thread of the
// library's, so that the caller can be told how far it is, and may stop waiting.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <ptet/dataset.hpp>
#include <ptet/session.hpp>

namespace ptet::paraview {

/// Told what is done and how far it is, 0 to 1; false stops.
using ShowProgress = std::function<bool(const char* stage, double part)>;

class OpenedFile {
public:
  /// Throws Error: kIo, kCorruptFile, kLimit.
  explicit OpenedFile(const std::string& path);

  [[nodiscard]] const DatasetInfo& info() const { return dataset_->info(); }
  [[nodiscard]] const Session& session() const { return session_; }

  /// Makes the session's mesh that of `request`. What comes back is not complete where `show_progress` stopped it or
  /// blocks cannot be had: the mesh is then conforming and coarser, and its errors are those stated.
  /// Throws Error(kBadArgument); std::bad_alloc.
  const SessionUpdate& update(Request request, const ShowProgress& show_progress);

private:
  class CountingFile;

  std::shared_ptr<CountingFile> file_;
  std::shared_ptr<const Dataset> dataset_;
  Session session_;
};

} // namespace ptet::paraview
