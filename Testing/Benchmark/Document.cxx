#include "Document.h"

#include "Core/Base/Error.h"

namespace innergs::bench {
namespace {
const std::string kBegin = "<!-- numbers: written by make bench -->\n", kEnd = "<!-- end of numbers -->\n";
}

std::string withNumbers(const std::string& document, const std::string& numbers) {
  const auto begin = document.find(kBegin);
  const auto end = begin == std::string::npos ? begin : document.find(kEnd, begin);
  if (end == std::string::npos)
    throw Error(ErrorCode::FileFormat,
                "The document lacks the lines between which the numbers stand: put back \"" +
                    kBegin.substr(0, kBegin.size() - 1) + "\" and \"" + kEnd.substr(0, kEnd.size() - 1) +
                    "\".");
  return document.substr(0, begin + kBegin.size()) + "\n" + numbers + "\n" + document.substr(end);
}

std::string emptyDocument() {
  return "# Benchmarks\n\n"
         "`make bench` measures everything between the two marks below on the machine it runs on. Targets "
         "stand beside the results.\n\n"
         "## Numbers\n\n" +
         kBegin + kEnd + "\n## What was tried\n";
}

} // namespace innergs::bench
