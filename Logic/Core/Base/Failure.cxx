#include "Core/Base/Failure.h"

#include <algorithm>
#include <new>
#include <stdexcept>
#include <system_error>

namespace innergs {
namespace {

const char* const kNoMemory =
    "There is not enough memory: close other programs or volumes, or choose a smaller "
    "region, a coarser output or fewer Gaussians.";

const char* const kNoThread =
    "The system could not start another thread: close other programs or choose fewer threads, and try again.";

std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

} // namespace

Failure failureOf(const std::exception_ptr& thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
    return {};
  } catch (const Error& error) {
    return {error.code(), error.what()};
  } catch (const std::bad_alloc&) {
    return {ErrorCode::Memory, kNoMemory};
  } catch (const std::length_error&) { // from a container: larger than any memory
    return {ErrorCode::Memory, kNoMemory};
  } catch (const std::system_error& error) { // from files, folders, threads
    if (error.code() == std::errc::resource_unavailable_try_again) return {ErrorCode::Memory, kNoThread};
    return {ErrorCode::Io, "The system refused a request (" + oneLine(error.what()) +
                               "): check the file or folder, close other programs, and try again."};
  } catch (const std::exception& error) {
    return {ErrorCode::Internal, "Unexpected failure (" + oneLine(error.what()) +
                                     "): please report it with these data and settings."};
  } catch (...) {
    return {ErrorCode::Internal, "Unexpected failure: please report it with these data and settings."};
  }
}

std::string sentenceOf(const std::function<void()>& task) {
  try {
    task();
    return {};
  } catch (...) {
    return failureOf().sentence;
  }
}

} // namespace innergs
