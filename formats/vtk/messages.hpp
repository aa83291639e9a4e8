// What VTK would print while it reads or writes, caught: its readers report failure in no other way.
#pragma once

#include "ptet/progress.hpp"

#include <mutex>
#include <string>
#include <vector>

#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

class vtkAlgorithm;

namespace ptet::vtkio {

/// While one lives, VTK's errors and warnings, from whatever object, come here and go nowhere else. One at a time in a
/// process: a second waits for the first.
class Messages {
public:
  Messages();
  ~Messages();
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;

  /// The reasons VTK gave, first things first, without its source lines and addresses.
  [[nodiscard]] const std::vector<std::string>& errors() const;
  [[nodiscard]] const std::vector<std::string>& warnings() const;
  /// Throws Error(kBadInput), "path: reason", when there was an error.
  void throw_on_error(const std::string& path) const;

private:
  class Window;
  std::lock_guard<std::mutex> only_;
  vtkSmartPointer<Window> window_;
  vtkSmartPointer<vtkOutputWindow> previous_;
  int previous_verbosity_ = 0;
};

/// Passes an algorithm's progress to a callback while it lives, and the callback's wish to stop to the algorithm.
class ProgressWatch {
public:
  ProgressWatch(vtkAlgorithm& algorithm, const char* stage, const ProgressCallback& progress);
  ~ProgressWatch();
  ProgressWatch(const ProgressWatch&) = delete;
  ProgressWatch& operator=(const ProgressWatch&) = delete;

  /// Throws Error(kCancelled) when the callback has asked to stop.
  void throw_on_cancel() const;

private:
  void on_progress();

  vtkAlgorithm& algorithm_;
  const char* stage_;
  const ProgressCallback& progress_;
  unsigned long observer_ = 0;
  bool cancelled_ = false;
};

} // namespace ptet::vtkio
