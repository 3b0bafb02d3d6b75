#include "builder/source/tiff/tiff_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "builder/source/metadata/color_remarks.h"
#include "builder/source/metadata/geo_tags.h"

namespace vt::source {
namespace {

constexpr int kMaxBands = 4096;
constexpr std::int64_t kMaxBlocks = std::int64_t{1} << 31;

// Files say 3.40282347e+38 and mean the largest float: compare as the samples are.
double as_float32(double value) {
  constexpr double kMax = std::numeric_limits<float>::max();
  if (!std::isfinite(value)) return value;
  return static_cast<double>(static_cast<float>(std::clamp(value, -kMax, kMax)));
}

tl::unexpected<Error> unsupported(const std::string& name, std::string what) {
  return fail(ErrorCode::kUnsupported, name + ": " + std::move(what));
}

struct SampleKind {
  SampleRecipe recipe;
  SampleType type;
};

Result<SampleKind> sample_kind(const std::string& name, std::uint16_t format, int bits) {
  switch (format) {
    case SAMPLEFORMAT_VOID:
    case SAMPLEFORMAT_UINT:
      if (bits == 8) return SampleKind{SampleRecipe::kNative, SampleType::kUint8};
      if (bits == 16) return SampleKind{SampleRecipe::kNative, SampleType::kUint16};
      if (bits == 32) return SampleKind{SampleRecipe::kNative, SampleType::kUint32};
      if (bits >= 1 && bits < 8) return SampleKind{SampleRecipe::kPackedBits, SampleType::kUint8};
      if (bits > 8 && bits < 16) return SampleKind{SampleRecipe::kPackedBits, SampleType::kUint16};
      if (bits > 16 && bits < 32) return SampleKind{SampleRecipe::kPackedBits, SampleType::kUint32};
      break;
    case SAMPLEFORMAT_INT:
      if (bits == 8) return SampleKind{SampleRecipe::kNative, SampleType::kInt8};
      if (bits == 16) return SampleKind{SampleRecipe::kNative, SampleType::kInt16};
      if (bits == 32) return SampleKind{SampleRecipe::kNative, SampleType::kInt32};
      break;
    case SAMPLEFORMAT_IEEEFP:
      if (bits == 32) return SampleKind{SampleRecipe::kNative, SampleType::kFloat32};
      if (bits == 64) return SampleKind{SampleRecipe::kNative, SampleType::kFloat64};
      if (bits == 16) return SampleKind{SampleRecipe::kHalfFloat, SampleType::kFloat32};
      if (bits == 24) return SampleKind{SampleRecipe::kFloat24, SampleType::kFloat32};
      break;
    case SAMPLEFORMAT_COMPLEXINT:
    case SAMPLEFORMAT_COMPLEXIEEEFP:
      return unsupported(name, "samples are complex numbers (SampleFormat 5 or 6); split them into real bands first");
    default:
      break;
  }
  return unsupported(
      name, fmt::format("samples of {} bits with SampleFormat {} are not read; wanted integers up to 32 bits or floating point of 16, 24, "
                        "32 or 64 bits",
                        bits, format));
}

// 16-bit colour map entries hold c * 257 or c << 8; a few old writers stored c itself. The entry that means
// "no data" is clear.
Result<std::vector<std::uint32_t>> read_palette(TIFF* tiff, const std::string& name, int bits, std::optional<double> nodata) {
  std::uint16_t* red = nullptr;
  std::uint16_t* green = nullptr;
  std::uint16_t* blue = nullptr;
  if (bits > 16 || TIFFGetField(tiff, TIFFTAG_COLORMAP, &red, &green, &blue) == 0) {
    return fail(ErrorCode::kInvalidData, name + ": a palette picture (PhotometricInterpretation 3) without a usable ColorMap");
  }
  const std::size_t colors = std::size_t{1} << bits;
  bool wide = false;
  for (std::size_t i = 0; i < colors; ++i) wide = wide || red[i] > 255 || green[i] > 255 || blue[i] > 255;
  const int shift = wide ? 8 : 0;
  std::vector<std::uint32_t> palette(colors);
  for (std::size_t i = 0; i < colors; ++i) {
    const std::uint32_t alpha = nodata && *nodata == static_cast<double>(i) ? 0 : 255;
    palette[i] = static_cast<std::uint32_t>(red[i] >> shift) | static_cast<std::uint32_t>(green[i] >> shift) << 8 |
                 static_cast<std::uint32_t>(blue[i] >> shift) << 16 | alpha << 24;
  }
  return palette;
}

Result<void> read_blocks(TIFF* tiff, const std::string& name, TiffLayout& layout) {
  layout.tiled = TIFFIsTiled(tiff) != 0;
  std::uint32_t block_width = static_cast<std::uint32_t>(layout.width);
  std::uint32_t block_height = 0;
  if (layout.tiled) {
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &block_width);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &block_height);
  } else {
    TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &block_height);
    block_height = static_cast<std::uint32_t>(std::min<std::int64_t>(block_height, layout.height));
  }
  if (block_width == 0 || block_height == 0) return fail(ErrorCode::kInvalidData, name + ": blocks of no size");
  layout.block_width = block_width;
  layout.block_height = block_height;
  layout.blocks_across = (layout.width + block_width - 1) / block_width;
  layout.blocks_down = (layout.height + block_height - 1) / block_height;
  const std::int64_t planes = layout.planar_separate ? layout.samples_per_pixel : 1;
  if (layout.blocks_across > kMaxBlocks / layout.blocks_down / planes) {
    return unsupported(name, fmt::format("{} x {} blocks are more than this program reads", layout.blocks_across, layout.blocks_down));
  }
  return {};
}

