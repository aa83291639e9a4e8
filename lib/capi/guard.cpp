#include "capi/guard.hpp"

#include "ptet/version.hpp"

#include <limits>
#include <new>
#include <optional>

// NOLINTBEGIN(readability-identifier-naming): the names of the C interface
struct ptet_error {
  ptet_status status;
  std::string message;
  std::optional<std::uint64_t> offset;
};
// NOLINTEND(readability-identifier-naming)

namespace ptet::capi {
namespace {

/// Handed out when there is no memory for another; never freed. Short enough to need no memory of its own.
ptet_error& out_of_memory() noexcept {
  static ptet_error error{PTET_OUT_OF_MEMORY, "out of memory", {}};
  return error;
}

ptet_status put(ptet_error** error, ptet_status status, const char* message,
                std::optional<std::uint64_t> offset = {}) noexcept {
  if (error == nullptr) return status;
  try {
    *error = new ptet_error{status, message, offset};
  } catch (...) {
    *error = &out_of_memory();
  }
  return status;
}

} // namespace

ptet_status status_of(ErrorCode code) {
  switch (code) {
  case ErrorCode::kBadArgument: return PTET_BAD_ARGUMENT;
  case ErrorCode::kBadInput: return PTET_BAD_INPUT;
  case ErrorCode::kCorruptFile: return PTET_CORRUPT_FILE;
  case ErrorCode::kLimit: return PTET_LIMIT;
  case ErrorCode::kIo: return PTET_IO_ERROR;
  case ErrorCode::kCancelled: return PTET_CANCELLED;
  }
  return PTET_INTERNAL_ERROR;
}

ptet_status report_exception(ptet_error** error) noexcept {
  try {
    throw;
  } catch (const Error& known) {
    return put(error, status_of(known.code()), known.what(), known.byte_offset());
  } catch (const std::bad_alloc&) {
    if (error != nullptr) *error = &out_of_memory();
    return PTET_OUT_OF_MEMORY;
  } catch (const std::length_error&) { // more than any memory holds
    if (error != nullptr) *error = &out_of_memory();
    return PTET_OUT_OF_MEMORY;
  } catch (const std::exception& unknown) {
    return put(error, PTET_INTERNAL_ERROR, unknown.what());
  } catch (...) {
    return put(error, PTET_INTERNAL_ERROR, "an exception of unknown type");
  }
}

void refuse(const std::string& why) {
  throw Error(ErrorCode::kBadArgument, why);
}

ProgressCallback progress_through(ptet_progress_callback callback, void* user) {
  if (callback == nullptr) return {};
  return [callback, user](const Progress& progress) {
    return callback(std::string(progress.stage).c_str(), progress.done, progress.total, user) == 0;
  };
}

} // namespace ptet::capi

using ptet::capi::out_of_memory;

uint32_t ptet_abi_version(void) {
  return PTET_ABI_VERSION;
}

const char* ptet_version(void) {
  return ptet::kVersion;
}

const char* ptet_status_name(ptet_status status) {
  switch (status) {
  case PTET_OK: return "ok";
  case PTET_INTERNAL_ERROR: return "internal error";
  case PTET_BAD_ARGUMENT: return "bad argument";
  case PTET_BAD_INPUT: return "bad input";
  case PTET_CORRUPT_FILE: return "corrupt file";
  case PTET_LIMIT: return "limit";
  case PTET_IO_ERROR: return "input or output failed";
  case PTET_OUT_OF_MEMORY: return "out of memory";
  case PTET_CANCELLED: return "cancelled";
  default: return "unknown";
  }
}

ptet_status ptet_error_status(const ptet_error* error) {
  return error == nullptr ? PTET_OK : error->status;
}

const char* ptet_error_message(const ptet_error* error) {
  return error == nullptr ? "" : error->message.c_str();
}

uint64_t ptet_error_offset(const ptet_error* error) {
  return error == nullptr || !error->offset ? std::numeric_limits<std::uint64_t>::max() : *error->offset;
}

void ptet_error_free(ptet_error* error) {
  if (error != &out_of_memory()) delete error;
}
