#pragma once
#include <string_view>

/// The files of Resources/Terminology, as text.
namespace innergs::terminology {

std::string_view anatomy();
std::string_view words();
std::string_view phrasesToTune();
std::string_view phrasesToReport();

} // namespace innergs::terminology
