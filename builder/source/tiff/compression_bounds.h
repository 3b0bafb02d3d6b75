// How few bytes a block of samples can take in a TIFF: what claims to be more than its stored bytes can hold
// is damaged or hostile, and no memory or disk space is taken for it. Arithmetic only; any thread.
#pragma once

#include <cstdint>

namespace vt::source {

// The least bytes of `rows` rows of `row_bytes` bytes each, as the decoder gives them, by TIFF tag 259. 0:
// the compression has no such bound.
[[nodiscard]] std::uint64_t least_stored_bytes(std::uint16_t compression, std::int64_t row_bytes, std::int64_t rows);

}  // namespace vt::source
