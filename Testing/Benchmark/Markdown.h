#pragma once
#include <string>
#include <vector>

namespace innergs::bench {

/// A Markdown table with padded columns, so that it reads as plain text.
class MarkdownTable {
public:
  explicit MarkdownTable(std::vector<std::string> head) : rows_{std::move(head)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  std::string text() const;

private:
  std::vector<std::vector<std::string>> rows_;
};

std::string fixed(double value, int digits); // "–" if not finite
std::string withSign(double value, int digits);
/// "yes", or "no" and by how much it is missed.
std::string verdict(bool met, double distance, int digits, const std::string& unit);

} // namespace innergs::bench
