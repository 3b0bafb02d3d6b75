#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/virtual_texture.h"
#include "store/region.h"
#include "store/store_reader.h"
#include "store/texel/texel_decoder.h"

namespace vt::runtime {

Result<HeightField> HeightField::read(const store::StoreReader& reader, LayerId layer, int most_texels) {
  const LayerInfo* info = reader.find_layer(layer);
  if (info == nullptr) return fail(ErrorCode::kUsage, reader.path().string() + ": no layer with number " + std::to_string(layer.value));
  VT_CHECK(reader.check_readable(layer));
  const FormatInfo& format = format_info(info->format);
  if (info->format != TexelFormat::kR32Float && info->format != TexelFormat::kR16Float && info->format != TexelFormat::kR16)
    return fail(ErrorCode::kUsage, reader.path().string() + ": layer \"" + info->name + "\" holds " + std::string(format.name) +
                                       " texels; heights are r32f, r16f or r16");
  if (most_texels < 1 || most_texels > 8192) return fail(ErrorCode::kUsage, "a height field is 1 to 8192 texels wide");

  Level level = info->finest;
  while (level.value > 0 && std::max(info->data_rect(level).width, info->data_rect(level).height) > most_texels) --level.value;
  HeightField field(VtMapping(reader.description().area, *info), level, info->data_rect(level), info->value_offset(level));
  if (std::max(field.rect_.width, field.rect_.height) > 8192)
    return fail(ErrorCode::kUnsupported,
                reader.path().string() + ": even the coarsest level of \"" + info->name + "\" is more than 8192 texels wide");
  field.heights_.resize(static_cast<std::size_t>(field.rect_.width * field.rect_.height));
  std::vector<std::byte> texels(field.heights_.size() * format.block_bytes);
  VT_CHECK(store::read_region(reader, layer, level, field.rect_, texels));
  store::decode_texels(info->format, texels, static_cast<std::size_t>(field.rect_.width), static_cast<std::size_t>(field.rect_.height),
                       field.heights_);

  bool any = false;
  const ComponentRange& range = info->components[0];
  for (float& height : field.heights_) {
    const bool is_data = std::isfinite(height) && !(info->zero_is_nodata && height == 0.0F);
    height =
        is_data ? static_cast<float>(range.offset + range.scale * static_cast<double>(height)) : std::numeric_limits<float>::quiet_NaN();
    if (!is_data) continue;
    field.min_ = any ? std::min(field.min_, double{height}) : height;
    field.max_ = any ? std::max(field.max_, double{height}) : height;
    any = true;
  }
  return field;
}

double HeightField::at(Point2 uv, double fallback) const {
  const Point2 texel = mapping_.texel_from_uv(level_, uv);
  const double x = std::clamp(texel.x - static_cast<double>(rect_.x) - value_offset_, 0.0, static_cast<double>(rect_.width - 1));
  const double y = std::clamp(texel.y - static_cast<double>(rect_.y) - value_offset_, 0.0, static_cast<double>(rect_.height - 1));
  if (!std::isfinite(x) || !std::isfinite(y)) return fallback;
  const auto x0 = static_cast<std::int64_t>(x);
  const auto y0 = static_cast<std::int64_t>(y);
  double sum = 0.0;
  double weight = 0.0;
  for (std::int64_t j = 0; j < 2; ++j) {
    for (std::int64_t i = 0; i < 2; ++i) {
      const std::int64_t column = std::min(x0 + i, rect_.width - 1);
      const std::int64_t row = std::min(y0 + j, rect_.height - 1);
      const double w = std::abs(1.0 - static_cast<double>(i) - (x - static_cast<double>(x0))) *
                       std::abs(1.0 - static_cast<double>(j) - (y - static_cast<double>(y0)));
      const float height = heights_[static_cast<std::size_t>(row * rect_.width + column)];
      // A hole must not pull the surface down.
      if (!std::isfinite(height)) continue;
      sum += w * height;
      weight += w;
    }
  }
  return weight > 0.0 ? sum / weight : fallback;
}

}  // namespace vt::runtime
