#pragma once
#include <string>
#include <vector>

namespace innergs {

/// One table of `innergs experiment`. Cells are text as printed; an empty cell is a figure that does not
/// exist (the paper gives none).
struct ExperimentTable {
  std::string name;                 // of its CSV file, without ".csv"
  std::string title;                // one line
  std::vector<std::string> columns; // snake_case, units last
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> notes; // sentences: samples, definitions, reservations

  /// Throws Error(Internal) when a row has not one cell per column.
  void add(std::vector<std::string> row);
};

/// Fixed decimals; "inf" and "" for what is infinite or not a number.
std::string decimals(double value, int digits);

/// For people: the title, aligned columns ("-" where a cell is empty), the notes.
std::string textOf(const ExperimentTable& table);
/// RFC 4180: a heading and the rows; without the notes.
std::string csvOf(const ExperimentTable& table);

} // namespace innergs
