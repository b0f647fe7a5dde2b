#pragma once
#include "Core/Base/Error.h"

#include <exception>
#include <functional>
#include <string>

namespace innergs {

/// An exception of any type, as reported to the user.
struct Failure {
  ErrorCode code = ErrorCode::Internal;
  std::string sentence; // one line that says what is wrong and what to do
};

/// The current exception, or the one given; does not rethrow it.
Failure failureOf(const std::exception_ptr& thrown = std::current_exception());

/// Runs a task and returns the sentence for whatever it throws; "" on success.
std::string sentenceOf(const std::function<void()>& task);

} // namespace innergs
