#include "builder/resample/rows/texel_footprints.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "builder/resample/grid/buffers.h"

namespace vt::resample {
namespace {

bool is_number(const Point2& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

const std::array<Point2, kPlaces>& places_in_texel() {
  static const std::array<Point2, kPlaces> places = [] {
    std::array<Point2, kPlaces> all{};
    for (int i = 0; i < kPlaces; ++i) all[static_cast<std::size_t>(i)] = place_in_texel(i);
    return all;
  }();
  return places;
}

}  // namespace

void PlaceBounds::add(const Point2& p) {
  if (!is_number(p)) return;
  min_ = {std::min(min_.x, p.x), std::min(min_.y, p.y)};
  max_ = {std::max(max_.x, p.x), std::max(max_.y, p.y)};
}

TexelRect PlaceBounds::samples_of(const TexelRect& raster, double reach) const {
  const auto sample_at = [](double v, std::int64_t first, std::int64_t end) {
    return static_cast<std::int64_t>(std::clamp(std::floor(v), static_cast<double>(first), static_cast<double>(end - 1)));
  };
  const std::int64_t x = sample_at(min_.x - reach, raster.x, raster.right());
  const std::int64_t y = sample_at(min_.y - reach, raster.y, raster.bottom());
  return {x, y, sample_at(max_.x + reach, raster.x, raster.right()) - x + 1, sample_at(max_.y + reach, raster.y, raster.bottom()) - y + 1};
}

void TexelFootprints::find(const GridSources& sources, const TexelRect& part, bool alone, TexelBlock* out) {
  sources_ = &sources;
  part_ = part;
  alone_ = alone;
  find_positions();
  leave_out_the_rest(alone ? nullptr : out);
}

void TexelFootprints::find_positions() {
  const auto texels = static_cast<std::size_t>(part_.width * part_.height);
  refit(centres_, texels);
  refit(samples_per_texel_, texels);
  refit(kinds_, texels);
  sources_->warp->map_centres(part_, centres_, &patches_);
  const double limit = sources_->method == Method::kNearest ? kMostPicked : kMostUnit;
  // Classes are counted in all of a layer or nowhere.
  const bool counts = sources_->counts_areas || !sources_->codec().class_counting();
  has_units_ = has_areas_ = false;
  for (const GridWarp::Patch& patch : patches_) {
    const Kind kind = counts && patch.samples_per_texel > limit ? Kind::kArea : Kind::kOneSample;
    (kind == Kind::kArea ? has_areas_ : has_units_) = true;
    for (std::int64_t y = patch.texels.y; y < patch.texels.bottom(); ++y) {
      const auto at = static_cast<std::ptrdiff_t>(index_of(patch.texels.x, y));
      std::fill_n(samples_per_texel_.begin() + at, patch.texels.width, static_cast<float>(patch.samples_per_texel));
      std::fill_n(kinds_.begin() + at, patch.texels.width, kind);
    }
  }
  if (!has_areas_ && alone_) return;
  refit(corners_, static_cast<std::size_t>((part_.width + 1) * (part_.height + 1)));
  sources_->warp->map_corners(part_, corners_);
}

// By small pieces, of which most lie wholly inside the sources.
void TexelFootprints::leave_out_the_rest(TexelBlock* out) {
  constexpr std::int64_t kPiece = 32;
  const bool is_one_raster = sources_->grid.members().size() == 1;
  near_.assign(1, sources_->grid.bounds());
  for (std::int64_t y = part_.y; y < part_.bottom(); y += kPiece)
    for (std::int64_t x = part_.x; x < part_.right(); x += kPiece) {
      const TexelRect piece = intersect(part_, {x, y, kPiece, kPiece});
      if (!is_one_raster && is_filled(piece)) near_.assign(1, sources_->grid.bounds());
      for (std::int64_t row = piece.y; row < piece.bottom(); ++row)
        for (std::int64_t column = piece.x; column < piece.right(); ++column) locate(column, row, out);
    }
}

// Whether all of a piece that lies within the grid's bounds lies in a source; `near_` becomes the sources
// that are near it.
bool TexelFootprints::is_filled(const TexelRect& piece) {
  PlaceBounds bounds;
  for (std::int64_t y = piece.y; y < piece.bottom(); ++y)
    for (std::int64_t x = piece.x; x < piece.right(); ++x) {
      bounds.add(centres_[index_of(x, y)]);
      if (!alone_)
        for (const Point2& corner : corners(x, y).corner) bounds.add(corner);
    }
  near_.clear();
  if (bounds.is_empty()) return false;
  const TexelRect around = bounds.samples_of(sources_->grid.bounds(), 0.0);
  sources_->grid.index().find(around, found_);
  for (const std::uint32_t number : found_) near_.push_back(sources_->grid.members()[number].rect);
  return covers(near_, around);
}

void TexelFootprints::locate(std::int64_t x, std::int64_t y, TexelBlock* out) {
  const std::size_t texel = index_of(x, y);
  const bool has_centre = is_in_a_source(centres_[texel]);
  std::uint64_t places = has_centre ? kAllPlaces : 0;
  const bool is_picked = sources_->method == Method::kNearest && kinds_[texel] == Kind::kOneSample;
  if (!alone_ && !is_picked) {
    places = places_of(corners(x, y));
    if (has_centre) places |= 1;  // also of a raster that is smaller than a texel
  }
  if (out != nullptr) {
    out->has_centre[out->index_of(x, y)] = has_centre ? 1 : 0;
    out->places[out->index_of(x, y)] = places;
  }
  if (places == 0) kinds_[texel] = Kind::kNothing;
}

// Nearest: on a border between two samples a place belongs to the next one, so that it belongs to one or to
// none.
bool TexelFootprints::is_in_a_source(const Point2& p) const {
  const bool ends_are_in = sources_->method == Method::kBilinear;
  return std::ranges::any_of(near_, [&](const TexelRect& rect) {
    const auto right = static_cast<double>(rect.right());
    const auto bottom = static_cast<double>(rect.bottom());
    return p.x >= static_cast<double>(rect.x) && p.y >= static_cast<double>(rect.y) && (ends_are_in ? p.x <= right : p.x < right) &&
           (ends_are_in ? p.y <= bottom : p.y < bottom);
  });
}

std::uint64_t TexelFootprints::places_of(const Quad& quad) const {
  const auto holds = [&](const TexelRect& rect) {
    return std::ranges::all_of(quad.corner, [&](const Point2& p) {
      return p.x >= static_cast<double>(rect.x) && p.y >= static_cast<double>(rect.y) && p.x <= static_cast<double>(rect.right()) &&
             p.y <= static_cast<double>(rect.bottom());
    });
  };
  if (std::ranges::any_of(near_, holds)) return kAllPlaces;
  std::uint64_t places = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const Point2& at = places_in_texel()[static_cast<std::size_t>(i)];
    const auto mix = [&](double nw, double ne, double se, double sw) {
      return (nw * (1 - at.x) + ne * at.x) * (1 - at.y) + (sw * (1 - at.x) + se * at.x) * at.y;
    };
    const auto& c = quad.corner;
    if (is_in_a_source({mix(c[0].x, c[1].x, c[2].x, c[3].x), mix(c[0].y, c[1].y, c[2].y, c[3].y)})) places |= std::uint64_t{1} << i;
  }
  return places;
}

Quad TexelFootprints::corners(std::int64_t x, std::int64_t y) const {
  const Point2* const north = &corners_[static_cast<std::size_t>((y - part_.y) * (part_.width + 1) + (x - part_.x))];
  const Point2* const south = north + part_.width + 1;
  return {{north[0], north[1], south[1], south[0]}};
}

Quad TexelFootprints::footprint(std::int64_t x, std::int64_t y) const {
  const Quad quad = corners(x, y);
  const std::size_t texel = index_of(x, y);
  // Where a corner has no place in the source, or longitudes jump within the texel, there is no such
  // quadrilateral.
  const double most = 2.0 * static_cast<double>(samples_per_texel_[texel]) + 2.0;
  const bool is_sound = quad.greatest_x() - quad.least_x() <= most && quad.greatest_y() - quad.least_y() <= most;
  if (!is_sound || !quad.is_finite()) return one_sample_around(centres_[texel]);
  return sources_->method == Method::kNearest ? quad : quad.at_least_one_sample();
}

std::int64_t TexelFootprints::fitting_width() const {
  const Point2& west = corners_[0];
  const Point2& east = corners_[static_cast<std::size_t>(part_.width)];
  const Point2& south = corners_[static_cast<std::size_t>(part_.height * (part_.width + 1))];
  const double rise = std::abs(east.y - west.y) / static_cast<double>(part_.width);
  const double height = std::abs(south.y - west.y);
  if (!(rise > 0.0 && height > 0.0)) return part_.width;
  return std::clamp(static_cast<std::int64_t>(std::min(height / (3.0 * rise), 1e9)), std::min<std::int64_t>(32, part_.width), part_.width);
}

}  // namespace vt::resample
