// What the store remembers of every block that was built: the layer `NAME/sources`, one constant tile for
// each block, whose value is the hash of the source content that the block was built from. A block with a
// mark is done; an update finds what changed by comparing marks. Threads: as StoreWriter.
#pragma once

#include <optional>

#include "builder/pipeline/plan/layer_plan.h"
#include "store/io/content_hash.h"
#include "store/store_writer.h"

namespace vt::pipeline {

// Must be built, or built again: tiles of it may be there and wrong.
inline constexpr store::ContentHash kStaleMark{};
// Built from carry, not from sources.
[[nodiscard]] store::ContentHash carry_mark();

class BlockMarks {
 public:
  // The layer that holds the marks of `plan`; its id and owner are for the caller to fill in.
  [[nodiscard]] static LayerInfo describe(const LayerPlan& plan, int block_levels);

  BlockMarks(store::StoreWriter& writer, LayerId layer) : writer_(writer), layer_(layer) {}

  // nullopt: never built.
  [[nodiscard]] Result<std::optional<store::ContentHash>> find(const Tier& tier, std::int64_t index) const;
  [[nodiscard]] Result<void> set(const Tier& tier, std::int64_t index, const store::ContentHash& hash);
  // Before its first tile is put: a run that ends inside the block leaves tiles behind, which whoever goes on
  // from other sources has to know.
  [[nodiscard]] Result<void> begin(const Tier& tier, std::int64_t index);

  // Whether `layer` says that any block is built; none is when it is no layer of marks.
  [[nodiscard]] static Result<bool> any_built(const store::StoreWriter& writer, const LayerInfo& layer);

 private:
  store::StoreWriter& writer_;
  LayerId layer_;
};

}  // namespace vt::pipeline
