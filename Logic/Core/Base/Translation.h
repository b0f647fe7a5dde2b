#pragma once

namespace innergs {

/// Marks a text for Qt's lupdate, in the context of this namespace; whoever shows the text translates it.
constexpr const char* tr(const char* text) {
  return text;
}

} // namespace innergs
