// Where tile texels come from. The loader thread is its only caller; tests put slow, failing and watching
// sources in its place.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "store/layer.h"
#include "store/result.h"
#include "store/store_reader.h"

namespace vt::runtime {

class TileSource {
 public:
  virtual ~TileSource() = default;
  // Fills `out`, tightly packed in the layer's format, with `rect` of `level`; holes come from coarser
  // levels.
  [[nodiscard]] virtual Result<void> read(Level level, const TexelRect& rect, std::span<std::byte> out) = 0;
};

class StoreTileSource final : public TileSource {
 public:
  StoreTileSource(std::shared_ptr<const store::StoreReader> reader, LayerId layer) : reader_(std::move(reader)), layer_(layer) {}
  [[nodiscard]] Result<void> read(Level level, const TexelRect& rect, std::span<std::byte> out) override;

 private:
  std::shared_ptr<const store::StoreReader> reader_;
  LayerId layer_;
};

}  // namespace vt::runtime
