#include "builder/resample/rows/row_kernels.h"

// Highway compiles this file once for each CPU target and chooses at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/resample/rows/row_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vt::resample::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Add and Mul, never MulAdd: a fused one rounds once and exists on some CPUs only.
void AddWeighted(const float* values, double weight, std::size_t count, double* sums) {
  const hn::ScalableTag<double> d;
  const hn::Rebind<float, decltype(d)> df;
  const std::size_t lanes = hn::Lanes(d);
  const auto factor = hn::Set(d, weight);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    hn::StoreU(hn::Add(hn::LoadU(d, sums + i), hn::Mul(factor, hn::PromoteTo(d, hn::LoadU(df, values + i)))), d, sums + i);
  for (; i < count; ++i) sums[i] += weight * static_cast<double>(values[i]);
}

template <class D>
HWY_INLINE void interpolate_at(D d, const FourSamples& s, std::size_t i, float* out) {
  const auto at = [&](const float* row) HWY_ATTR { return hn::LoadU(d, row + i); };
  const auto mix = [&](auto a, auto b, auto f) HWY_ATTR { return hn::Add(a, hn::Mul(f, hn::Sub(b, a))); };
  const auto fx = at(s.fraction_x);
  const auto north = mix(at(s.north_west), at(s.north_east), fx);
  const auto south = mix(at(s.south_west), at(s.south_east), fx);
  hn::StoreU(mix(north, south, at(s.fraction_y)), d, out + i);
}

void Interpolate(const FourSamples& samples, std::size_t count, float* out) {
  const hn::ScalableTag<float> d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) interpolate_at(d, samples, i, out);
  const hn::CappedTag<float, 1> one;
  for (; i < count; ++i) interpolate_at(one, samples, i, out);
}

}  // namespace vt::resample::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::resample {

HWY_EXPORT(AddWeighted);
HWY_EXPORT(Interpolate);

void add_weighted(const float* values, double weight, std::size_t count, double* sums) {
  HWY_DYNAMIC_DISPATCH(AddWeighted)(values, weight, count, sums);
}

void interpolate(const FourSamples& samples, std::size_t count, float* out) { HWY_DYNAMIC_DISPATCH(Interpolate)(samples, count, out); }

}  // namespace vt::resample
#endif
