#include "builder/channels/samples/nodata.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vt::channels {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Row {
  SampleType type;
  double declared;
  std::vector<double> are_nodata;
  std::vector<double> are_data;
};

// Every row is what GDAL 3.6.2's mask band says of a file with these samples and this text, but for two: GDAL
// takes any float beyond about 1e32 for -3.4e38 (its sum of the two overflows), and of samples of 64 bits it
// wants seven digits of the largest float.
TEST(Nodata, SamplesThatEqualADeclaredValueAreGdals) {
  constexpr double kLowestFloat = std::numeric_limits<float>::lowest();
  constexpr double kLowestDouble = std::numeric_limits<double>::lowest();
  const auto f = [](double value) { return static_cast<double>(static_cast<float>(value)); };
  const std::vector<Row> rows = {
      {SampleType::kInt16, -9999.6, {-9999}, {-10000, -9998, 0}},
      {SampleType::kInt16, -9999.4, {-9999}, {-10000, -9998, 0}},
      {SampleType::kInt16, -0.5, {0}, {-1, 1}},
      {SampleType::kUint8, -9999, {}, {0, 255, 241}},
      {SampleType::kUint8, 255, {255}, {0, 254}},
      {SampleType::kUint8, 255.4, {}, {0, 254, 255}},
      {SampleType::kUint16, -9999, {}, {0, 65535, 55537}},
      {SampleType::kUint16, 1e10, {}, {0, 65535}},
      {SampleType::kInt32, -2147483648.0, {-2147483648.0}, {2147483647, 0}},
      {SampleType::kInt32, -3.4e38, {}, {-2147483648.0, 2147483647, 0}},
      {SampleType::kUint32, 4294967295.0, {4294967295.0}, {4294967294.0, 0}},
      {SampleType::kFloat32, -9999, {-9999, f(-9999.001), f(-9999.003)}, {f(-9999.006), -9998.99, 9999}},
      {SampleType::kFloat32, -9999.9, {f(-9999.9)}, {f(-9999.91), f(-9999.8)}},
      {SampleType::kFloat32, 0.0, {0.0, -0.0}, {1e-45, 1e-38, -1e-30}},
      {SampleType::kFloat32, 0.1, {f(0.1)}, {f(0.100001), f(0.0999)}},
      {SampleType::kFloat64, -9999.9, {-9999.9, f(-9999.9), -9999.901}, {-9999.91}},
      {SampleType::kFloat32, -3.4e38, {kLowestFloat, f(-3.4e38), f(-2e38)}, {f(-1e30), -11034, 3e38}},
      {SampleType::kFloat32, -3.40282e38, {kLowestFloat, f(-3.4028233e38)}, {f(-1e30), 8848}},
      {SampleType::kFloat32, -3.402823e38, {kLowestFloat}, {f(-1e30), 8848}},
      {SampleType::kFloat32, -3.4028235e38, {kLowestFloat}, {f(-1e30), 8848}},
      {SampleType::kFloat32, -3.40282347e38, {kLowestFloat}, {f(-1e30), 8848}},
      {SampleType::kFloat32, 3.40282e38, {-kLowestFloat}, {kLowestFloat, 8848}},
      {SampleType::kFloat64, -3.40282347e38, {kLowestFloat, -3.40282347e38}, {-1e37, -1.79e308}},
      {SampleType::kFloat64, -3.40282e38, {kLowestFloat, -3.40282e38}, {-1e37, 0}},
      {SampleType::kFloat64, -1.79769e308, {kLowestDouble, -1.79e308}, {kLowestFloat, -1e300}},
      // A raster of doubles that was cut down to floats still says -1.8e308.
      {SampleType::kFloat32, -1.79769e308, {kLowestFloat}, {f(-1e30), 8848}},
      {SampleType::kFloat32, kNaN, {}, {0, kLowestFloat}},
      {SampleType::kFloat32, kInf, {}, {-kLowestFloat, 0}},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(std::string(sample_name(row.type)) + ", declared " + std::to_string(row.declared));
    const NodataRange range = nodata_range(row.type, row.declared);
    for (const double sample : row.are_nodata) EXPECT_TRUE(range.contains(sample)) << sample;
    for (const double sample : row.are_data) EXPECT_FALSE(range.contains(sample)) << sample;
    if (row.type != SampleType::kFloat32) continue;
    const auto floats = typed_nodata_range<float>(row.type, row.declared);
    for (const double sample : row.are_nodata) EXPECT_TRUE(floats.contains(static_cast<float>(sample))) << sample;
    for (const double sample : row.are_data) EXPECT_FALSE(floats.contains(static_cast<float>(sample))) << sample;
  }
}

// The reach of a float's no-data value, by the definition in which GDAL states it.
TEST(Nodata, FloatsMatchAsFarAsTheDefinitionSays) {
  constexpr double kEpsilon = std::numeric_limits<float>::epsilon();
  for (const double declared : {-9999.0, -32768.0, 0.1, 1e-6, 12345.678, 1e20}) {
    const NodataRange range = nodata_range(SampleType::kFloat64, declared);
    const double centre = declared;
    for (int step = -200; step <= 200; ++step) {
      const double sample = centre * (1.0 + step * 5e-9);
      const double distance = std::abs(sample - centre);
      const double reach = 2.0 * kEpsilon * std::abs(sample + centre);
      if (std::abs(distance - reach) < 1e-12 * std::abs(centre)) continue;  // the boundary itself is a matter of rounding
      EXPECT_EQ(range.contains(sample), distance < reach) << declared << " and " << sample;
    }
  }
}

}  // namespace
}  // namespace vt::channels
