#pragma once
#include <filesystem>
#include <string>

namespace innergs::bench {

/// `document` with the text between its markers replaced; throws Error(FileFormat) if a marker is missing.
std::string withNumbers(const std::string& document, const std::string& numbers);

/// A new document: headings and markers, for numbers and for text.
std::string emptyDocument();

} // namespace innergs::bench
