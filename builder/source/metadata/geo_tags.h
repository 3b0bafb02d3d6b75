// Numbers of the TIFF tags that libtiff does not know: OGC 19-008r4 and GDAL's own. Private to
// builder/source.
#pragma once

#include <cstdint>

namespace vt::source {

inline constexpr std::uint16_t kModelPixelScale = 33550;
inline constexpr std::uint16_t kModelTiepoint = 33922;
inline constexpr std::uint16_t kModelTransformation = 34264;
inline constexpr std::uint16_t kGeoKeyDirectory = 34735;
inline constexpr std::uint16_t kGeoDoubleParams = 34736;
inline constexpr std::uint16_t kGeoAsciiParams = 34737;
inline constexpr std::uint16_t kGdalMetadata = 42112;
inline constexpr std::uint16_t kGdalNodata = 42113;
inline constexpr std::uint16_t kRpcCoefficients = 50844;

}  // namespace vt::source
