#include "builder/source/wrapped_raster.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "builder/source/source_common.h"

namespace vt::source {

WrappedRaster::WrappedRaster(std::shared_ptr<const RasterSource> raster, std::int64_t period, std::int64_t first_column, std::int64_t width)
    : raster_(std::move(raster)), period_(period), first_column_(first_column) {
  assert(period >= 1 && period <= raster_->info().width && width >= 1);
  info_ = raster_->info();
  info_.width = width;
  const Point2 corner = info_.transform.crs_from_raster({static_cast<double>(first_column), 0.0});
  info_.transform.x0 = corner.x;
  info_.transform.y0 = corner.y;
}

template <class Use>
Result<void> WrappedRaster::for_each_piece(const Window& window, const Use& use) const {
  for (std::int64_t done = 0; done < window.width;) {
    const std::int64_t column = ((first_column_ + window.x + done) % period_ + period_) % period_;
    const std::int64_t count = std::min(window.width - done, period_ - column);
    VT_CHECK(use(Window{.x = column, .y = window.y, .width = count, .height = window.height}, done));
    done += count;
  }
  return {};
}

Result<void> WrappedRaster::read(const Window& window, std::span<const int> bands, std::span<std::byte> out, std::size_t row_pitch_bytes,
                                 store::ContentHasher* content) const {
  VT_CHECK(check_request(info_, window, bands, out, row_pitch_bytes));
  const std::size_t texel_bytes = bands.size() * sample_bytes(info_.sample_type);
  return for_each_piece(window, [&](const Window& piece, std::int64_t first) {
    return raster_->read(piece, bands, out.subspan(static_cast<std::size_t>(first) * texel_bytes), row_pitch_bytes, content);
  });
}

Result<void> WrappedRaster::hash(const Window& window, std::span<const int> bands, store::ContentHasher& content) const {
  VT_CHECK(check_window(info_, window, bands));
  return for_each_piece(window, [&](const Window& piece, std::int64_t) { return raster_->hash(piece, bands, content); });
}

}  // namespace vt::source
