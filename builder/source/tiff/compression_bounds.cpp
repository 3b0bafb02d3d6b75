#include "builder/source/tiff/compression_bounds.h"

#include <tiff.h>

namespace vt::source {
namespace {

// Most bytes that one stored byte can stand for, from the formats themselves.
double most_inflation(std::uint16_t compression) {
  switch (compression) {
    case COMPRESSION_NONE:
      return 1.0;
    case COMPRESSION_PACKBITS:
      return 64.0;  // 128 equal bytes from two
    case COMPRESSION_NEXT:
    case COMPRESSION_THUNDERSCAN:
      return 32.0;  // 63 samples of two or four bits from one byte
    case COMPRESSION_LZW:
      return 1400.0;  // strings that grow by one up to 3839 bytes, in codes of 9 to 12 bits: 1335
    case COMPRESSION_ADOBE_DEFLATE:
    case COMPRESSION_DEFLATE:
      return 1032.0;  // 258 bytes from two bits
    case COMPRESSION_LZMA:
      return 8192.0;  // 273 bytes from fourteen decisions of at least 0.022 bits: 7100
    case COMPRESSION_ZSTD:
      return 32768.0;  // a block of 128 KiB from four bytes
    case COMPRESSION_JPEG:
    case COMPRESSION_OJPEG:
      return 1536.0 * 64;  // three bands of 64 samples from one bit; arithmetic coders put up to 64 such blocks into one
    default:
      return 0.0;
  }
}

}  // namespace

std::uint64_t least_stored_bytes(std::uint16_t compression, std::int64_t row_bytes, std::int64_t rows) {
  // A row that repeats the one above it is one bit, however wide.
  const bool is_fax = compression == COMPRESSION_CCITTRLE || compression == COMPRESSION_CCITTFAX3 || compression == COMPRESSION_CCITTFAX4;
  if (is_fax) return static_cast<std::uint64_t>(rows) / 8;
  const double inflation = most_inflation(compression);
  return inflation == 0.0 ? 0 : static_cast<std::uint64_t>(static_cast<double>(row_bytes) * static_cast<double>(rows) / inflation);
}

}  // namespace vt::source
