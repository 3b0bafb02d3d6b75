#include "builder/source/formats/ascii_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "builder/source/cells/cell_store.h"
#include "builder/source/formats/word_reader.h"
#include "builder/source/metadata/gdal_metadata.h"
#include "builder/source/source_common.h"
#include "builder/source/tiff/masked_source.h"
#include "store/format/text.h"

namespace vt::source {
namespace {

// Words of the header, in any order and in capitals or not; all but the last have to be there, once, in one
// of the two ways.
struct GridHeader {
  std::optional<double> ncols;
  std::optional<double> nrows;
  std::optional<double> xllcorner;
  std::optional<double> xllcenter;
  std::optional<double> yllcorner;
  std::optional<double> yllcenter;
  std::optional<double> cellsize;
  std::optional<double> dx;
  std::optional<double> dy;
  std::optional<double> nodata_value;
};
struct HeaderWord {
  std::string_view word;
  std::optional<double> GridHeader::*value;
};
constexpr std::array<HeaderWord, 10> kHeaderWords = {{{"ncols", &GridHeader::ncols},
                                                      {"nrows", &GridHeader::nrows},
                                                      {"xllcorner", &GridHeader::xllcorner},
                                                      {"xllcenter", &GridHeader::xllcenter},
                                                      {"yllcorner", &GridHeader::yllcorner},
                                                      {"yllcenter", &GridHeader::yllcenter},
                                                      {"cellsize", &GridHeader::cellsize},
                                                      {"dx", &GridHeader::dx},
                                                      {"dy", &GridHeader::dy},
                                                      {"nodata_value", &GridHeader::nodata_value}}};

constexpr double kMostColumns = 2147483647.0;
constexpr std::int64_t kCellBytes = std::int64_t{1} << 20;  // of rows that are decoded as one

// A number as such files have it: with a plus sign, a comma for the point or without a digit before it, at
// times. Empty: it is none.
std::optional<double> number_of_word(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  std::array<char, WordReader::kMostWordBytes> with_point{};
  if (word.size() > with_point.size()) return std::nullopt;
  std::ranges::replace_copy(word, with_point.begin(), ',', '.');
  double value = 0.0;
  const char* const end = with_point.data() + word.size();
  const auto [stopped, status] = std::from_chars(with_point.data(), end, value);
  return status == std::errc{} && stopped == end ? std::optional(value) : std::nullopt;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Significant digits of a number that is one: a float keeps six of them, whatever they are.
int digits_of(std::string_view number) {
  int digits = 0;
  for (const char c : number) {
    if (c == 'e' || c == 'E') break;
    if (is_digit(c) && (c != '0' || digits > 0)) ++digits;
  }
  return digits;
}

// What all numbers of a file have in common.
class NumberRange {
 public:
  void add(std::string_view word, double value) {
    const bool is_whole = std::ranges::all_of(word, [](char c) { return is_digit(c) || c == '-' || c == '+'; });
    are_whole_ = are_whole_ && is_whole;
    if (std::isfinite(value)) {
      least_ = std::min(least_, value);
      greatest_ = std::max(greatest_, value);
      most_digits_ = std::max(most_digits_, digits_of(word));
    }
  }
  [[nodiscard]] SampleType type(const std::optional<double>& nodata) const {
    const bool has_whole_nodata = !nodata || std::floor(*nodata) == *nodata;  // false of NaN
    const double least = nodata && has_whole_nodata ? std::min(least_, *nodata) : least_;
    const double greatest = nodata && has_whole_nodata ? std::max(greatest_, *nodata) : greatest_;
    const auto holds = [&]<class T>(T) { return least >= std::numeric_limits<T>::lowest() && greatest <= std::numeric_limits<T>::max(); };
    if (are_whole_ && has_whole_nodata && holds(std::int16_t{})) return SampleType::kInt16;
    if (are_whole_ && has_whole_nodata && holds(std::int32_t{})) return SampleType::kInt32;
    const bool are_floats = most_digits_ <= std::numeric_limits<float>::digits10 && least_ >= std::numeric_limits<float>::lowest() &&
                            greatest_ <= std::numeric_limits<float>::max();
    return are_floats ? SampleType::kFloat32 : SampleType::kFloat64;
  }

 private:
  bool are_whole_ = true;
  double least_ = 0.0;
  double greatest_ = 0.0;
  int most_digits_ = 0;
};

// What opening a file finds out.
struct GridText {
  RasterInfo info;
  std::int64_t rows_per_cell = 0;
  std::vector<std::uint64_t> cells;  // where the first sample of each cell begins, and behind them where the last sample ends
};

tl::unexpected<Error> damaged_grid(const FileBytes& file, const std::string& what) {
  return fail(ErrorCode::kInvalidData, fmt::format("{}: damaged ASCII grid: {}", file.path().string(), what));
}

tl::unexpected<Error> no_number(const FileBytes& file, const WordReader& words, std::string_view word) {
  return damaged_grid(file, fmt::format("\"{}\" at byte {} is no number", store::printable(word.substr(0, 24)), words.word_at()));
}

// Up to the first sample, whose place it returns.
Result<std::uint64_t> read_grid_header(const FileBytes& file, WordReader& words, GridHeader& header) {
  for (;;) {
    VT_ASSIGN(const std::string_view word, words.next());
    const std::string name = in_lower_case(std::string(word));
    const auto* const known = std::ranges::find(kHeaderWords, std::string_view(name), &HeaderWord::word);
    if (known == kHeaderWords.end()) {
      if (word.empty() || number_of_word(word)) return words.word_at();
      return no_number(file, words, word);
    }
    VT_ASSIGN(const std::string_view text, words.next());
    const auto value = number_of_word(text);
    if (!value) return no_number(file, words, text);
    if (header.*known->value) return damaged_grid(file, fmt::format("its header has {} twice", name));
    header.*known->value = value;
  }
}

// The lower left corner of the raster along one axis.
Result<double> corner_of(const FileBytes& file, const char* axis, const std::optional<double>& corner, const std::optional<double>& centre,
                         double step) {
  if (corner.has_value() == centre.has_value())
    return damaged_grid(file, fmt::format("its header wants one of {0}llcorner and {0}llcenter", axis));
  const double place = corner ? *corner : *centre - step / 2;
  if (!std::isfinite(place)) return damaged_grid(file, fmt::format("its header places it nowhere in {}", axis));
  return place;
}

Result<RasterInfo> info_of_header(const FileBytes& file, const GridHeader& header, std::uint64_t samples_at) {
  const auto is_count = [](const std::optional<double>& n) { return n && *n >= 1.0 && *n <= kMostColumns && std::floor(*n) == *n; };
  if (!is_count(header.ncols) || !is_count(header.nrows))
    return damaged_grid(file, "its header does not say how large it is (ncols, nrows)");
  RasterInfo info;
  info.path = file.path();
  info.width = static_cast<std::int64_t>(*header.ncols);
  info.height = static_cast<std::int64_t>(*header.nrows);
  // A digit each, and something between them. Half of it is compared: twice the product may be more than
  // 2^63.
  const auto samples = static_cast<std::uint64_t>(info.width) * static_cast<std::uint64_t>(info.height);
  const std::uint64_t bytes = file.size() - std::min(samples_at, file.size());
  if (samples > bytes / 2 + 1)
    return damaged_grid(
        file, fmt::format("its header claims {} x {} samples, for which its {} bytes are too few", info.width, info.height, file.size()));
  const bool has_two_steps = header.dx && header.dy && !header.cellsize;
  const bool has_one_step = header.cellsize && !header.dx && !header.dy;
  if (!has_two_steps && !has_one_step) return damaged_grid(file, "its header wants cellsize, or dx and dy");
  const double step_x = has_one_step ? *header.cellsize : *header.dx;
  const double step_y = has_one_step ? *header.cellsize : *header.dy;
  if (!(step_x > 0.0) || !(step_y > 0.0) || !std::isfinite(step_x) || !std::isfinite(step_y))
    return damaged_grid(file, fmt::format("its samples are {} by {} apart", step_x, step_y));
  VT_ASSIGN(const double west, corner_of(file, "x", header.xllcorner, header.xllcenter, step_x));
  VT_ASSIGN(const double south, corner_of(file, "y", header.yllcorner, header.yllcenter, step_y));
  info.transform = {.x0 = west,
                    .x_column = step_x,
                    .x_row = 0.0,
                    .y0 = south + static_cast<double>(info.height) * step_y,
                    .y_column = 0.0,
                    .y_row = -step_y};
  info.has_transform = true;
  info.bands = 1;
  info.compression = "text";
  info.meaning.resize(1);
  info.meaning[0].nodata = header.nodata_value;
  return info;
}

// Counts the samples, and notes their range and where the cells begin.
Result<NumberRange> walk(const FileBytes& file, GridText& grid, std::uint64_t at) {
  NumberRange range;
  WordReader words(file, at);
  const auto& nodata = grid.info.meaning[0].nodata;
  const std::int64_t cell_samples = grid.rows_per_cell * grid.info.width;
  const std::int64_t samples = grid.info.width * grid.info.height;
  for (std::int64_t i = 0; i < samples; ++i) {
    VT_ASSIGN(const std::string_view word, words.next());
    if (word.empty()) return damaged_grid(file, fmt::format("it ends after {} samples of {} x {}", i, grid.info.width, grid.info.height));
    const auto value = number_of_word(word);
    if (!value) return no_number(file, words, word);
    if (i % cell_samples == 0) grid.cells.push_back(words.word_at());
    if (!nodata || *value != *nodata) range.add(word, *value);
  }
  VT_ASSIGN(const std::string_view more, words.next());
  if (!more.empty())
    return damaged_grid(file,
                        fmt::format("it goes on after {} x {} samples, at byte {}", grid.info.width, grid.info.height, words.word_at()));
  grid.cells.push_back(words.word_at());
  return range;
}

// Where a system beside the file would be, which is not read yet.
void note_projection_file(RasterInfo& info) {
  for (const char* suffix : {".prj", ".PRJ"}) {
    const std::filesystem::path beside = std::filesystem::path(info.path).replace_extension(suffix);
    std::error_code error;
    if (!std::filesystem::is_regular_file(beside, error)) continue;
    info.unused.push_back({.what = "a coordinate reference system beside it (" + beside.filename().string() + ")",
                           .instead = "the one that is given counts"});
    return;
  }
}

class GridDecoder final : public CellDecoder {
 public:
  GridDecoder(std::shared_ptr<const FileBytes> file, const GridText& text)
      : file_(std::move(file)), type_(text.info.sample_type), cells_(text.cells) {
    grid_ = {.width = text.info.width,
             .height = text.info.height,
             .block_width = text.info.width,
             .block_height = text.rows_per_cell,
             .rows_per_cell = text.rows_per_cell,
             .stride = static_cast<std::int64_t>(sample_bytes(type_))};
  }

  const CellGrid& grid() const override { return grid_; }
  std::uint64_t decoded_bytes() const { return decoded_bytes_.load(std::memory_order_relaxed); }

  Result<Block> decode_cell(std::int64_t, std::int64_t cell_y, int) const override {
    return visit_sample_type(type_, [&]<class T>(std::type_identity<T>) { return decode<T>(cell_y); });
  }

  // The text of a cell, and what it becomes.
  Result<store::ContentHash> hash_cell(std::int64_t cell_y) const {
    const auto cell = static_cast<std::size_t>(cell_y);
    store::ContentHasher hasher;
    hasher.add(std::as_bytes(std::span(&type_, 1)));
    Block buffer(WordReader::kBufferBytes);
    for (std::uint64_t at = cells_[cell]; at < cells_[cell + 1]; at += buffer.size()) {
      const auto part = std::span(buffer).first(static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), cells_[cell + 1] - at)));
      VT_ASSIGN(const std::size_t got, file_->read_some(at, part));
      if (got != part.size()) return fail(ErrorCode::kIo, file_->path().string() + ": the file has become shorter while it is read");
      hasher.add(part);
    }
    return hasher.digest();
  }

