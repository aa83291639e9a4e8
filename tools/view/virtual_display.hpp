// A display for VTK to draw on. Debian's VTK draws through X only, so where there is none pictures are made on a
// virtual one: Xvfb, started by us and ended with us.
#pragma once

#include <string>

#include <sys/types.h>

struct _XDisplay; // X11's, whose headers define macros

namespace ptet::view {

/// Whether an X server answers for $DISPLAY.
[[nodiscard]] bool has_display();

/// Runs Xvfb while it lives, and sets DISPLAY to it.
class VirtualDisplay {
public:
  /// Throws Error(kIo) when there is no Xvfb, or it does not start within some seconds.
  VirtualDisplay();
  ~VirtualDisplay();
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }

private:
  void stop();

  pid_t server_ = -1;
  _XDisplay* connection_ = nullptr; ///< the server ends with the last one
  std::string name_;
};

} // namespace ptet::view
