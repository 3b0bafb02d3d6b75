// Remembers which payloads a writer has written, so that tiles of the same bytes can share one record. It
// only points to where the same bytes may lie: whoever asks compares them. Bounded: what it has forgotten is
// written once more, which costs file and nothing else. Threads: one at a time; the writer's mutex guards it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "store/codec/codec.h"
#include "store/format/layout.h"
#include "store/layer.h"
#include "store/tile_id.h"

namespace vt::store {

// A hash of a few places of the payload: next to nothing to compute, and different for nearly all compressed
// payloads that differ.
[[nodiscard]] std::uint64_t payload_fingerprint(const PayloadView& payload);

// Where a payload lies, and the tile that it was written for.
struct KnownPayload {
  Reference reference;  // of kind tile or shared tile
  std::uint32_t raw_bytes = 0;
  LayerId layer;
  TileId tile;
};

class KnownPayloads {
 public:
  static constexpr std::size_t kMost = 65536;
  static constexpr std::size_t kBytesOfOne = 160;  // with all around it

  // A thread that is about to write a payload claims its fingerprint; others with the same one wait until it
  // is released, so that how many records there are does not depend on who was faster. `is_claimed` must be
  // false before a claim, and every claim must be released.
  [[nodiscard]] bool is_claimed(std::uint64_t fingerprint) const;
  // Gives the last payload known by that fingerprint.
  [[nodiscard]] std::optional<KnownPayload> claim(std::uint64_t fingerprint);
  // Nothing is known any more when `payload` is empty.
  void release(std::uint64_t fingerprint, const std::optional<KnownPayload>& payload);

 private:
  struct Slot {
    std::optional<KnownPayload> payload;
    bool is_claimed = false;
  };
  std::unordered_map<std::uint64_t, Slot> slots_;
};

}  // namespace vt::store
