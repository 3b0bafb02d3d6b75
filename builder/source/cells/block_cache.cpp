#include "builder/source/cells/block_cache.h"

namespace vt::source {

Result<BlockPtr> BlockCache::get(const BlockKey& key, const std::function<Result<Block>()>& decode) {
  return blocks_.get(
      key, [&] { return decode().map([](Block&& block) -> BlockPtr { return std::make_shared<const Block>(std::move(block)); }); });
}

}  // namespace vt::source