// The stored code of each band that means "no data": what the user gives, else what GDAL notes of the band,
// else the file's one value.
class NodataCodes {
 public:
  NodataCodes(std::optional<double> given, const DeclaredMetadata& declared, std::optional<double> of_file)
      : given_(given), declared_(declared), of_file_(of_file) {}

  [[nodiscard]] std::optional<double> of(int band) const {
    if (given_) return given_;
    const auto noted = declared_.bands.find(band);
    return noted != declared_.bands.end() && noted->second.nodata ? noted->second.nodata : of_file_;
  }

 private:
  std::optional<double> given_;
  const DeclaredMetadata& declared_;
  std::optional<double> of_file_;
};

// Which stored band is alpha, and of which kind. GDAL's note of a band overrules the tag: it is how one says
// that the fourth band of an aerial photograph is infrared.
void read_alpha(TIFF* tiff, const DeclaredMetadata& declared, TiffLayout& layout) {
  std::uint16_t extra_count = 0;
  std::uint16_t* extra = nullptr;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &extra_count, &extra);
  const int first_extra = layout.samples_per_pixel - extra_count;
  for (int band = 0; band < layout.samples_per_pixel && layout.alpha_band < 0; ++band) {
    const int kind = band < first_extra || band - first_extra >= extra_count ? EXTRASAMPLE_UNSPECIFIED : extra[band - first_extra];
    const auto noted = declared.bands.find(band);
    const bool has_note = noted != declared.bands.end() && !noted->second.role_name.empty();
    const bool is_alpha = has_note ? role_from_name(noted->second.role_name) == BandRole::kCoverage
                                   : kind == EXTRASAMPLE_ASSOCALPHA || kind == EXTRASAMPLE_UNASSALPHA;
    if (!is_alpha) continue;
    layout.alpha_band = band;
    layout.alpha_is_associated = kind == EXTRASAMPLE_ASSOCALPHA;
  }
}

