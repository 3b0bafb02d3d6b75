// The catalog of a store: its area, its layers and the roots of their indexes, as schemas/tile-store.md
// section 6 specifies them; encoding, decoding, and every check that it can be given by itself. Owns no file.
// Pure functions, any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "store/description.h"
#include "store/format/fault.h"
#include "store/format/layout.h"
#include "store/layer.h"
#include "store/result.h"

namespace vt::store {

struct CatalogLayer {
  LayerInfo info;
  std::vector<Reference> roots;  // one a level, 0 to finest
};

struct Catalog {
  StoreDescription description;
  std::vector<CatalogLayer> layers;  // ordered by id
};

// Bytes of a layer's entry in a store whose superblock says `version`.
[[nodiscard]] constexpr std::size_t catalog_layer_bytes(std::uint32_t version) { return version < 3 ? 128 : 192; }

// As kFormatVersion has it. kInvalidData when over kMaxCatalogBytes.
[[nodiscard]] Result<std::vector<std::byte>> encode_catalog(const Catalog& catalog);
// `version` is that of the superblock which refers to it.
[[nodiscard]] Checked<Catalog> decode_catalog(std::span<const std::byte> payload, std::uint64_t file_end, std::uint32_t version);

// A sentence about the first field out of its range, empty when all is well. The same rules for what is
// written and what is read: numbers of channels and formats that this program does not know are no fault.
[[nodiscard]] std::string description_fault(const StoreDescription& description);
[[nodiscard]] std::string layer_fault(const LayerInfo& info);
// The same for a layer that this program makes: its channel is registered or private, and its format known.
[[nodiscard]] std::string new_layer_fault(const LayerInfo& info);
// About a layer whose owner is not among `layers`, or is not one that can own it.
[[nodiscard]] std::string owner_fault(const LayerInfo& info, std::span<const CatalogLayer> layers);

}  // namespace vt::store
