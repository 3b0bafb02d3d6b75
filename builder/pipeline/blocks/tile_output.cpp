#include "builder/pipeline/blocks/tile_output.h"

#include <string>

namespace vt::pipeline {

TileOutput::TileOutput(const TileTarget& to, const Tier& tier, const pyramid::Cascade& cascade)
    : to_(to),
      parts_(to.plan.parts.size()),
      base_core_(cascade.level(0).core),
      losses_(tier.base == to.plan.info.finest ? to.plan.sampler->codec().losses().size() : 0),
      has_base_texels_(static_cast<std::size_t>(base_core_.height), false) {
  const channels::ChannelCodec& codec = to.plan.sampler->codec();
  const bool is_measured = !codec.measures().empty();
  const auto level_of = [&](int k) { return Level{static_cast<std::uint8_t>(tier.base.value - k)}; };
  for (int k = 0; k < tier.outputs; ++k)
    references_.emplace_back(to.plan.info, codec.planes(), level_of(k), is_measured ? cascade.level(k).core : TexelRect{});
  for (int k = 0; k < tier.outputs; ++k)
    for (std::size_t part = 0; part < parts_; ++part) {
      const Level level = level_of(k);
      const bool is_left_out = level == to.plan.info.finest ? codec.parts()[part].starts_above_base : codec.parts()[part].ends_at_base;
      bands_.emplace_back(to.plan.parts[part], codec, part, to.plan.compression, to.plan.request.quality, level,
                          is_left_out ? TexelRect{} : cascade.level(k).core,
                          is_measured ? &references_[static_cast<std::size_t>(k)] : nullptr);
    }
}

void TileOutput::row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) {
  if (!status_) return;
  const InStage stage(to_.clock, Stage::kQuantise);
  if (k == 0 && !losses_.empty())
    to_.plan.sampler->codec().count_losses(rows.here, rows.opaque, base_core_.width, base_core_.x - to_.plan.info.data.x,
                                           y - to_.plan.info.data.y, losses_);
  const bool comes_as_texels = k == 0 && has_base_texels_[static_cast<std::size_t>(y - base_core_.y)];
  // The first part may take such a row before or after the others: the reference is kept for whoever is
  // first.
  if (!comes_as_texels || parts_ > 1) references_[static_cast<std::size_t>(k)].keep(y, rows.here);
  for (std::size_t part = comes_as_texels ? 1 : 0; part < parts_ && status_; ++part) add_row(band_of(k, part), part, y, rows);
}

void TileOutput::add_row(encode::TileBand& band, std::size_t part, std::int64_t y, const channels::RowNeighbourhood& rows) {
  if (band.is_empty()) return;
  status_ = band.add_row(y, rows);
  if (status_) {
    store_finished(band, part);
  } else {
    status_ = fail(status_.error().code, "layer '" + to_.plan.parts[part].name + "', level " + std::to_string(band.level().value) +
                                             ", row " + std::to_string(y) + ": " + status_.error().message);
  }
}

bool TileOutput::expect_texels(std::int64_t y) {
  has_base_texels_[static_cast<std::size_t>(y - base_core_.y)] = true;
  return true;
}

void TileOutput::texels(std::int64_t y, const std::byte* texels, const channels::ConstPlaneRow& planes, bool opaque) {
  if (!status_) return;
  const InStage stage(to_.clock, Stage::kQuantise);
  references_[0].keep(y, planes);
  bands_[0].add_texels(y, texels, planes, opaque);
  store_finished(bands_[0], 0);
}

BlockQuality TileOutput::quality() const {
  BlockQuality quality{.levels = {}, .losses = losses_};
  for (std::size_t i = 0; i < bands_.size(); ++i) {
    if (i % parts_ == 0)
      quality.levels.emplace_back(bands_[i].errors().begin(), bands_[i].errors().end());
    else
      for (std::size_t m = 0; m < quality.levels.back().size(); ++m) quality.levels.back()[m] += bands_[i].errors()[m];
  }
  return quality;
}

void TileOutput::store_finished(encode::TileBand& band, std::size_t part) {
  const InStage stage(to_.clock, Stage::kEncode);
  status_ = band.take_finished([&](const encode::EncodedTile& tile) {
    const InStage store(to_.clock, Stage::kStore);
    return put_tile(to_.writer, to_.ids.parts[part], tile, to_.counts);
  });
}

}  // namespace vt::pipeline
