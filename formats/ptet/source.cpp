#include "formats/ptet/source.hpp"

#include "ptet/error.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace ptet::file {
namespace {

class FileSource final : public Source {
public:
  explicit FileSource(const std::string& path) : path_(path), handle_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (handle_ < 0) fail("cannot open", errno);
    struct stat status {};
    if (::fstat(handle_, &status) != 0) close_and_fail("cannot open", errno);
    if (S_ISDIR(status.st_mode)) close_and_fail("cannot open", EISDIR);
    if (!S_ISREG(status.st_mode)) close_and_fail("cannot read other than a regular file:", EINVAL);
    size_ = static_cast<std::uint64_t>(status.st_size);
  }
  ~FileSource() override { ::close(handle_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  [[nodiscard]] std::uint64_t size() const override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    while (!into.empty()) {
      const ssize_t got = ::pread(handle_, into.data(), into.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail("cannot read", errno);
      if (got == 0) throw Error(ErrorCode::kIo, "cannot read " + path_ + ": it ends early", offset);
      offset += static_cast<std::uint64_t>(got);
      into = into.subspan(static_cast<std::size_t>(got));
    }
  }

private:
  [[noreturn]] void fail(const std::string& what, int reason) const {
    throw Error(ErrorCode::kIo, what + " " + path_ + ": " + std::strerror(reason));
  }
  [[noreturn]] void close_and_fail(const std::string& what, int reason) const {
    ::close(handle_);
    fail(what, reason);
  }

  std::string path_;
  int handle_;
  std::uint64_t size_ = 0;
};

class MemorySource final : public Source {
public:
  explicit MemorySource(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    if (offset > bytes_.size() || into.size() > bytes_.size() - offset) {
      throw Error(ErrorCode::kIo, "cannot read beyond the end of the bytes", offset);
    }
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
  }

private:
  std::vector<std::byte> bytes_;
};

class UserSource final : public Source {
public:
  explicit UserSource(std::shared_ptr<ByteSource> source) : source_(std::move(source)) {
    if (!source_) throw Error(ErrorCode::kBadArgument, "there is no source to read from");
    size_ = source_->size();
  }
  [[nodiscard]] std::uint64_t size() const override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    if (offset > size_ || into.size() > size_ - offset)
      throw Error(ErrorCode::kIo, "cannot read beyond the end of the source", offset);
    if (!into.empty()) source_->read(offset, into);
  }

private:
  std::shared_ptr<ByteSource> source_;
  std::uint64_t size_ = 0;
};

} // namespace

std::unique_ptr<Source> open_file(const std::string& path) {
  return std::make_unique<FileSource>(path);
}

std::unique_ptr<Source> over_memory(std::vector<std::byte> bytes) {
  return std::make_unique<MemorySource>(std::move(bytes));
}

std::unique_ptr<Source> over(std::shared_ptr<ByteSource> source) {
  return std::make_unique<UserSource>(std::move(source));
}

} // namespace ptet::file
