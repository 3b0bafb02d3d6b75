#include "builder/channels/shared/unorm_rows.h"

// Highway compiles this file once for each CPU target and chooses at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "builder/channels/shared/unorm_rows.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vt::channels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void UnormCodes(const UnormCode& code, std::size_t count, const float* values, std::uint16_t* codes) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<std::uint16_t, decltype(d)> d16;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto clamped = hn::Min(hn::Max(hn::LoadU(d, values + i), hn::Set(d, code.low)), hn::Set(d, code.high));
    const auto rounded = hn::ConvertTo(di, hn::Add(hn::Mul(clamped, hn::Set(d, code.gain)), hn::Set(d, code.bias)));
    hn::StoreU(hn::DemoteTo(d16, rounded), d16, codes + i);
  }
  for (; i < count; ++i) codes[i] = code.code(values[i]);
}

}  // namespace vt::channels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vt::channels {

HWY_EXPORT(UnormCodes);

void unorm_codes(const UnormCode& code, std::size_t count, const float* values, std::uint16_t* codes) {
  HWY_DYNAMIC_DISPATCH(UnormCodes)(code, count, values, codes);
}

}  // namespace vt::channels
#endif
