// What a store says of itself, apart from its layers. Plain values, any thread.
#pragma once

#include <cstdint>
#include <string>

#include "store/layer.h"

namespace vt::store {

// What the dataset is, fixed when the store is created.
struct StoreDescription {
  Area area;
  std::string metadata_json = "{}";  // coordinate reference system and provenance; schemas/store-metadata.schema.json
};

// A store has two superblocks, either of which is enough.
enum class StoreHealth : std::uint8_t {
  kWhole,
  kOneSuperblock,  // one is damaged. Nothing that was committed is lost; the next writer mends it
  kMayBeOlder,     // one is damaged, and may have held a later generation than this one. Only in a store that an older program has written
};

}  // namespace vt::store