// Palette indices become colours: red, green, blue, then alpha where some entry or an alpha band can be
// clear.
Result<void> expand_palette(TIFF* tiff, const std::string& name, std::optional<double> nodata, TiffLayout& layout) {
  const bool is_index = layout.sample_type == SampleType::kUint8 || layout.sample_type == SampleType::kUint16;
  if (!is_index || layout.bits > 16) return unsupported(name, "palette indices that are not unsigned integers of up to 16 bits");
  const bool has_alpha_band = layout.alpha_band == 1;
  if (layout.samples_per_pixel > (has_alpha_band ? 2 : 1) || layout.planar_separate)
    return unsupported(name, fmt::format("a palette picture (PhotometricInterpretation 3) of {} bands{}; wanted its index alone, or index "
                                         "and alpha interleaved: expand it to RGB, for example with gdal_translate -expand rgba",
                                         layout.samples_per_pixel, layout.planar_separate ? " in separate planes" : ""));
  VT_ASSIGN(layout.palette, read_palette(tiff, name, layout.bits, nodata));
  const bool has_alpha = has_alpha_band || nodata.has_value();
  layout.sample_type = SampleType::kUint8;
  layout.bands = has_alpha ? 4 : 3;
  layout.alpha_band = has_alpha ? 3 : -1;
  layout.alpha_is_associated = false;  // there is nothing to multiply an index with
  layout.max_code = 255.0;
  return {};
}

Result<void> read_color(TIFF* tiff, const std::string& name, bool as_numbers, const NodataCodes& nodata, TiffLayout& layout) {
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  const bool is_unsigned =
      layout.sample_type == SampleType::kUint8 || layout.sample_type == SampleType::kUint16 || layout.sample_type == SampleType::kUint32;
  const auto is_first = [](BandRole role) { return BandMeaning{.role = role}; };
  switch (photometric) {
    case PHOTOMETRIC_MINISBLACK:
    case PHOTOMETRIC_MASK:
      layout.meaning = {is_first(BandRole::kGrey)};
      break;
    case PHOTOMETRIC_MINISWHITE:
      layout.meaning = {is_first(BandRole::kGrey)};
      layout.invert = is_unsigned && !as_numbers;  // for signed numbers and floats the tag is a writer's slip
      break;
    case PHOTOMETRIC_RGB:
      layout.meaning = {is_first(BandRole::kRed), is_first(BandRole::kGreen), is_first(BandRole::kBlue)};
      break;
    case PHOTOMETRIC_PALETTE: {
      layout.meaning = {is_first(BandRole::kIndex)};
      if (as_numbers) break;
      VT_CHECK(expand_palette(tiff, name, nodata.of(0), layout));
      layout.meaning = {is_first(BandRole::kRed), is_first(BandRole::kGreen), is_first(BandRole::kBlue)};
      break;
    }
    case PHOTOMETRIC_YCBCR:
      layout.meaning = {is_first(BandRole::kRed), is_first(BandRole::kGreen), is_first(BandRole::kBlue)};
      if (layout.compression == COMPRESSION_JPEG) break;  // the JPEG decoder gives RGB
      [[fallthrough]];
    case PHOTOMETRIC_SEPARATED:
    case PHOTOMETRIC_CIELAB: {
      std::array<char, 1024> reason{};
      if (layout.bits != 8 || TIFFRGBAImageOK(tiff, reason.data()) == 0) {
        return unsupported(name, fmt::format("PhotometricInterpretation {} with {} bits: convert the picture to RGB first {}", photometric,
                                             layout.bits, reason.data()));
      }
      if (layout.alpha_band >= 0)
        layout.unused.push_back({.what = "the alpha band of a picture that is not RGB", .concern = Concern::kAll});
      layout.meaning = {is_first(BandRole::kRed), is_first(BandRole::kGreen), is_first(BandRole::kBlue)};
      layout.recipe = SampleRecipe::kLibtiffRgba;
      layout.bands = 3;
      layout.alpha_band = -1;
      layout.alpha_is_associated = false;
      layout.planar_separate = false;
      break;
    }
    default:
      return unsupported(name, fmt::format("PhotometricInterpretation {}: convert the picture to RGB or grey first", photometric));
  }
  return {};
}

