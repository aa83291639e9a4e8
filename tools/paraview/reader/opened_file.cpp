#include "opened_file.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <fstream>
#include <system_error>

#include <ptet/source.hpp>

namespace ptet::paraview {

/// A file that knows how much of it was read.
class OpenedFile::CountingFile : public ByteSource {
public:
  explicit CountingFile(const std::string& path) : path_(path) {
    errno = 0;
    stream_.open(path, std::ios::binary | std::ios::ate);
    const std::streamoff end = stream_ ? std::streamoff(stream_.tellg()) : -1;
    if (end < 0) throw Error(ErrorCode::kIo, "cannot open " + path + reason());
    size_ = static_cast<std::uint64_t>(end);
  }

  std::uint64_t size() override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    errno = 0;
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(offset));
    stream_.read(reinterpret_cast<char*>(into.data()), static_cast<std::streamsize>(into.size()));
    if (!stream_) throw Error(ErrorCode::kIo, "cannot read " + path_ + reason());
    bytes_read_ += into.size();
  }

  [[nodiscard]] std::uint64_t bytes_read() const { return bytes_read_; }

private:
  static std::string reason() { return errno == 0 ? "" : ": " + std::generic_category().message(errno); }

  std::string path_;
  std::ifstream stream_;
  std::uint64_t size_ = 0;
  std::atomic<std::uint64_t> bytes_read_{0};
};

namespace {

OpenOptions in_background() {
  OpenOptions options;
  options.background = true;
  return options;
}

} // namespace

OpenedFile::OpenedFile(const std::string& path)
    : file_(std::make_shared<CountingFile>(path)), dataset_(Dataset::open(file_, in_background())), session_(dataset_) {
}

const SessionUpdate& OpenedFile::update(Request request, const ShowProgress& show_progress) {
  constexpr double kMillisecondsBetweenLooks = 100;
  request.max_milliseconds = kMillisecondsBetweenLooks;
  const std::uint64_t before = file_->bytes_read();
  // At most all that is not read yet.
  const auto part = [&] {
    const auto left = static_cast<double>(std::max(file_->size(), before + 1) - before);
    return std::min(1.0, static_cast<double>(file_->bytes_read() - before) / left);
  };
  for (;;) {
    const SessionUpdate& update = session_.update(request);
    if (update.complete) return update;
    const bool is_reading = update.limited_by == LimitedBy::kLoading;
    if (!is_reading && update.limited_by != LimitedBy::kTime) return update;
    if (!show_progress(is_reading ? "reading" : "refining", part())) return update;
    if (!is_reading) continue;
    try {
      dataset_->wait_until_loaded([&](const Progress&) { return show_progress("reading", part()); });
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCancelled) throw;
      return update;
    }
  }
}

} // namespace ptet::paraview
