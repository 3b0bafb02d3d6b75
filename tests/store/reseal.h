// Makes a changed store consistent again: recomputes every checksum and every reference's copy of it, so that
// what is behind the checksums gets tested too. Relies on the log's order: a page comes after all it points
// to, a catalog anywhere. Survives any input, for the fuzzer's sake.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "store/format/catalog.h"
#include "store/format/layout.h"
#include "store/io/bytes.h"

namespace vt::store::test {

inline void reseal(std::span<std::byte> file) {
  const auto renew_reference = [&](std::uint64_t at) {
    const Reference reference = get_reference(file, at);
    const std::uint64_t target = reference.offset;
    if (!reference.present()) return;
    if (target <= file.size() && file.size() - target >= kRecordHeaderBytes)
      put<std::uint32_t>(file, at + 12, get<std::uint32_t>(file, target));
  };
  // Nobody asks for a catalog that neither superblock refers to any more.
  const auto layer_bytes_of = [&](std::uint64_t catalog_at) {
    for (std::uint64_t at = 0; at < kLogStart && at + kSuperblockBytes <= file.size(); at += kSuperblockBytes)
      if (get_reference(file, at + 48).offset == catalog_at) return catalog_layer_bytes(get<std::uint32_t>(file, at + 8));
    return catalog_layer_bytes(kFormatVersion);
  };
  constexpr std::uint32_t kMagic = 0x43525456;
  const auto seal_records = [&](bool of_catalogs) {
    for (std::uint64_t at = kLogStart; at + kRecordHeaderBytes <= file.size();) {
      const std::uint64_t stored = get<std::uint32_t>(file, at + 20);
      if (get<std::uint32_t>(file, at + 8) != kMagic || stored > file.size() - at - kRecordHeaderBytes) {
        at += kRecordAlignment;
        continue;
      }
      const std::uint64_t here = std::exchange(at, at + aligned(kRecordHeaderBytes + stored));
      const auto type = static_cast<RecordType>(get<std::uint8_t>(file, here + 12));
      if ((type == RecordType::kCatalog) != of_catalogs) continue;
      const std::uint64_t payload = here + kRecordHeaderBytes;
      const std::uint64_t end = payload + stored;
      std::uint64_t first = end;
      std::uint64_t references = 0;
      if (type == RecordType::kPage && stored >= 2) {
        first = payload + kPageEntriesAt;
        references = get<std::uint16_t>(file, payload);
      } else if (type == RecordType::kCatalog && stored >= 48) {
        const std::uint64_t layer_bytes = layer_bytes_of(here);
        const std::uint64_t layers = std::min<std::uint64_t>(get<std::uint32_t>(file, payload), (stored - 48) / layer_bytes);
        first = payload + 48 + layer_bytes * layers;
        for (std::uint64_t i = 0; i < layers; ++i) references += get<std::uint8_t>(file, payload + 48 + layer_bytes * i + 10) + 1U;
      }
      for (std::uint64_t i = 0; i < references && first + kReferenceBytes * (i + 1) <= end; ++i)
        renew_reference(first + kReferenceBytes * i);
      put<std::uint64_t>(file, here, hash_bytes(file.subspan(here + 8, kRecordHeaderBytes - 8 + stored)));
    }
  };
  seal_records(false);
  seal_records(true);
  for (std::uint64_t at = 0; at < kLogStart && at + kSuperblockBytes <= file.size(); at += kSuperblockBytes) {
    renew_reference(at + 48);
    put<std::uint64_t>(file, at + kSuperblockBytes - 8, hash_bytes(file.subspan(at, kSuperblockBytes - 8)));
  }
}

}  // namespace vt::store::test
