// The words of the block encoders' kernels, which work on one block per float lane. Included once per SIMD
// target.
#if defined(VT_BUILDER_ENCODE_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef VT_BUILDER_ENCODE_LANES_INL_H_
#undef VT_BUILDER_ENCODE_LANES_INL_H_
#else
#define VT_BUILDER_ENCODE_LANES_INL_H_
#endif

#include <hwy/highway.h>

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace vt::encode::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::ScalableTag<float>;
using IntTag = hn::RebindToSigned<FloatTag>;
using UintTag = hn::RebindToUnsigned<FloatTag>;
using F = hn::Vec<FloatTag>;
using I = hn::Vec<IntTag>;
using U = hn::Vec<UintTag>;
using FloatMask = hn::Mask<FloatTag>;

constexpr std::size_t kMaxLanes = hn::MaxLanes(FloatTag());

HWY_INLINE F constant(float value) { return hn::Set(FloatTag(), value); }
HWY_INLINE F clamped(F value, float low, float high) { return hn::Min(hn::Max(value, constant(low)), constant(high)); }

}  // namespace
}  // namespace vt::encode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
