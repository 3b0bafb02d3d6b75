// A library of 64 materials over one day, as a file would give it: means from 278 to 302 K, swings from 1 to
// 24 K with a sharper noon, the warmest hour between 12 and 16; four of them burn at 330 to 420 K all day.
// Class ids are 1 to 64.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace vt::test {

inline std::string thermal_library_json() {
  nlohmann::json library{{"kind", "temperature"}};
  for (int hour = 0; hour < 24; ++hour) library["times"].push_back(hour);
  for (int m = 0; m < 64; ++m) {
    nlohmann::json one{{"id", m + 1}};
    // Four digits that walk through their ranges at incommensurate speeds.
    const auto part = [&](double speed) { return std::fmod(m * speed, 1.0); };
    for (int hour = 0; hour < 24; ++hour) {
      const double day = std::acos(-1.0) / 12.0 * (hour - 12.0 - 4.0 * part(0.618));
      const double swing = 1.0 + 23.0 * part(0.414);
      const double shape = std::cos(day) + (0.1 + 0.2 * part(0.732)) * std::cos(2.0 * day);
      one["curve"].push_back(m >= 60 ? 330.0 + 30.0 * (m - 60) : 278.0 + 24.0 * part(0.236) + swing * shape);
    }
    library["classes"].push_back(one);
  }
  return library.dump();
}

}  // namespace vt::test