 private:
  template <class T>
  Result<Block> decode(std::int64_t cell_y) const {
    const std::int64_t count = grid_.cell_rows(cell_y) * grid_.width;
    Block block(static_cast<std::size_t>(count) * sizeof(T));
    WordReader words(*file_, cells_[static_cast<std::size_t>(cell_y)]);
    for (std::int64_t i = 0; i < count; ++i) {
      const auto word = words.next();
      const auto value = word ? number_of_word(*word) : std::nullopt;
      if (!value)  // it was one when the file was opened
        return fail(ErrorCode::kIo,
                    fmt::format("{}: row {}, column {}: {}", file_->path().string(), grid_.first_row(cell_y) + i / grid_.width,
                                i % grid_.width, word ? "the file has changed while it is read" : word.error().message));
      store(block.data() + static_cast<std::size_t>(i) * sizeof(T), static_cast<T>(*value));
    }
    decoded_bytes_.fetch_add(block.size(), std::memory_order_relaxed);
    return block;
  }

  std::shared_ptr<const FileBytes> file_;
  SampleType type_;
  std::vector<std::uint64_t> cells_;
  CellGrid grid_;
  mutable std::atomic<std::uint64_t> decoded_bytes_ = 0;
};

class GridSource final : public RasterSource {
 public:
  GridSource(RasterInfo info, std::unique_ptr<GridDecoder> decoder, const std::shared_ptr<BlockCache>& cache,
             const std::shared_ptr<ScratchFile>& scratch)
      : decoder_(std::move(decoder)), cells_(*decoder_, cache, scratch) {
    info_ = std::move(info);
  }

