#include "tools/vtbench/report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>

namespace vt::bench {
namespace {

std::string for_people(const Cell& cell, int decimals) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  const auto* number = std::get_if<double>(&cell);
  return number == nullptr ? "" : fmt::format("{:.{}f}", *number, decimals);
}

// Six digits for measurements; whole numbers (bytes, counts) in full.
std::string number_text(double value) {
  if (value == std::floor(value) && std::abs(value) < 9e15) return fmt::format("{:.0f}", value);
  return fmt::format("{:.6g}", value);
}

std::string for_csv(const Cell& cell) {
  if (const auto* number = std::get_if<double>(&cell)) return std::isfinite(*number) ? number_text(*number) : "inf";
  const auto* text = std::get_if<std::string>(&cell);
  if (text == nullptr) return "";
  if (text->find_first_of(",\"\r\n") == std::string::npos) return *text;
  std::string quoted = "\"";
  for (const char c : *text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

// A cell of a pipe table.
std::string escaped_for_markdown(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '|') out += '\\';
    out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out;
}

}  // namespace

void Table::add_row(std::vector<Cell> cells) {
  assert(cells.size() == columns_.size());
  rows_.push_back(std::move(cells));
}

void Table::add_named_row(const std::vector<std::pair<std::string_view, Cell>>& cells) {
  std::vector<Cell> row(columns_.size());
  for (const auto& [key, cell] : cells) {
    const auto column = std::find_if(columns_.begin(), columns_.end(), [&](const Column& c) { return c.key == key; });
    assert(column != columns_.end());
    if (column != columns_.end()) row[static_cast<std::size_t>(column - columns_.begin())] = cell;
  }
  rows_.push_back(std::move(row));
}

bool Table::is_number(std::size_t column) const {
  return std::none_of(rows_.begin(), rows_.end(), [&](const auto& row) { return std::holds_alternative<std::string>(row[column]); });
}

std::string Table::markdown() const {
  std::string header = "|";
  std::string rule = "|";
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (columns_[c].title.empty()) continue;
    header += " " + escaped_for_markdown(columns_[c].title) + " |";
    rule += is_number(c) ? " ---: |" : " --- |";
  }
  std::string out = header + "\n" + rule + "\n";
  for (const auto& row : rows_) {
    out += "|";
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (!columns_[c].title.empty()) out += " " + escaped_for_markdown(for_people(row[c], columns_[c].decimals)) + " |";
    out += "\n";
  }
  return out;
}

std::string Table::text() const {
  std::string out;
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    widths.push_back(columns_[c].title.size());
    for (const auto& row : rows_) widths.back() = std::max(widths.back(), for_people(row[c], columns_[c].decimals).size());
  }
  const auto add_line = [&](const auto& cell_text, const auto& is_number) {
    std::string line;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].title.empty()) continue;
      const std::string cell = cell_text(c);
      line += is_number(c) ? fmt::format("{:>{}}  ", cell, widths[c]) : fmt::format("{:<{}}  ", cell, widths[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  };
  const auto column_is_number = [&](std::size_t c) { return is_number(c); };
  add_line([&](std::size_t c) { return columns_[c].title; }, column_is_number);
  for (const auto& row : rows_) add_line([&](std::size_t c) { return for_people(row[c], columns_[c].decimals); }, column_is_number);
  return out;
}

std::string Table::csv() const {
  std::string out;
  for (std::size_t c = 0; c < columns_.size(); ++c) out += (c == 0 ? "" : ",") + columns_[c].key;
  out += "\r\n";
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < row.size(); ++c) out += (c == 0 ? "" : ",") + for_csv(row[c]);
    out += "\r\n";
  }
  return out;
}

nlohmann::ordered_json Table::json() const {
  auto out = nlohmann::ordered_json::array();
  for (const auto& row : rows_) {
    nlohmann::ordered_json object;
    for (std::size_t c = 0; c < row.size(); ++c) {
      auto& value = object[columns_[c].key];
      if (const auto* text = std::get_if<std::string>(&row[c])) value = *text;
      // JSON has no infinity: an error of zero has no decibels.
      if (const auto* number = std::get_if<double>(&row[c]); number != nullptr && std::isfinite(*number)) value = *number;
    }
    out.push_back(std::move(object));
  }
  return out;
}

}  // namespace vt::bench
