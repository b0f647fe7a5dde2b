#include "Evaluation/ExperimentTable.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

std::string heading(std::string column) {
  std::replace(column.begin(), column.end(), '_', ' ');
  return column;
}

// In characters, not bytes: "42³" has three.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

bool isNumber(const std::string& cell) {
  return cell.empty() || cell == "inf" || cell.find_first_not_of("0123456789.,-") == std::string::npos;
}

std::string padded(const std::string& text, std::size_t size, bool right) {
  const std::string space(size - std::min(size, width(text)), ' ');
  return right ? space + text : text + space;
}

std::string csvCell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text)
    quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csvLine(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t n = 0; n < cells.size(); ++n)
    line += (n ? "," : "") + csvCell(cells[n]);
  return line + "\n";
}

} // namespace

void ExperimentTable::add(std::vector<std::string> row) {
  if (row.size() != columns.size())
    throw Error(ErrorCode::Internal, "A row of the table '" + name + "' does not have one cell per column.");
  rows.push_back(std::move(row));
}

std::string decimals(double value, int digits) {
  if (std::isnan(value)) return "";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return formatted("%.*f", digits, value);
}

std::string textOf(const ExperimentTable& table) {
  std::vector<std::size_t> widths;
  std::vector<bool> right;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    widths.push_back(width(heading(table.columns[c])));
    right.push_back(true);
    for (const auto& row : table.rows) {
      widths[c] = std::max({widths[c], width(row[c]), std::size_t{1}});
      if (!isNumber(row[c])) right[c] = false;
    }
  }
  const auto line = [&](const auto& cell) {
    std::string text;
    for (std::size_t c = 0; c < widths.size(); ++c)
      text += (c ? "  " : "") + padded(cell(c), widths[c], right[c]);
    text.erase(text.find_last_not_of(' ') + 1);
    return text + "\n";
  };
  std::string text = table.title + "\n" + line([&](std::size_t c) { return heading(table.columns[c]); });
  for (const auto& row : table.rows)
    text += line([&](std::size_t c) { return row[c].empty() ? std::string("-") : row[c]; });
  for (const auto& note : table.notes)
    text += "Note: " + note + "\n";
  return text + "\n";
}

std::string csvOf(const ExperimentTable& table) {
  std::string text = csvLine(table.columns);
  for (const auto& row : table.rows)
    text += csvLine(row);
  return text;
}

} // namespace innergs
