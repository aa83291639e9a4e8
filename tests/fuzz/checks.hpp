// What targets share: how a broken promise ends the program, which errors are promised, what a mesh must be.
#pragma once

#include "formats/ptet/reader.hpp"
#include "ptet/dataset.hpp"

#include <string>

namespace ptet::fuzz {

/// Says what is broken, and aborts: libFuzzer keeps the input then.
[[noreturn]] void fail(const std::string& what);

/// Small enough that what passes them is quick, and that libFuzzer sees an allocation beyond them.
[[nodiscard]] OpenOptions small_limits();

/// What a damaged file may be refused with: as corrupt, with a place, or as too large.
void check_refusal(const Error& error);

/// Conforming, complete in itself, its boundary the faces of one tet.
void check_mesh(const Extraction& extraction);

/// Everything decoded; refused with an Error, or sound.
[[nodiscard]] file::Content load_all(file::Reader& reader);

} // namespace ptet::fuzz
