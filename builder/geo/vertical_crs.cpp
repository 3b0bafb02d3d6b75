#include "builder/geo/vertical_crs.h"

#include <algorithm>
#include <array>

namespace vt::geo {
namespace {

constexpr double kFoot = 0.3048;
constexpr double kUsSurveyFoot = 1200.0 / 3937.0;
constexpr double kBritishFoot1936 = 0.3048007491;

struct Row {
  int code;
  double metres_per_unit;
  bool counts_down;
};

// All vertical systems of the EPSG registry (as of PROJ 9.1.1) that are not heights in metres.
constexpr std::array kOthers = std::to_array<Row>({
    {5336, 1.0, true},
    {5612, 1.0, true},
    {5614, kFoot, true},
    {5702, kUsSurveyFoot, false},
    {5706, 1.0, true},
    {5715, 1.0, true},
    {5734, 1.0, true},
    {5739, 1.0, true},
    {5754, kBritishFoot1936, false},
    {5789, 1.0, true},
    {5831, 1.0, true},
    {5861, 1.0, true},
    {5862, 1.0, true},
    {5863, 1.0, true},
    {5864, 1.0, true},
    {5865, 1.0, true},
    {5866, 1.0, true},
    {5867, 1.0, true},
    {5873, 1.0, true},
    {6130, kFoot, false},
    {6131, kFoot, false},
    {6132, kFoot, false},
    {6357, 1.0, true},
    {6358, kUsSurveyFoot, true},
    {6359, kUsSurveyFoot, true},
    {6360, kUsSurveyFoot, false},
    {7976, 1.0, true},
    {8050, kFoot, false},
    {8051, kFoot, true},
    {8052, kUsSurveyFoot, false},
    {8053, kUsSurveyFoot, true},
    {8228, kFoot, false},
    {8358, 1.0, true},
    {8378, 1.0, true},
    {8897, kFoot, true},
    {9287, 1.0, true},
    {9288, 1.0, true},
    {9672, 1.0, true},
});

}  // namespace

VerticalMeaning vertical_from_epsg(int code) {
  VerticalMeaning meaning{.name = "EPSG:" + std::to_string(code), .metres_per_unit = 1.0};
  const auto* const row = std::ranges::find(kOthers, code, &Row::code);
  if (row == kOthers.end()) return meaning;
  meaning.metres_per_unit = row->metres_per_unit;
  meaning.counts_down = row->counts_down;
  return meaning;
}

}  // namespace vt::geo
