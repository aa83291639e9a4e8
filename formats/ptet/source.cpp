#include "formats/ptet/source.hpp"

#include "ptet/error.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace ptet::file {
namespace {

class FileSource final : public ByteSource {
public:
  // Without O_NONBLOCK a pipe that nobody writes to is waited for, for ever; of a regular file it changes nothing.
  explicit FileSource(const std::string& path)
      : path_(path), handle_(::open(whole(path), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    if (handle_ < 0) fail("cannot open", errno);
    struct stat status {};
    if (::fstat(handle_, &status) != 0) close_and_fail("cannot open", errno);
    if (S_ISDIR(status.st_mode)) close_and_fail("cannot open", EISDIR);
    if (!S_ISREG(status.st_mode)) close_and_fail("cannot open", "it is not a regular file");
    size_ = static_cast<std::uint64_t>(status.st_size);
  }
  ~FileSource() override { ::close(handle_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::uint64_t size() override { return size_; }
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
  /// The name as the system takes it, which ends at a zero byte.
  static const char* whole(const std::string& path) {
    if (const auto zero = path.find('\0'); zero != std::string::npos)
      throw Error(ErrorCode::kBadArgument,
                  "cannot open " + path.substr(0, zero) + "...: the name has a zero byte in it");
    return path.c_str();
  }
  [[noreturn]] void fail(const std::string& what, int reason) const { fail(what, std::strerror(reason)); }
  [[noreturn]] void fail(const std::string& what, const char* reason) const {
    throw Error(ErrorCode::kIo, what + " " + path_ + ": " + reason);
  }
  template <class Reason>
  [[noreturn]] void close_and_fail(const std::string& what, Reason reason) const {
    ::close(handle_);
    fail(what, reason);
  }

  std::string path_;
  int handle_;
  std::uint64_t size_ = 0;
};

class MemorySource final : public ByteSource {
public:
  explicit MemorySource(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t size() override { return bytes_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    if (offset > bytes_.size() || into.size() > bytes_.size() - offset) {
      throw Error(ErrorCode::kIo, "cannot read beyond the end of the bytes", offset);
    }
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
  }

private:
  std::vector<std::byte> bytes_;
};

/// What the source says; what it throws is an Error(kIo) then.
template <class F>
decltype(auto) ask(std::uint64_t offset, F&& f) {
  try {
    return f();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kIo) throw;
    throw Error(ErrorCode::kIo, error.what(), offset);
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kIo, std::string("cannot read from the source: ") + error.what(), offset);
  }
}

std::shared_ptr<ByteSource> required(std::shared_ptr<ByteSource> source) {
  if (!source) throw Error(ErrorCode::kBadArgument, "there is no source to read from");
  return source;
}

} // namespace

std::unique_ptr<ByteSource> open_file(const std::string& path) {
  return std::make_unique<FileSource>(path);
}

std::unique_ptr<ByteSource> over_memory(std::vector<std::byte> bytes) {
  return std::make_unique<MemorySource>(std::move(bytes));
}

RangeReader::RangeReader(std::shared_ptr<ByteSource> source, std::uint64_t max_gap)
    : source_(required(std::move(source))), size_(ask(0, [this] { return source_->size(); })), max_gap_(max_gap) {}

std::vector<std::byte> RangeReader::read(ByteRange range) {
  if (range.offset > size_ || range.count > size_ - range.offset)
    throw Error(ErrorCode::kCorruptFile, "the file is corrupt: it ends within a part of it", size_);
  if (range.count > std::vector<std::byte>().max_size()) // where memory has 32-bit addresses
    throw Error(ErrorCode::kLimit, "a part of the file does not fit into memory", range.offset);
  std::vector<std::byte> bytes(range.count);
  ++requests_;
  ask(range.offset, [&] {
    const std::lock_guard alone(mutex_);
    source_->read(range.offset, bytes);
  });
  bytes_ += range.count;
  return bytes;
}

void RangeReader::read_each(std::span<const ByteRange> ranges, const IsWanted& is_wanted, const RangeRead& done,
                            const std::function<bool()>& is_stopped) {
  const auto is_over = [&] { return is_stopped && is_stopped(); };
  std::vector<std::size_t> together;
  for (std::size_t next = 0; next < ranges.size();) {
    together.clear();
    std::uint64_t begin = 0, end = 0;
    for (; next < ranges.size(); ++next) {
      const ByteRange& range = ranges[next];
      const std::uint64_t range_end = range.offset + range.count;
      if (!together.empty() && (range.offset - end > max_gap_ || range_end - begin > kLongestRequest)) break;
      if (!is_wanted(next)) continue;
      if (together.empty()) begin = range.offset;
      together.push_back(next);
      end = range_end;
    }
    std::optional<std::vector<std::byte>> bytes;
    if (together.size() > 1) {
      if (is_over()) return;
      try {
        bytes = read({begin, end - begin});
      } catch (const Error&) {
      }
    }
    for (const std::size_t i : together) {
      RangeBytes one;
      if (bytes) {
        const auto first = bytes->begin() + static_cast<std::ptrdiff_t>(ranges[i].offset - begin);
        one.bytes.assign(first, first + static_cast<std::ptrdiff_t>(ranges[i].count));
      } else {
        if (!is_wanted(i)) continue; // not any more
        if (is_over()) return;
        try {
          one.bytes = read(ranges[i]);
        } catch (const Error&) {
          one.failure = std::current_exception();
        }
      }
      done(i, std::move(one));
    }
  }
}

std::vector<RangeBytes> RangeReader::read_all(std::span<const ByteRange> ranges) {
  std::vector<RangeBytes> result(ranges.size());
  read_each(
      ranges, [](std::size_t) { return true; }, [&](std::size_t i, RangeBytes read) { result[i] = std::move(read); });
  return result;
}

} // namespace ptet::file
