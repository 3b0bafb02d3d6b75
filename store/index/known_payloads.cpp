#include "store/index/known_payloads.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

namespace vt::store {
namespace {

constexpr std::size_t kSampledWords = 32;

}  // namespace

std::uint64_t payload_fingerprint(const PayloadView& payload) {
  std::array<std::byte, 8 * (kSampledWords + 2)> sample = {};
  put<std::uint64_t>(sample, 0, payload.bytes.size());
  put<std::uint64_t>(sample, 8, (std::uint64_t{payload.raw_bytes} << 8) | static_cast<std::uint8_t>(payload.codec));
  const std::span<std::byte> words = std::span(sample).subspan(16);
  if (payload.bytes.size() <= words.size()) {
    std::copy(payload.bytes.begin(), payload.bytes.end(), words.begin());
  } else {
    // The first word, the last, and those between, evenly.
    const std::size_t last = payload.bytes.size() - 8;
    for (std::size_t i = 0; i < kSampledWords; ++i)
      std::memcpy(words.data() + 8 * i, payload.bytes.data() + last * i / (kSampledWords - 1), 8);
  }
  return hash_bytes(sample);
}

bool KnownPayloads::is_claimed(std::uint64_t fingerprint) const {
  const auto found = slots_.find(fingerprint);
  return found != slots_.end() && found->second.is_claimed;
}

std::optional<KnownPayload> KnownPayloads::claim(std::uint64_t fingerprint) {
  if (slots_.size() >= kMost && !slots_.contains(fingerprint))
    std::erase_if(slots_, [](const auto& slot) { return !slot.second.is_claimed; });
  Slot& slot = slots_[fingerprint];
  assert(!slot.is_claimed);
  slot.is_claimed = true;
  return slot.payload;
}

void KnownPayloads::release(std::uint64_t fingerprint, const std::optional<KnownPayload>& payload) {
  const auto found = slots_.find(fingerprint);
  assert(found != slots_.end() && found->second.is_claimed);
  if (!payload) {
    slots_.erase(found);
    return;
  }
  found->second = {.payload = payload, .is_claimed = false};
}

}  // namespace vt::store
