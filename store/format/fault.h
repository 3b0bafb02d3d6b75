// What can be wrong with a store, with its stable number. One check makes one Fault; the reader turns it into
// an Error, the validator into a Finding, so both say the same sentence. Plain values, any thread.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "store/result.h"

namespace vt::store {

// Listed in schemas/tile-store.md. Append; never renumber, never reuse.
enum class FaultNumber : int {
  // Superblocks
  kSuperblockDamaged = 101,   // one of the two; not an error while the other is whole, because a crash in a commit leaves this
  kNoSuperblock = 102,        // neither is whole
  kVersion = 103,             // a later format
  kSuperblockReserved = 104,  // reserved bytes are set
  kFileTruncated = 105,       // the file ends before the generation does
  kSuperblockField = 106,     // a generation in the wrong slot, or an end that is no record boundary
  kForeignSuperblock = 107,   // the two belong to different stores
  kUncommittedTail = 108,     // not an error: bytes after the last commit
  kGarbage = 109,             // not an error: bytes in the log that nothing points to
  kMayBeOlder = 110,          // one superblock is damaged, and may have held a later generation than the other
  kMoreFindings = 199,        // the report was cut

  // Catalog
  kCatalogReference = 201,
  kCatalogRecord = 202,
  kCatalogStructure = 203,
  kLayerField = 204,
  kLayerClash = 205,  // layers out of order, two of one name, a carry layer without its owner

  // Index
  kPageReference = 301,
  kPageRecord = 302,
  kPageStructure = 303,
  kPageEntry = 304,

  // Tiles
  kTileRecord = 401,
  kTileDecode = 402,
  kPadding = 403,
  kParentAbsent = 404,

  // Layers
  kLayerBuilding = 501,  // not an error
  kLayerCounts = 502,
  kTileOutsideData = 503,  // not an error
  kUnknownChannel = 504,   // not an error: a number of a newer program, or of a user's own
  kUnknownFormat = 505,    // not an error: the layer cannot be read, all others can
};

struct Fault {
  FaultNumber number;
  ErrorCode code;
  std::string sentence;
};

template <class T>
using Checked = tl::expected<T, Fault>;

[[nodiscard]] inline tl::unexpected<Fault> fault(FaultNumber number, ErrorCode code, std::string sentence) {
  return tl::unexpected<Fault>(Fault{number, code, std::move(sentence)});
}

}  // namespace vt::store