// What is known of every band: full scales, roles, no-data values, and what GDAL notes.
void settle_meaning(const DeclaredMetadata& declared, const NodataCodes& nodata, TiffLayout& layout) {
  layout.meaning.resize(static_cast<std::size_t>(layout.bands));
  const bool is_float = layout.sample_type == SampleType::kFloat32 || layout.sample_type == SampleType::kFloat64;
  const bool is_signed =
      layout.sample_type == SampleType::kInt8 || layout.sample_type == SampleType::kInt16 || layout.sample_type == SampleType::kInt32;
  const bool has_own_colors = layout.palette.empty() && layout.recipe != SampleRecipe::kLibtiffRgba;
  for (std::size_t b = 0; b < layout.meaning.size(); ++b) {
    BandMeaning& band = layout.meaning[b];
    band.full_scale = is_float ? 1.0 : is_signed ? std::floor(layout.max_code / 2.0) : layout.max_code;
    if (has_own_colors) band.nodata = nodata.of(static_cast<int>(b));
    if (band.nodata && layout.invert) band.nodata = layout.max_code - *band.nodata;
    const auto noted = declared.bands.find(static_cast<int>(b));
    if (!has_own_colors || noted == declared.bands.end()) continue;
    band.scale = noted->second.scale;
    band.offset = noted->second.offset;
    band.unit = noted->second.unit;
    if (!noted->second.role_name.empty()) band.role = role_from_name(noted->second.role_name);
  }
  for (std::size_t b = 0; b < layout.meaning.size(); ++b) {
    if (static_cast<int>(b) == layout.alpha_band) {
      layout.meaning[b].role = BandRole::kCoverage;
    } else if (layout.meaning[b].role == BandRole::kCoverage) {
      layout.meaning[b].role = BandRole::kOther;  // one is enough
    }
  }
  if (layout.alpha_band >= 0 && !layout.palette.empty())
    layout.meaning[static_cast<std::size_t>(layout.alpha_band)].full_scale =
        layout.bits < 8 && layout.samples_per_pixel == 2 ? static_cast<double>((1 << layout.bits) - 1) : 255.0;
}

// Tags that change what colours or places mean and that are not used.
Result<void> note_unused(const TiffTags& tags, TiffLayout& layout) {
  if (tags.has(TIFFTAG_COLORMAP) && layout.meaning.front().role != BandRole::kIndex && layout.palette.empty())
    layout.unused.push_back(
        {.what = "a colour map (tag 320), although it is not declared to be a palette picture", .concern = Concern::kColor});
  if (tags.has(kRpcCoefficients)) layout.unused.push_back({.what = "rational polynomials of a camera (tag 50844)"});
  return note_tiff_colors(tags, layout.unused);
}

// GDAL's notes of the bands.
Result<DeclaredMetadata> read_declared(const TiffTags& tags, const std::string& name, TiffLayout& layout) {
  VT_ASSIGN(const std::string xml, tags.text(kGdalMetadata));
  auto declared = parse_gdal_metadata(xml);
  if (!declared) return fail(declared.error().code, fmt::format("{}: GDAL_METADATA (tag 42112): {}", name, declared.error().message));
  for (const std::string& words : declared->not_read)
    layout.unused.push_back({.what = words + " in GDAL_METADATA (tag 42112)", .concern = Concern::kAll});
  return declared;
}

Result<std::optional<double>> read_nodata(const TiffTags& tags, TiffLayout& layout) {
  VT_ASSIGN(const std::string text, tags.text(kGdalNodata));
  std::optional<double> nodata = parse_nodata(text);
  if (!nodata && text.find_first_not_of(" \t\r\n") != std::string::npos)
    layout.unused.push_back({.what = "a no-data value that is no number (GDAL_NODATA, tag 42113)", .concern = Concern::kAll});
  if (nodata && layout.sample_type == SampleType::kFloat32) nodata = as_float32(*nodata);
  return nodata;
}

