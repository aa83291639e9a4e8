# Writes what tells one builder from another: a hash of the sources that decide what is built, and what they are
# compiled with. A checkpoint is gone on with by the same builder only.
#
#   cmake -D SOURCE_DIR=... -D COMPILER=... -D OUTPUT=builder_id.hpp -P builder_id.cmake
file(GLOB_RECURSE sources ${SOURCE_DIR}/lib/mesh/* ${SOURCE_DIR}/lib/error/* ${SOURCE_DIR}/lib/record/*
     ${SOURCE_DIR}/lib/build/* ${SOURCE_DIR}/lib/include/ptet/build.hpp ${SOURCE_DIR}/formats/ptet/archive.hpp)
list(SORT sources)
set(hashes "")
foreach(source IN LISTS sources)
  file(SHA256 ${source} hash)
  string(APPEND hashes ${hash})
endforeach()
string(SHA256 hash "${hashes}")
string(SUBSTRING ${hash} 0 16 hash)
file(WRITE ${OUTPUT} "#pragma once
namespace ptet::build {
inline constexpr const char* kBuilderId = \"sources ${hash}, ${COMPILER}\";
} // namespace ptet::build
")
