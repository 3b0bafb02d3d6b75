// A raster that goes once round the globe, read as one that goes on to the east and to the west. Immutable;
// any number of threads.
#pragma once

#include <cstdint>
#include <memory>

#include "builder/source/raster_source.h"

namespace vt::source {

class WrappedRaster final : public RasterSource {
 public:
  // The first `period` columns of `raster`, at most all of them, come again and again. Column 0 of this is
  // column `first_column` of the endless raster, which may be negative. The transform is moved along; all
  // else is the raster's own.
  WrappedRaster(std::shared_ptr<const RasterSource> raster, std::int64_t period, std::int64_t first_column, std::int64_t width);

  using RasterSource::read;
  [[nodiscard]] Result<void> read(const Window& window, std::span<const int> bands, std::span<std::byte> out, std::size_t row_pitch_bytes,
                                  store::ContentHasher* content) const override;
  [[nodiscard]] Result<void> hash(const Window& window, std::span<const int> bands, store::ContentHasher& content) const override;
  void release_rows_before(std::int64_t row) const override { raster_->release_rows_before(row); }
  [[nodiscard]] std::size_t resident_bytes() const override { return raster_->resident_bytes(); }
  [[nodiscard]] std::uint64_t decoded_bytes() const override { return raster_->decoded_bytes(); }

 private:
  // Calls use(window of the raster, first column of it in `window`) for the pieces between the seams, from
  // west to east.
  template <class Use>
  [[nodiscard]] Result<void> for_each_piece(const Window& window, const Use& use) const;

  std::shared_ptr<const RasterSource> raster_;
  std::int64_t period_;
  std::int64_t first_column_;
};

}  // namespace vt::source