// How many samples there are and how they are stored, as far as single tags say it.
Result<void> read_storage(TIFF* tiff, const TiffTags& tags, const std::string& name, TiffLayout& layout) {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t samples = 1;
  std::uint16_t bits = 1;
  std::uint16_t planar = PLANARCONFIG_CONTIG;
  std::uint16_t fill_order = FILLORDER_MSB2LSB;
  if (TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width) == 0 || TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height) == 0 || width == 0 ||
      height == 0) {
    return fail(ErrorCode::kInvalidData, fmt::format("{}: the TIFF directory gives a size of {} x {}", name, width, height));
  }
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_FILLORDER, &fill_order);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &layout.compression);
  layout.width = width;
  layout.height = height;
  layout.samples_per_pixel = samples;
  layout.bits = bits;
  layout.bands = samples;
  layout.planar_separate = planar == PLANARCONFIG_SEPARATE && samples > 1;
  layout.fill_order_reversed = fill_order == FILLORDER_LSB2MSB;
  layout.byte_swapped = TIFFIsByteSwapped(tiff) != 0;
  // Known to libtiff only where the codec has one.
  VT_ASSIGN(const std::vector<double> predictor, tags.numbers(TIFFTAG_PREDICTOR));
  if (predictor.size() == 1) layout.predictor = static_cast<int>(std::clamp(predictor[0], 0.0, 65535.0));
  return {};
}

// Whether samples that are stored so can be decoded at all.
Result<void> check_storage(TIFF* tiff, const std::string& name, const TiffLayout& layout) {
  std::uint16_t orientation = ORIENTATION_TOPLEFT;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &orientation);
  if (TIFFIsCODECConfigured(layout.compression) == 0) {
    return unsupported(name,
                       fmt::format("Compression (tag 259) is {}, {}: this libtiff cannot decode it; rewrite the file with deflate or zstd",
                                   layout.compression, compression_name(layout.compression)));
  }
  if (orientation != ORIENTATION_TOPLEFT) {
    return unsupported(name,
                       fmt::format("Orientation (tag 274) is {}: only rows from the top and columns from the left (1) are read; turn the "
                                   "raster and its place, or, where the tag is wrong, set it right: tiffset -s 274 1 in.tif",
                                   orientation));
  }
  const int samples = layout.samples_per_pixel;
  const int bits = layout.bits;
  if (samples == 0 || samples > kMaxBands) return unsupported(name, fmt::format("SamplesPerPixel (tag 277) is {}", samples));
  const bool is_bilevel = layout.compression == COMPRESSION_CCITTRLE || layout.compression == COMPRESSION_CCITTFAX3 ||
                          layout.compression == COMPRESSION_CCITTFAX4;
  if (is_bilevel && (bits != 1 || samples != 1))
    return fail(ErrorCode::kInvalidData,
                fmt::format("{}: Compression (tag 259) is {}, {}, which holds one sample of one bit; the file claims {} "
                            "samples of {} bits and is damaged",
                            name, layout.compression, compression_name(layout.compression), samples, bits));
  if (layout.compression == COMPRESSION_JPEG && bits != 8) return unsupported(name, fmt::format("JPEG with {} bits a sample", bits));
  return {};
}

}  // namespace

std::int64_t TiffLayout::rows_in_block(std::int64_t block_y) const { return std::min(block_height, height - block_y * block_height); }

std::string compression_name(std::uint16_t compression) {
  switch (compression) {
    case COMPRESSION_NONE:
      return "none";
    case COMPRESSION_CCITTRLE:
      return "ccitt rle";
    case COMPRESSION_CCITTFAX3:
      return "ccitt fax 3";
    case COMPRESSION_CCITTFAX4:
      return "ccitt fax 4";
    case COMPRESSION_LZW:
      return "lzw";
    case COMPRESSION_OJPEG:
      return "old jpeg";
    case COMPRESSION_JPEG:
      return "jpeg";
    case COMPRESSION_ADOBE_DEFLATE:
    case COMPRESSION_DEFLATE:
      return "deflate";
    case COMPRESSION_PACKBITS:
      return "packbits";
    case COMPRESSION_NEXT:
      return "next";
    case COMPRESSION_THUNDERSCAN:
      return "thunderscan";
    case COMPRESSION_LERC:
      return "lerc";
    case COMPRESSION_LZMA:
      return "lzma";
    case COMPRESSION_ZSTD:
      return "zstd";
    case COMPRESSION_WEBP:
      return "webp";
    default:
      return fmt::format("compression {}", compression);
  }
}

