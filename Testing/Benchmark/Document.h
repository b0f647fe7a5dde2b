#pragma once
#include <filesystem>
#include <string>

namespace innergs::bench {

/// `document` with what stands between its markers replaced; throws Error(FileFormat) when a marker is
/// missing.
std::string withNumbers(const std::string& document, const std::string& numbers);

/// A new document: headings and markers, for numbers and for what people write.
std::string emptyDocument();

} // namespace innergs::bench
