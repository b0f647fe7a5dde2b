#pragma once
#include "Core/Base/Error.h"

#include <exception>
#include <functional>
#include <string>

namespace innergs {

/// Anything that was thrown, as people are told of it.
struct Failure {
  ErrorCode code = ErrorCode::Internal;
  std::string sentence; // one line that says what is wrong and what to do
};

/// The exception that is being handled, or the one given; does not throw it on.
Failure failureOf(const std::exception_ptr& thrown = std::current_exception());

/// Calls a task; the sentence for whatever it throws, "" when it went well.
std::string sentenceOf(const std::function<void()>& task);

} // namespace innergs
