// Results as rows under named columns, printed from the same numbers for people, as Markdown, as CSV and as
// JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace vt::bench {

// Empty where a row has no such figure.
using Cell = std::variant<std::monostate, std::string, double>;

struct Column {
  std::string key;    // in CSV and JSON, with its unit: "median_s"
  std::string title;  // for people; empty: not shown to them
  int decimals = 1;   // for people; CSV and JSON have six significant digits
};

class Table {
 public:
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  // As many cells as columns.
  void add_row(std::vector<Cell> cells);
  // Cells by the key of their column, so that no figure lands in a neighbour's; columns that are not named
  // stay empty.
  void add_named_row(const std::vector<std::pair<std::string_view, Cell>>& cells);

  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::string markdown() const;         // what text() shows
  [[nodiscard]] std::string csv() const;              // RFC 4180 with a header line
  [[nodiscard]] nlohmann::ordered_json json() const;  // an array of objects; empty cells are null

 private:
  [[nodiscard]] bool is_number(std::size_t column) const;  // has no text

  std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
};

}  // namespace vt::bench
