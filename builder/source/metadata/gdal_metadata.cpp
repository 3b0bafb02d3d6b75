#include "builder/source/metadata/gdal_metadata.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <pugixml.hpp>

#include "builder/source/files/file_bytes.h"

namespace vt::source {
namespace {

constexpr std::uint64_t kMostAuxBytes = std::uint64_t{16} << 20;

std::string_view trimmed(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\0'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

Result<double> parse_number(std::string_view what, std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return fail(ErrorCode::kInvalidData, fmt::format("the {} '{}' is not a number", what, text.substr(0, 40)));
  return value;
}

// False: the text is not XML. Like GDAL we go on without it, but we say so.
bool parse_xml(std::string_view text, pugi::xml_document& document, DeclaredMetadata& declared) {
  // Entities of a document type are not expanded by this parser, so a small text stays small.
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed) declared.not_read.push_back(fmt::format("a text that is no XML ({} at byte {})", parsed.description(), parsed.offset));
  return static_cast<bool>(parsed);
}

// A fact of one band by the name that GDAL gives it. Unknown names are none of ours.
Result<void> note(std::string_view name, std::string_view text, DeclaredBand& band) {
  if (name == "scale") {
    VT_ASSIGN(band.scale, parse_number(name, text));
  } else if (name == "offset") {
    VT_ASSIGN(band.offset, parse_number(name, text));
  } else if (name == "unittype") {
    band.unit = trimmed(text).substr(0, 60);
  } else if (name == "colorinterp") {
    band.role_name = trimmed(text).substr(0, 60);
  }
  return {};
}

}  // namespace

BandRole role_from_name(std::string_view name) {
  struct Row {
    std::string_view name;
    BandRole role;
  };
  constexpr std::array<Row, 6> kRoles{{{"Gray", BandRole::kGrey},
                                       {"Red", BandRole::kRed},
                                       {"Green", BandRole::kGreen},
                                       {"Blue", BandRole::kBlue},
                                       {"Alpha", BandRole::kCoverage},
                                       {"Palette", BandRole::kIndex}}};
  const auto* const found = std::ranges::find(kRoles, name, &Row::name);
  return found == kRoles.end() ? BandRole::kOther : found->role;
}

std::optional<double> parse_nodata(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  if (text.starts_with("-1.#INF")) return -std::numeric_limits<double>::infinity();
  if (text.starts_with("1.#INF")) return std::numeric_limits<double>::infinity();
  if (text.starts_with("-1.#") || text.starts_with("1.#")) return std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status == std::errc::result_out_of_range) {  // 1e-400 or 1e400
    return text.find("e-") != std::string_view::npos ? 0.0
           : text.starts_with('-')                   ? -std::numeric_limits<double>::infinity()
                                                     : std::numeric_limits<double>::infinity();
  }
  if (status != std::errc{} || end == text.data()) return std::nullopt;
  return value;
}

Result<DeclaredMetadata> parse_gdal_metadata(std::string_view xml) {
  DeclaredMetadata declared;
  if (trimmed(xml).empty()) return declared;
  pugi::xml_document document;
  if (!parse_xml(xml, document, declared)) return declared;
  for (const pugi::xml_node item : document.child("GDALMetadata").children("Item")) {
    // The role says what the item is of the band; the name is for people.
    const pugi::xml_attribute sample = item.attribute("sample");
    const int band = sample.as_int(-1);
    if (sample.empty() || band < 0) continue;
    VT_CHECK(note(item.attribute("role").as_string(), item.child_value(), declared.bands[band]));
  }
  return declared;
}

Result<DeclaredMetadata> parse_aux_xml(std::string_view xml) {
  DeclaredMetadata declared;
  pugi::xml_document document;
  if (!parse_xml(xml, document, declared)) return declared;
  const pugi::xml_node dataset = document.child("PAMDataset");
  struct Place {
    const char* element;
    const char* words;
  };
  for (const auto& [element, words] :
       {Place{"SRS", "a coordinate reference system"}, Place{"GeoTransform", "a place on the ground"}, Place{"GCPList", "control points"}})
    if (dataset.child(element)) declared.not_read.emplace_back(words);
  for (const pugi::xml_node node : dataset.children("PAMRasterBand")) {
    const int number = node.attribute("band").as_int(0);
    if (number < 1) continue;
    DeclaredBand& band = declared.bands[number - 1];
    if (const char* text = node.child_value("NoDataValue"); *text != '\0') band.nodata = parse_nodata(text);
    for (const auto& [element, name] :
         {Place{"Scale", "scale"}, Place{"Offset", "offset"}, Place{"UnitType", "unittype"}, Place{"ColorInterp", "colorinterp"}})
      if (const char* text = node.child_value(element); *text != '\0') VT_CHECK(note(name, text, band));
    if (node.child("ColorTable")) declared.not_read.emplace_back("a colour table");
    if (node.child("MaskBand")) declared.not_read.emplace_back("a mask");
  }
  return declared;
}

void apply_declared(const DeclaredMetadata& declared, RasterInfo& info) {
  for (const auto& [number, band] : declared.bands) {
    if (number >= static_cast<int>(info.meaning.size())) continue;
    BandMeaning& meaning = info.meaning[static_cast<std::size_t>(number)];
    if (band.scale) meaning.scale = band.scale;
    if (band.offset) meaning.offset = band.offset;
    if (band.nodata) meaning.nodata = band.nodata;
    if (!band.unit.empty()) meaning.unit = band.unit;
    if (!band.role_name.empty()) meaning.role = role_from_name(band.role_name);
  }
}

Result<DeclaredMetadata> read_aux_xml(RasterInfo& info) {
  std::filesystem::path path = info.path;
  path += ".aux.xml";
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return DeclaredMetadata{};
  VT_ASSIGN(const auto file, FileBytes::open(path, nullptr));
  const std::string name = path.string();
  if (file->size() > kMostAuxBytes)
    return fail(ErrorCode::kUnsupported, fmt::format("{}: {} bytes of metadata, more than {} MB", name, file->size(), kMostAuxBytes >> 20));
  std::string text(static_cast<std::size_t>(file->size()), '\0');
  VT_ASSIGN(const std::size_t got, file->read_some(0, std::as_writable_bytes(std::span(text))));
  text.resize(got);
  auto declared = parse_aux_xml(text);
  if (!declared)
    return fail(declared.error().code,
                fmt::format("{}: {}; mend it, or move it away if it does not belong to the raster", name, declared.error().message));
  info.companions.push_back(path);
  for (const std::string& words : declared->not_read)
    info.unused.push_back({.what = fmt::format("{} in {}", words, path.filename().string()), .concern = Concern::kAll});
  return declared;
}

DeclaredMetadata overlaid(const DeclaredMetadata& upper, const DeclaredMetadata& lower) {
  DeclaredMetadata both = lower;
  for (const auto& [number, from] : upper.bands) {
    DeclaredBand& to = both.bands[number];
    if (from.scale) to.scale = from.scale;
    if (from.offset) to.offset = from.offset;
    if (from.nodata) to.nodata = from.nodata;
    if (!from.unit.empty()) to.unit = from.unit;
    if (!from.role_name.empty()) to.role_name = from.role_name;
  }
  return both;
}

}  // namespace vt::source
