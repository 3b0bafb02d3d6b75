#include "builder/channels/color/color_rows.h"

// Highway compiles this file once for each CPU target and chooses at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/channels/color/color_rows.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vt::channels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void LightFromRgb8(const std::uint8_t* rgb, std::size_t count, const CodeTable& table, float* red, float* green, float* blue) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  const float* light = table.light_table().data();
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::Vec<decltype(d8)> r;
    hn::Vec<decltype(d8)> g;
    hn::Vec<decltype(d8)> b;
    hn::LoadInterleaved3(d8, rgb + 3 * i, r, g, b);
    hn::StoreU(hn::GatherIndex(d, light, hn::PromoteTo(di, r)), d, red + i);
    hn::StoreU(hn::GatherIndex(d, light, hn::PromoteTo(di, g)), d, green + i);
    hn::StoreU(hn::GatherIndex(d, light, hn::PromoteTo(di, b)), d, blue + i);
  }
  for (; i < count; ++i) {
    red[i] = light[rgb[3 * i]];
    green[i] = light[rgb[3 * i + 1]];
    blue[i] = light[rgb[3 * i + 2]];
  }
}

// CodeTable::code for a vector of light from `column` on.
template <class D>
HWY_INLINE hn::Vec<hn::Rebind<std::uint8_t, D>> codes(D d, std::size_t column, hn::Vec<D> light, const CodeTable& table) {
  const hn::RebindToSigned<D> di;
  const auto positive = hn::IfThenElseZero(hn::Gt(light, hn::Zero(d)), light);  // also takes NaN away
  const auto clamped = hn::Min(positive, hn::Set(d, 1.0F));
  const auto bin = hn::ConvertTo(di, hn::Mul(clamped, hn::Set(d, static_cast<float>(CodeTable::kBins))));
  const auto lower = hn::GatherIndex(di, table.code_at_bin(), bin);
  // Vectors of several lanes begin in even columns.
  const auto columns = hn::Iota(di, HWY_TARGET == HWY_SCALAR ? static_cast<std::int32_t>(column & 1) : 0);
  const auto later = hn::Mul(hn::And(columns, hn::Set(di, 1)), hn::Set(di, 2 * CodeTable::kTieFloats));
  const auto next_begin = hn::BitCast(d, hn::Add(hn::BitCast(di, hn::GatherIndex(d, table.next_begin_at_bin(), bin)), later));
  // A true lane of a mask is -1.
  const auto code = hn::Sub(lower, hn::VecFromMask(di, hn::RebindMask(di, hn::Ge(clamped, next_begin))));
  return hn::DemoteTo(hn::Rebind<std::uint8_t, D>(), code);
}

void Rgb8FromLight(const float* red, const float* green, const float* blue, std::size_t count, const CodeTable& table, std::uint8_t* rgb) {
  const hn::ScalableTag<float> d;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    hn::StoreInterleaved3(codes(d, i, hn::LoadU(d, red + i), table), codes(d, i, hn::LoadU(d, green + i), table),
                          codes(d, i, hn::LoadU(d, blue + i), table), d8, rgb + 3 * i);
  for (; i < count; ++i) {
    const auto column = static_cast<std::int64_t>(i);
    rgb[3 * i] = table.code(red[i], column);
    rgb[3 * i + 1] = table.code(green[i], column);
    rgb[3 * i + 2] = table.code(blue[i], column);
  }
}

}  // namespace vt::channels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::channels {

HWY_EXPORT(LightFromRgb8);
HWY_EXPORT(Rgb8FromLight);

void light_from_rgb8(const std::uint8_t* rgb, std::size_t count, const CodeTable& table, float* red, float* green, float* blue) {
  HWY_DYNAMIC_DISPATCH(LightFromRgb8)(rgb, count, table, red, green, blue);
}

void rgb8_from_light(const float* red, const float* green, const float* blue, std::size_t count, const CodeTable& table,
                     std::uint8_t* rgb) {
  HWY_DYNAMIC_DISPATCH(Rgb8FromLight)(red, green, blue, count, table, rgb);
}

}  // namespace vt::channels
#endif
