// Reads results back the way strangers would: CSV by its RFC, SVG as XML. Both small and strict.
#pragma once

#include <cctype>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace vt::bench {

// RFC 4180: fields by header name, one map a line. Empty when a line has another number of fields than the
// header.
inline std::vector<std::map<std::string, std::string>> parse_csv(std::string_view text) {
  std::vector<std::vector<std::string>> lines(1, std::vector<std::string>(1));
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      lines.back().back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && c == ',') {
      lines.back().emplace_back();
    } else if (!quoted && c == '\r' && i + 1 < text.size() && text[i + 1] == '\n') {
      lines.emplace_back(1);
      ++i;
    } else {
      lines.back().back() += c;
    }
  }
  lines.pop_back();  // what follows the last line end
  std::vector<std::map<std::string, std::string>> rows;
  for (std::size_t l = 1; l < lines.size(); ++l) {
    if (lines[l].size() != lines[0].size()) return {};
    rows.emplace_back();
    for (std::size_t f = 0; f < lines[l].size(); ++f) rows.back()[lines[0][f]] = lines[l][f];
  }
  return rows;
}

// What is wrong with `text` as an XML document of elements, quoted attributes, text and the five named
// entities; "" when nothing is.
inline std::string xml_complaint(std::string_view text) {
  std::vector<std::string> open;
  bool had_root = false;
  std::size_t i = 0;
  const auto name_at = [&] {
    const std::size_t start = i;
    while (i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) || text[i] == '-' || text[i] == ':')) ++i;
    return std::string(text.substr(start, i - start));
  };
  const auto entity_ok = [&] {
    for (const std::string_view entity : {"&amp;", "&lt;", "&gt;", "&quot;", "&apos;"})
      if (text.substr(i).starts_with(entity)) return true;
    return false;
  };
  if (text.starts_with("<?xml")) i = text.find("?>") + 2;
  while (i < text.size()) {
    if (text[i] != '<') {
      if (text[i] == '&' && !entity_ok()) return "a bare & at " + std::to_string(i);
      if (open.empty() && !std::isspace(static_cast<unsigned char>(text[i]))) return "text outside the root element";
      ++i;
      continue;
    }
    ++i;
    if (i < text.size() && text[i] == '/') {
      ++i;
      const std::string name = name_at();
      if (open.empty() || open.back() != name) return "</" + name + "> closes nothing";
      open.pop_back();
      if (i >= text.size() || text[i++] != '>') return "</" + name + " has no >";
      continue;
    }
    if (open.empty() && had_root) return "a second root element";
    had_root = true;
    const std::string name = name_at();
    if (name.empty()) return "an element without a name at " + std::to_string(i);
    std::map<std::string, bool> seen;
    while (true) {
      while (i < text.size() && std::isspace(static_cast<unsigned char>(text[i]))) ++i;
      if (i >= text.size()) return "<" + name + " never ends";
      if (text[i] == '>' || text[i] == '/') break;
      const std::string attribute = name_at();
      if (attribute.empty() || seen[attribute]) return "<" + name + ">: an attribute without a name, or twice";
      seen[attribute] = true;
      if (text.substr(i, 2) != "=\"") return "<" + name + ">: attribute " + attribute + " is not quoted";
      for (i += 2; i < text.size() && text[i] != '"'; ++i)
        if (text[i] == '<' || (text[i] == '&' && !entity_ok())) return "<" + name + ">: a bare < or & in attribute " + attribute;
      ++i;
    }
    if (text[i] == '/') {
      ++i;
    } else {
      open.push_back(name);
    }
    if (i >= text.size() || text[i++] != '>') return "<" + name + " has no >";
  }
  if (!open.empty()) return "<" + open.back() + "> is never closed";
  return had_root ? "" : "no element";
}

}  // namespace vt::bench
