// Numbers of the GeoTIFF keys, annex of OGC 19-008r4.
#pragma once

#include <cstdint>

namespace vt::geo {

enum class GeoKey : std::uint16_t {
  kNone = 0,
  kModelType = 1024,
  kRasterType = 1025,
  kCitation = 1026,
  kGeographicType = 2048,
  kGeographicCitation = 2049,
  kGeodeticDatum = 2050,
  kPrimeMeridian = 2051,
  kAngularUnits = 2054,
  kAngularUnitSize = 2055,
  kEllipsoid = 2056,
  kSemiMajorAxis = 2057,
  kSemiMinorAxis = 2058,
  kInverseFlattening = 2059,
  kPrimeMeridianLongitude = 2061,
  kProjectedType = 3072,
  kProjectedCitation = 3073,
  kProjection = 3074,
  kCoordinateTransform = 3075,
  kLinearUnits = 3076,
  kLinearUnitSize = 3077,
  kStandardParallel1 = 3078,
  kStandardParallel2 = 3079,
  kNaturalOriginLongitude = 3080,
  kNaturalOriginLatitude = 3081,
  kFalseEasting = 3082,
  kFalseNorthing = 3083,
  kFalseOriginLongitude = 3084,
  kFalseOriginLatitude = 3085,
  kFalseOriginEasting = 3086,
  kFalseOriginNorthing = 3087,
  kCenterLongitude = 3088,
  kCenterLatitude = 3089,
  kCenterEasting = 3090,
  kCenterNorthing = 3091,
  kScaleAtNaturalOrigin = 3092,
  kScaleAtCenter = 3093,
  kAzimuthAngle = 3094,
  kStraightVerticalPoleLongitude = 3095,
  kRectifiedGridAngle = 3096,
  kVertical = 4096,
  kVerticalCitation = 4097,
  kVerticalUnits = 4099,
};

}  // namespace vt::geo
