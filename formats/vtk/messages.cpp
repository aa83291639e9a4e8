#include "formats/vtk/messages.hpp"

#include "ptet/error.hpp"

#include <cmath>

#include <vtkAlgorithm.h>
#include <vtkCommand.h>
#include <vtkLogger.h>
#include <vtkObjectFactory.h>

namespace ptet::vtkio {
namespace {

std::mutex window_mutex;

/// "ERROR: In x.cxx, line 9\nvtkReader (0x1234): The reason.\n\n" -> "The reason"
std::string reason_in(const std::string& text) {
  std::size_t begin = text.find("): ");
  begin = begin == std::string::npos ? 0 : begin + 3;
  std::string reason;
  for (const char c : text.substr(begin)) {
    const bool space = c == '\n' || c == '\t' || c == ' ';
    if (space && (reason.empty() || reason.back() == ' ')) continue;
    reason += space ? ' ' : c;
  }
  while (!reason.empty() && (reason.back() == ' ' || reason.back() == '.'))
    reason.pop_back();
  return reason;
}

} // namespace

class Messages::Window : public vtkOutputWindow {
public:
  static Window* New() { VTK_STANDARD_NEW_BODY(Window); }

  void DisplayText(const char* text) override { DisplayErrorText(text); }
  void DisplayErrorText(const char* text) override { errors.push_back(reason_in(text)); }
  void DisplayWarningText(const char* text) override { warnings.push_back(reason_in(text)); }
  void DisplayGenericWarningText(const char* text) override { DisplayWarningText(text); }
  void DisplayDebugText(const char*) override {}

  std::vector<std::string> errors;
  std::vector<std::string> warnings;
};

Messages::Messages()
    : only_(window_mutex), window_(vtkSmartPointer<Window>::New()), previous_(vtkOutputWindow::GetInstance()) {
  vtkOutputWindow::SetInstance(window_);
  // The logger is told of every error besides.
  previous_verbosity_ = vtkLogger::GetCurrentVerbosityCutoff();
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

Messages::~Messages() {
  vtkLogger::SetStderrVerbosity(vtkLogger::ConvertToVerbosity(previous_verbosity_));
  vtkOutputWindow::SetInstance(previous_);
}

const std::vector<std::string>& Messages::errors() const {
  return window_->errors;
}

const std::vector<std::string>& Messages::warnings() const {
  return window_->warnings;
}

void Messages::throw_on_error(const std::string& path) const {
  if (!errors().empty()) throw Error(ErrorCode::kBadInput, path + ": " + errors().front());
}

ProgressWatch::ProgressWatch(vtkAlgorithm& algorithm, const char* stage, const ProgressCallback& progress)
    : algorithm_(algorithm), stage_(stage), progress_(progress) {
  if (progress_) observer_ = algorithm_.AddObserver(vtkCommand::ProgressEvent, this, &ProgressWatch::on_progress);
}

ProgressWatch::~ProgressWatch() {
  if (progress_) algorithm_.RemoveObserver(observer_);
}

void ProgressWatch::on_progress() {
  if (cancelled_) return;
  const auto done = static_cast<std::uint64_t>(std::lround(1000 * algorithm_.GetProgress()));
  if (progress_({stage_, done, 1000})) return;
  cancelled_ = true;
  algorithm_.SetAbortExecute(1);
}

void ProgressWatch::throw_on_cancel() const {
  if (cancelled_) throw Error(ErrorCode::kCancelled, std::string(stage_) + " was cancelled");
}

} // namespace ptet::vtkio