Result<TiffLayout> read_tiff_layout(const TiffHandle& handle, const TiffTags& tags, const std::string& name, const OpenOptions& options,
                                    const DeclaredMetadata& beside) {
  TIFF* tiff = handle.get();
  TiffLayout layout;
  VT_CHECK(read_storage(tiff, tags, name, layout));
  VT_CHECK(check_storage(tiff, name, layout));
  std::uint16_t format = SAMPLEFORMAT_UINT;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
  VT_ASSIGN(const SampleKind kind, sample_kind(name, format, layout.bits));
  layout.recipe = kind.recipe;
  layout.sample_type = kind.type;
  layout.max_code = layout.bits >= 32 ? 4294967295.0 : static_cast<double>((std::uint64_t{1} << layout.bits) - 1);

  VT_ASSIGN(const DeclaredMetadata inside, read_declared(tags, name, layout));
  const DeclaredMetadata declared = overlaid(beside, inside);
  VT_ASSIGN(layout.fill, read_nodata(tags, layout));
  const NodataCodes nodata(options.nodata, declared, layout.fill);
  read_alpha(tiff, declared, layout);
  VT_CHECK(read_color(tiff, name, options.as_numbers, nodata, layout));
  settle_meaning(declared, nodata, layout);
  VT_CHECK(note_unused(tags, layout));
  VT_CHECK(read_blocks(tiff, name, layout));
  if (layout.alpha_is_associated && layout.planar_separate) {
    return unsupported(name, "associated alpha (ExtraSamples 1) in separate planes; rewrite the file with bands interleaved");
  }
  return layout;
}

Result<store::ContentHash> decode_fingerprint(const TiffTags& tags) {
  constexpr std::array<std::uint16_t, 31> kTags = {TIFFTAG_IMAGEWIDTH,
                                                   TIFFTAG_IMAGELENGTH,
                                                   TIFFTAG_BITSPERSAMPLE,
                                                   TIFFTAG_COMPRESSION,
                                                   TIFFTAG_PHOTOMETRIC,
                                                   TIFFTAG_FILLORDER,
                                                   TIFFTAG_SAMPLESPERPIXEL,
                                                   TIFFTAG_ROWSPERSTRIP,
                                                   TIFFTAG_PLANARCONFIG,
                                                   TIFFTAG_GROUP3OPTIONS,
                                                   TIFFTAG_GROUP4OPTIONS,
                                                   TIFFTAG_PREDICTOR,
                                                   TIFFTAG_WHITEPOINT,
                                                   TIFFTAG_COLORMAP,
                                                   TIFFTAG_TILEWIDTH,
                                                   TIFFTAG_TILELENGTH,
                                                   TIFFTAG_INKSET,
                                                   TIFFTAG_EXTRASAMPLES,
                                                   TIFFTAG_SAMPLEFORMAT,
                                                   TIFFTAG_JPEGTABLES,
                                                   TIFFTAG_JPEGPROC,
                                                   TIFFTAG_JPEGQTABLES,
                                                   TIFFTAG_JPEGDCTABLES,
                                                   TIFFTAG_JPEGACTABLES,
                                                   TIFFTAG_JPEGIFOFFSET,
                                                   TIFFTAG_JPEGIFBYTECOUNT,
                                                   TIFFTAG_YCBCRCOEFFICIENTS,
                                                   TIFFTAG_YCBCRSUBSAMPLING,
                                                   TIFFTAG_REFERENCEBLACKWHITE,
                                                   TIFFTAG_LERC_PARAMETERS,
                                                   kGdalNodata};
  store::ContentHasher content;
  const std::array<std::byte, 1> order = {tags.is_big_endian() ? std::byte{1} : std::byte{0}};
  content.add(order);
  for (const std::uint16_t tag : kTags) VT_CHECK(tags.feed(tag, content));
  return content.digest();
}

}  // namespace vt::source