  using RasterSource::read;
  Result<void> read(const Window& window, std::span<const int> bands, std::span<std::byte> out, std::size_t row_pitch_bytes,
                    store::ContentHasher* content) const override {
    VT_CHECK(check_request(info_, window, bands, out, row_pitch_bytes));
    if (content != nullptr) VT_CHECK(hash(window, bands, *content));
    const std::size_t bytes = sample_bytes(info_.sample_type);
    return cells_.visit(0, true, window, [&](const std::byte* in, std::int64_t in_pitch, const Window& part) {
      for (std::int64_t row = 0; row < part.height; ++row) {
        const std::byte* from = in + row * in_pitch;
        std::byte* to = out.data() + static_cast<std::size_t>(part.y - window.y + row) * row_pitch_bytes;
        for (std::int64_t x = 0; x < part.width; ++x, from += bytes) {
          for (const int band : bands) {
            if (band != kLeaveAlone) std::memcpy(to, from, bytes);
            to += bytes;
          }
        }
      }
    });
  }

  Result<void> hash(const Window& window, std::span<const int> bands, store::ContentHasher& content) const override {
    VT_CHECK(check_window(info_, window, bands));
    const CellGrid& grid = decoder_->grid();
    const std::int64_t last = grid.cell_of_row(window.y + window.height - 1);
    for (std::int64_t cell = grid.cell_of_row(window.y); cell <= last; ++cell) {
      VT_ASSIGN(const store::ContentHash hash, cells_.cache().hash(cells_.key(0, cell, 0), [&] { return decoder_->hash_cell(cell); }));
      content.add(hash.bytes);
    }
    return {};
  }

