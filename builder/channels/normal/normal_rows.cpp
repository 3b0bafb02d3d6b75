#include "builder/channels/normal/normal_rows.h"

#include <limits>

// Highway compiles this file once for each CPU target and chooses at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/channels/normal/normal_rows.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

// Divisions and square roots are the correctly rounded ones, sums are in one order: all targets round alike.
HWY_BEFORE_NAMESPACE();
namespace vt::channels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class V>
HWY_INLINE V length_of(V x, V y, V z) {
  return hn::Sqrt(hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z)));
}

// One vector of texels at `i`. Returns whether all have a direction.
template <class D>
HWY_INLINE bool unit_at(D d, std::size_t i, float least, float* x, float* y, float* z, float* weight) {
  const auto vx = hn::LoadU(d, x + i);
  const auto vy = hn::LoadU(d, y + i);
  const auto vz = hn::LoadU(d, z + i);
  // Divided by the largest component first: the squares of 1e30 are not floats.
  const auto largest = hn::Max(hn::Max(hn::Abs(vx), hn::Abs(vy)), hn::Abs(vz));
  const auto greatest_float = hn::Set(d, std::numeric_limits<float>::max());
  const auto is_finite = hn::And(hn::And(hn::Le(hn::Abs(vx), greatest_float), hn::Le(hn::Abs(vy), greatest_float)),
                                 hn::Le(hn::Abs(vz), greatest_float));  // false for NaN
  const auto has_direction = hn::And(is_finite, hn::Ge(largest, hn::Set(d, least)));
  const auto scaled_x = hn::Div(vx, largest);
  const auto scaled_y = hn::Div(vy, largest);
  const auto scaled_z = hn::Div(vz, largest);
  const auto length = length_of(scaled_x, scaled_y, scaled_z);
  hn::StoreU(hn::IfThenElseZero(has_direction, hn::Div(scaled_x, length)), d, x + i);
  hn::StoreU(hn::IfThenElseZero(has_direction, hn::Div(scaled_y, length)), d, y + i);
  hn::StoreU(hn::IfThenElseZero(has_direction, hn::Div(scaled_z, length)), d, z + i);
  hn::StoreU(hn::IfThenElseZero(has_direction, hn::Set(d, 1.0F)), d, weight + i);
  return hn::AllTrue(d, has_direction);
}

bool MakeUnit(std::size_t count, float least, float* x, float* y, float* z, float* weight) {
  const hn::ScalableTag<float> d;
  const hn::CappedTag<float, 1> one;
  const std::size_t lanes = hn::Lanes(d);
  bool all = true;
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) all = unit_at(d, i, least, x, y, z, weight) && all;
  for (; i < count; ++i) all = unit_at(one, i, least, x, y, z, weight) && all;
  return all;
}

template <class D>
HWY_INLINE void direction_at(D d, std::size_t i, const float* x, const float* y, const float* z, const float* weight,
                             const DirectionRows& out) {
  const auto vx = hn::LoadU(d, x + i);
  const auto vy = hn::LoadU(d, y + i);
  const auto vz = hn::LoadU(d, z + i);
  const auto w = hn::LoadU(d, weight + i);
  const auto has_data = hn::Gt(w, hn::Zero(d));
  const auto sum = length_of(vx, vy, vz);
  const auto length = hn::Min(hn::Div(sum, w), hn::Set(d, 1.0F));
  const auto has_direction = hn::And(has_data, hn::Ge(length, hn::Set(d, kLeastLength)));
  hn::StoreU(hn::IfThenElseZero(has_direction, hn::Div(vx, sum)), d, out.x + i);
  hn::StoreU(hn::IfThenElseZero(has_direction, hn::Div(vy, sum)), d, out.y + i);
  hn::StoreU(hn::IfThenElseZero(has_direction, hn::Div(vz, sum)), d, out.z + i);
  hn::StoreU(hn::IfThenElse(has_data, length, hn::Set(d, -1.0F)), d, out.length + i);
}

void DirectionAndLength(std::size_t count, const float* x, const float* y, const float* z, const float* weight, const DirectionRows& out) {
  const hn::ScalableTag<float> d;
  const hn::CappedTag<float, 1> one;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) direction_at(d, i, x, y, z, weight, out);
  for (; i < count; ++i) direction_at(one, i, x, y, z, weight, out);
}

}  // namespace vt::channels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::channels {

HWY_EXPORT(MakeUnit);
HWY_EXPORT(DirectionAndLength);

bool make_unit(std::size_t count, float least, float* x, float* y, float* z, float* weight) {
  return HWY_DYNAMIC_DISPATCH(MakeUnit)(count, least, x, y, z, weight);
}

void direction_and_length(std::size_t count, const float* x, const float* y, const float* z, const float* weight,
                          const DirectionRows& out) {
  HWY_DYNAMIC_DISPATCH(DirectionAndLength)(count, x, y, z, weight, out);
}

}  // namespace vt::channels
#endif
