#pragma once
#include <string>
#include <vector>

namespace innergs {

/// One table of `innergs experiment`. Cells are text as printed; a missing figure (e.g. not given in the
/// paper) is an empty cell.
struct ExperimentTable {
  std::string name;                 // of its CSV file, without ".csv"
  std::string title;                // one line
  std::vector<std::string> columns; // snake_case, units last
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> notes; // sentences: samples, definitions, caveats

  /// Throws Error(Internal) unless the row has one cell per column.
  void add(std::vector<std::string> row);
};

/// With fixed decimals; "inf" for infinity, "" for NaN.
std::string decimals(double value, int digits);

/// For reading: title, aligned columns ("-" for an empty cell), notes.
std::string textOf(const ExperimentTable& table);
/// RFC 4180: header and rows, without the notes.
std::string csvOf(const ExperimentTable& table);

} // namespace innergs
