#include "builder/pipeline/plan/planned_tile.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>

#include "builder/encode/tile_band.h"
#include "builder/pipeline/plan/feed_rows.h"
#include "builder/pipeline/plan/tiers.h"
#include "builder/pyramid/make_cascade.h"

namespace vt::pipeline {
namespace {

// Rows from `by` texels further east.
channels::RowNeighbourhood moved(const channels::RowNeighbourhood& rows, int planes, std::int64_t by) {
  channels::RowNeighbourhood out{.opaque = rows.opaque};
  for (std::size_t p = 0; p < static_cast<std::size_t>(planes); ++p) {
    out.above[p] = rows.above[p] + by;
    out.here[p] = rows.here[p] + by;
    out.below[p] = rows.below[p] + by;
  }
  return out;
}

}  // namespace

// Takes the finished rows of one tile.
class PlannedTiles::Sink final : public pyramid::RowSink {
 public:
  Sink(const LayerPlan& plan, std::size_t part, TileId tile, const TexelRect& core, PlannedTile& out)
      : plan_(plan),
        part_(part),
        place_(rect_of(tile, plan.info.tile_exponent)),
        core_(core),
        out_(out),
        comes_as_texels_(static_cast<std::size_t>(core.height), false),
        band_(plan.parts[part], *plan.codec, part, {store::Codec::kRaw, 0}, plan.request.quality, tile.level, core, nullptr) {}

  void row(int, std::int64_t y, const channels::RowNeighbourhood& rows) override {
    if (!status_) return;
    const auto planes = static_cast<std::size_t>(plan_.codec->planes());
    const auto width = static_cast<std::size_t>(core_.width);
    float* to = out_.planes.data() + static_cast<std::size_t>(y - core_.y) * planes * width;
    for (std::size_t p = 0; p < planes; ++p) to = std::copy_n(rows.here[p], width, to);
    if (comes_as_texels_[static_cast<std::size_t>(y - core_.y)]) return;
    auto added = band_.add_row(y, rows);
    if (!added) status_ = add_texel_by_texel(y, rows, added.error());
  }

  // See feed_rows(): bytes of the sources that are passed on keep what clear texels hold. They are those of
  // the first part.
  bool expect_texels(std::int64_t y) {
    const bool is_first_part = part_ == 0;
    comes_as_texels_[static_cast<std::size_t>(y - core_.y)] = is_first_part;
    return is_first_part;
  }
  void texels(std::int64_t y, const std::byte* texels, const channels::ConstPlaneRow& planes, bool opaque) {
    if (status_) band_.add_texels(y, texels, planes, opaque);
  }

  [[nodiscard]] Result<void> finish() {
    VT_CHECK(status_);
    VT_CHECK(band_.take_finished([&](const encode::EncodedTile& tile) -> Result<void> {
      out_.is_empty = tile.is_empty;
      out_.payload.assign(tile.is_empty ? 0 : plan_.parts[part_].tile_payload_bytes(), std::byte{0});
      const std::span<const std::byte> stored = tile.constant_block.empty() ? tile.payload.bytes : tile.constant_block;
      for (std::size_t at = 0; at < out_.payload.size(); at += stored.size()) std::ranges::copy(stored, &out_.payload[at]);
      return {};
    }));
    for (const std::int64_t y : rows_by_texel_) {
      const auto from = static_cast<std::size_t>((y - core_.y) * core_.width) * texel_bytes_;
      const auto to = static_cast<std::size_t>((y - place_.y) * place_.width + core_.x - place_.x) * texel_bytes_;
      out_.is_empty = false;
      out_.payload.resize(plan_.parts[part_].tile_payload_bytes());
      std::memcpy(&out_.payload[to], &texels_[from], static_cast<std::size_t>(core_.width) * texel_bytes_);
    }
    return {};
  }

 private:
  // A row that does not fit as a whole. Only formats of codes and floats refuse values, and there a texel
  // needs no neighbours to be stored.
  Result<void> add_texel_by_texel(std::int64_t y, const channels::RowNeighbourhood& rows, const Error& refusal) {
    const channels::Part& part = plan_.codec->parts()[part_];
    if (refusal.code != ErrorCode::kInvalidData || part.format != part.texel_format) return tl::unexpected(refusal);
    const auto width = static_cast<std::size_t>(core_.width);
    if (out_.misfits.empty()) {
      out_.misfits.assign(width * static_cast<std::size_t>(core_.height), 0);
      out_.misfit = refusal.message;
      texels_.resize(out_.misfits.size() * texel_bytes_);
    }
    rows_by_texel_.push_back(y);
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y - core_.y) * width + x;
      const auto one = moved(rows, plan_.codec->planes(), static_cast<std::int64_t>(x));
      if (plan_.codec->encode_row(part_, one, 1, &texels_[at * texel_bytes_])) continue;
      out_.misfits[at] = 1;
      std::memset(&texels_[at * texel_bytes_], 0, texel_bytes_);
    }
    return {};
  }

  const LayerPlan& plan_;
  std::size_t part_;
  TexelRect place_;
  TexelRect core_;
  PlannedTile& out_;
  std::vector<bool> comes_as_texels_;  // by row of core_
  encode::TileBand band_;
  std::size_t texel_bytes_ = format_info(plan_.parts[part_].format).block_bytes;
  std::vector<std::int64_t> rows_by_texel_;
  std::vector<std::byte> texels_;  // of core_; only those rows are used
  Result<void> status_;
};

PlannedTiles::PlannedTiles(const LayerPlan& plan, std::size_t part) : plan_(plan), part_(part) {}

Result<void> PlannedTiles::make(TileId tile, PlannedTile& out) {
  const TexelRect block = rect_of(tile, plan_.info.tile_exponent);
  const std::unique_ptr<pyramid::Cascade> cascade =
      pyramid::make_cascade(pyramid::plan_block(block, plan_.shape(), 0, 1, false, plan_.kernel), plan_.shape(), 1, *plan_.codec,
                            plan_.kernel, plan_.info.tile_exponent, area_exponent(plan_));
  const TexelRect active = cascade->level(0).active;
  const TexelRect core = cascade->level(0).core;
  out.rect = core;
  out.misfits.clear();
  out.misfit.clear();
  out.planes.resize(static_cast<std::size_t>(core.width * core.height * plan_.codec->planes()));
  Sink sink(plan_, part_, tile, core, out);
  for (std::int64_t y = active.y; y < active.bottom(); y += kChunkRows) {
    const TexelRect rows{active.x, y, active.width, std::min(kChunkRows, active.bottom() - y)};
    VT_CHECK(chunk_.load(plan_, rows));
    feed_rows(chunk_, rows, *plan_.codec, *cascade, sink,
              [&](std::int64_t at, const channels::PlaneRow& planes) { return chunk_.decode_row(*plan_.codec, at, planes); });
  }
  VT_CHECK(cascade->status());
  return sink.finish();
}

}  // namespace vt::pipeline
