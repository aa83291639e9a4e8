// Files that appear whole: what becomes of the one that is replaced, and which names there are.
#include "formats/file_names.hpp"
#include "formats/ptet/source.hpp"
#include "formats/whole_file.hpp"
#include "support/temp_folder.hpp"

#include <catch2/catch.hpp>

namespace ptet {
namespace {

using test::read_bytes;
using test::TempFolder;
using test::write_bytes;

void write_whole(const std::string& path, const std::string& text) {
  WholeFile file(path);
  file.write(std::as_bytes(std::span(text)));
  file.commit();
}

unsigned mode_of(const std::string& path) {
  struct stat status {};
  REQUIRE(::stat(path.c_str(), &status) == 0);
  return status.st_mode & 07777;
}

TEST_CASE("a file that is replaced hands on who may read and write it", "[file]") {
  const TempFolder folder;
  const std::string path = folder / "kept";
  const unsigned mode = GENERATE(0600U, 0640U, 0644U, 0660U, 0755U);
  write_bytes(path, "old");
  REQUIRE(::chmod(path.c_str(), mode) == 0);
  write_whole(path, "new");
  CHECK(read_bytes(path) == "new");
  CHECK(mode_of(path) == mode);
}

TEST_CASE("a file that is replaced hands on its owner", "[file]") {
  if (::geteuid() != 0) return; // nobody else may give files away
  const TempFolder folder;
  const std::string path = folder / "kept";
  write_bytes(path, "old");
  REQUIRE(::chown(path.c_str(), 65534, 65534) == 0);
  REQUIRE(::chmod(path.c_str(), 0640) == 0);
  write_whole(path, "new");
  struct stat status {};
  REQUIRE(::stat(path.c_str(), &status) == 0);
  CHECK(status.st_uid == 65534);
  CHECK(status.st_gid == 65534);
  CHECK(mode_of(path) == 0640);
}

TEST_CASE("a new file is made as the mask has it", "[file]") {
  const TempFolder folder;
  const mode_t before = ::umask(027);
  write_whole(folder / "new", "text");
  ::umask(before);
  CHECK(mode_of(folder / "new") == 0640);
}

TEST_CASE("a file that is write-protected is not replaced", "[file]") {
  if (::geteuid() == 0) return; // nothing is protected from the superuser
  const TempFolder folder;
  const std::string path = folder / "kept";
  write_bytes(path, "old");
  REQUIRE(::chmod(path.c_str(), 0444) == 0);
  CHECK_THROWS_WITH(WholeFile(path), Catch::Contains(path + ": Permission denied"));
  CHECK(read_bytes(path) == "old");
  CHECK(folder.names().size() == 1);
}

TEST_CASE("a link stays a link, whether its file is there or not", "[file]") {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "elsewhere");
  std::filesystem::create_symlink("elsewhere/real", folder / "middle");
  std::filesystem::create_symlink(GENERATE(true, false) ? folder / "middle" : "middle", folder / "link");
  for (const char* text : {"first", "second"}) {
    write_whole(folder / "link", text);
    CHECK(std::filesystem::is_symlink(folder / "link"));
    CHECK(std::filesystem::is_symlink(folder / "middle"));
    CHECK(read_bytes(folder / "elsewhere" + "/real") == text);
  }
}

TEST_CASE("links in a ring are named", "[file]") {
  const TempFolder folder;
  std::filesystem::create_symlink("b", folder / "a");
  std::filesystem::create_symlink("a", folder / "b");
  CHECK_THROWS_WITH(WholeFile(folder / "a"), Catch::Contains(folder / "a") && Catch::Contains("links"));
}

TEST_CASE("the longest name that there can be is written", "[file]") {
  const TempFolder folder;
  const std::string longest(255, 'n');
  write_whole(folder / longest, "text");
  CHECK(folder.names() == std::vector{longest});
  CHECK_THROWS_WITH(WholeFile(folder / (longest + "n")), Catch::Contains("too long"));
  CHECK(folder.names().size() == 1);
}

TEST_CASE("a name with a zero byte is none", "[file]") {
  const TempFolder folder;
  CHECK_THROWS_WITH(WholeFile(folder / std::string("a\0b", 3)), Catch::Contains("zero byte"));
  CHECK(folder.names().empty());
  write_bytes(folder / "a", "text");
  CHECK_THROWS_WITH(file::open_file(folder / std::string("a\0b", 3)), Catch::Contains("zero byte"));
}

TEST_CASE("two names of one file are told", "[file]") {
  const TempFolder folder;
  CHECK(is_same_file(folder / "none", folder / "./none"));
  CHECK_FALSE(is_same_file(folder / "none", folder / "other"));
  CHECK(is_same_file("none", "./none"));
  write_bytes(folder / "here", "text");
  std::filesystem::create_hard_link(folder / "here", folder / "twin");
  CHECK(is_same_file(folder / "here", folder / "twin"));
  CHECK_FALSE(is_same_file(folder / "here", folder / "none"));
}

TEST_CASE("in a folder that is gone no two names are of one file", "[file]") {
  const TempFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::create_directory(folder / "gone");
  std::filesystem::current_path(folder / "gone");
  std::filesystem::remove(folder / "gone");
  CHECK_FALSE(is_same_file("a", "b"));
  std::filesystem::current_path(before);
}

} // namespace
} // namespace ptet