  void release_rows_before(std::int64_t row) const override { cells_.release_rows_before(row); }
  std::size_t resident_bytes() const override {
    return static_cast<std::size_t>(decoder_->grid().cell_bytes()) + WordReader::kBufferBytes + cells_.resident_bytes();
  }
  std::uint64_t decoded_bytes() const override { return decoder_->decoded_bytes(); }

 private:
  std::unique_ptr<GridDecoder> decoder_;
  CellStore cells_;
};

Result<GridText> read_grid(const FileBytes& file) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  VT_ASSIGN(const FileEvidence evidence, FileEvidence::of(file));
  WordReader words(file, evidence.has(0, kByteOrderMark) ? kByteOrderMark.size() : 0);
  GridHeader header;
  VT_ASSIGN(const std::uint64_t samples_at, read_grid_header(file, words, header));
  GridText grid;
  VT_ASSIGN(grid.info, info_of_header(file, header, samples_at));
  RasterInfo& info = grid.info;
  constexpr auto kWidestSample = static_cast<std::int64_t>(sizeof(double));
  if (info.width > kMaxCellBytes / kWidestSample)
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}: a row of {} samples in one piece is more than this program holds", info.path.string(), info.width));
  grid.rows_per_cell = std::clamp<std::int64_t>(kCellBytes / (info.width * kWidestSample), 1, info.height);
  VT_ASSIGN(const NumberRange range, walk(file, grid, samples_at));
  info.sample_type = range.type(info.meaning[0].nodata);
  info.meaning[0].full_scale = full_scale(info.sample_type);
  info.block_width = info.width;
  info.block_height = grid.rows_per_cell;
  return grid;
}

}  // namespace

bool is_ascii_grid(const FileEvidence& file) {
  const std::string text = file.text();
  const std::string word = text.substr(0, text.find_first_of(" \t\r\n"));
  const bool begins = std::ranges::find(kHeaderWords, std::string_view(word), &HeaderWord::word) != kHeaderWords.end();
  // Headers of raw rasters begin with the same words, but their first samples are elsewhere.
  return begins && file.suffix() != ".hdr" && text.find("byteorder") == std::string::npos;
}

Result<std::unique_ptr<RasterSource>> open_ascii_grid(std::shared_ptr<const FileBytes> file, const OpenOptions& options) {
  VT_ASSIGN(GridText grid, read_grid(*file));
  RasterInfo& info = grid.info;
  VT_ASSIGN(const DeclaredMetadata beside, read_aux_xml(info));
  apply_declared(beside, info);
  if (options.nodata) info.meaning[0].nodata = options.nodata;
  note_projection_file(info);
  VT_CHECK(apply_options(options, info));
  const std::shared_ptr<BlockCache> cache = cache_of(options);
  VT_ASSIGN(std::unique_ptr<TiffDecoder> mask, find_mask_beside(info, options, *cache));
  auto decoder = std::make_unique<GridDecoder>(std::move(file), grid);
  std::unique_ptr<RasterSource> source = std::make_unique<GridSource>(std::move(info), std::move(decoder), cache, options.scratch);
  return mask ? with_mask(std::move(source), std::move(mask), cache, options.scratch) : std::move(source);
}

}  // namespace vt::source
