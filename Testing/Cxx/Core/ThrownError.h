#pragma once
#include "Core/Base/Error.h"
#include "TextContains.h"

#include <gtest/gtest.h>

namespace innergs::test {

/// The error thrown by `work`; its message must be one line that ends with a full stop.
template <typename Work>
Error errorOf(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    const std::string sentence = error.what();
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
    EXPECT_EQ(sentence.empty() ? ' ' : sentence.back(), '.') << sentence;
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {ErrorCode::Internal, "nothing was thrown."};
}

template <typename Work>
ErrorCode codeOf(Work&& work) {
  return errorOf(work).code();
}

inline bool contains(const Error& error, const std::string& text) {
  return has(error.what(), text);
}

} // namespace innergs::test
