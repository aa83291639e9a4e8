#pragma once

namespace ptet {

/// Version of the library and of the program, "major.minor.patch".
inline constexpr const char* kVersion = "0.1.0";

} // namespace ptet
