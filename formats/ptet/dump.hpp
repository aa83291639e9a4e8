// A .ptet file as text, for people: what it holds, or every byte of it with its meaning.
#pragma once

#include <iosfwd>
#include <string>

namespace ptet::file {

/// Writes header, arrays, manifest, sections and block table of the file at `path`; with `annotate` instead every
/// range of bytes, with offset, hex and meaning, the decoded records too.
/// Throws Error: kIo, kCorruptFile.
void dump(std::ostream& out, const std::string& path, bool annotate);

} // namespace ptet::file
