#include "builder/channels/sensor/planck.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "builder/channels/sensor/spectral_response.h"

namespace vt::channels {
namespace {

// The integral of Planck's law from 0 to a wavelength in closed form, a series in exp(-x) (Widger and
// Woodall, Bulletin of the American Meteorological Society 57, 1976): 2 k^4 T^4 / (h^3 c^2) * sum over n of
// exp(-n x) (x^3/n + 3 x^2/n^2 + 6 x/n^3 + 6/n^4).
long double radiance_below(long double wavelength_um, long double kelvin) {
  const long double h = 6.62607015e-34L, c = 299792458.0L, k = 1.380649e-23L;
  const long double x = h * c / (k * kelvin * wavelength_um * 1e-6L);
  long double sum = 0.0L;
  for (int n = 1; n < 100000; ++n) {
    const long double m = n;
    const long double term = std::exp(-m * x) * (x * x * x / m + 3 * x * x / (m * m) + 6 * x / (m * m * m) + 6 / (m * m * m * m));
    sum += term;
    if (term < sum * 1e-19L) break;
  }
  return 2 * k * k * k * k * kelvin * kelvin * kelvin * kelvin / (h * h * h * c * c) * sum;
}

double radiance_in(double low_um, double high_um, double kelvin) {
  return static_cast<double>(radiance_below(high_um, kelvin) - radiance_below(low_um, kelvin));
}

std::vector<ResponsePoint> top_hat(double low_um, double high_um) { return {{low_um, 1.0}, {high_um, 1.0}}; }

constexpr std::array<std::array<double, 2>, 4> kBands{{{3.0, 5.0}, {8.0, 12.0}, {10.6, 11.19}, {1.0, 2.5}}};

TEST(Planck, ASpectralRadianceFromTheTables) {
  // 2 h c^2 / lambda^5 / (exp(h c / (lambda k T)) - 1), in long double.
  for (const double wavelength : {0.5, 4.0, 10.0, 100.0})
    for (const double kelvin : {180.0, 300.0, 1500.0, 5800.0}) {
      const long double l = wavelength * 1e-6L;
      const long double truth = 2 * 6.62607015e-34L * 299792458.0L * 299792458.0L / (l * l * l * l * l) /
                                std::expm1(6.62607015e-34L * 299792458.0L / (l * 1.380649e-23L * kelvin)) * 1e-6L;
      // Rounding of exponents of up to 160.
      EXPECT_NEAR(planck_radiance(wavelength, kelvin) / static_cast<double>(truth), 1.0, 1e-13) << wavelength << " um, " << kelvin << " K";
    }
}

TEST(Planck, AllWavelengthsTogetherFollowStefanAndBoltzmann) {
  const BandRadiance all(top_hat(0.2, 1000.0));
  for (const double kelvin : {180.0, 300.0, 800.0, 1500.0}) {
    const double total = 5.670374419e-8 * std::pow(kelvin, 4) / std::acos(-1.0);
    // Beyond 1 mm: the law of Rayleigh and Jeans with the first terms of x / (exp(x) - 1) = 1 - x/2 + x^2/12,
    // x = 14388 um K / (lambda T); what is left out is x^4 / 720 of it. Below 0.2 um is nothing at these
    // temperatures.
    const double x = 14387.768775 / (1000.0 * kelvin);
    const double beyond = 2.0 * 299792458.0 * 1.380649e-23 * kelvin * 1e9 * (1.0 / 3.0 - x / 8.0 + x * x / 60.0);
    EXPECT_NEAR((all.integrate(kelvin) + beyond) / total, 1.0, 2e-9) << kelvin << " K";
  }
}

TEST(Planck, IntegralsOfBandsEqualTheClosedForm) {
  for (const auto& [low, high] : kBands) {
    const BandRadiance band(top_hat(low, high));
    for (double kelvin = 180.0; kelvin <= 1500.0; kelvin += 13.7)
      EXPECT_NEAR(band.integrate(kelvin) / radiance_in(low, high, kelvin), 1.0, 1e-9) << low << " um, " << kelvin << " K";
  }
}

TEST(Planck, TheTableIsOffByLessThanATenthOfAMillikelvin) {
  for (const auto& [low, high] : kBands) {
    const BandRadiance band(top_hat(low, high));
    for (double kelvin = 180.25; kelvin <= 1500.0; kelvin += 7.61) {
      const double slope = (band.integrate(kelvin + 0.01) - band.integrate(kelvin - 0.01)) / 0.02;
      EXPECT_LT(std::abs(band.radiance(kelvin) - band.integrate(kelvin)) / slope, 1e-4) << low << " um, " << kelvin << " K";
    }
  }
}

TEST(Planck, TemperaturesComeBackFromRadianceInsideAndOutsideTheTable) {
  for (const auto& [low, high] : kBands) {
    const BandRadiance band(top_hat(low, high));
    for (double kelvin = 180.0; kelvin <= 1500.0; kelvin += 0.37)
      ASSERT_NEAR(band.temperature(band.radiance(kelvin)), kelvin, 1e-6) << low << " um";
    for (const double kelvin : {60.0, 99.5, 100.0, 2999.5, 3000.0, 5772.0, 20000.0})
      EXPECT_NEAR(band.temperature(band.radiance(kelvin)), kelvin, 1e-6 * kelvin) << low << " um";
    // Radiance in a float, as layers carry it.
    for (double kelvin = 180.0; kelvin <= 1500.0; kelvin += 11.3)
      EXPECT_NEAR(band.temperature(static_cast<float>(band.radiance(kelvin))), kelvin, 1e-3);
  }
}

TEST(Planck, RadianceGrowsWithTemperatureAcrossTheTablesEnds) {
  const BandRadiance band(top_hat(8.0, 12.0));
  for (const double kelvin : {100.0, 101.0, 1000.0, 3000.0}) EXPECT_LT(band.radiance(kelvin - 1e-4), band.radiance(kelvin + 1e-4));
}

TEST(Planck, WhatIsNoTemperatureAndWhatIsNoRadianceIsNaN) {
  const BandRadiance band(top_hat(3.0, 5.0));
  const double inf = std::numeric_limits<double>::infinity();
  for (const double value : {0.0, -1.0, -inf, std::nan("")}) {
    EXPECT_TRUE(std::isnan(band.radiance(value))) << value;
    EXPECT_TRUE(std::isnan(band.temperature(value))) << value;
  }
  EXPECT_TRUE(std::isnan(band.temperature(1e30))) << "hotter than 10^7 K";
  EXPECT_GT(band.temperature(1e-300), 0.0);
  EXPECT_GT(band.temperature(std::numeric_limits<double>::denorm_min()), 0.0);
}

// The mean of radiances is not the radiance of the mean temperature: mixtures whose error is known to the
// digits given.
TEST(Planck, MixturesAreWarmerThanTheirMeanTemperature) {
  struct Row {
    double share, first, second;
    double kelvin_medium, percent_medium, kelvin_long, percent_long;
  };
  constexpr std::array<Row, 5> kRows{{{0.5, 290, 310, 1.47, -5.2, 0.50, -0.8},
                                      {0.5, 280, 320, 5.6, -18.1, 2.0, -3.2},
                                      {0.5, 260, 330, 15.5, -42.6, 6.2, -9.7},
                                      {0.25, 350, 290, 10.6, -30, 3.2, -4.9},
                                      {0.01, 800, 300, 90, -92, 9.3, -13}}};
  const BandRadiance medium(top_hat(3.0, 5.0));
  const BandRadiance longer(top_hat(8.0, 12.0));
  for (const Row& row : kRows) {
    const double mean_kelvin = row.share * row.first + (1.0 - row.share) * row.second;
    const auto check = [&](const BandRadiance& band, double kelvin, double percent) {
      const double mean = row.share * band.radiance(row.first) + (1.0 - row.share) * band.radiance(row.second);
      // Half a unit of the last digit that is given.
      const auto digit = [](double number) {
        return number * 10 != std::round(number * 10) ? 0.005 : number != std::round(number) ? 0.05 : 0.5;
      };
      EXPECT_NEAR(band.temperature(mean) - mean_kelvin, kelvin, digit(kelvin)) << row.first;
      EXPECT_NEAR(100.0 * (band.radiance(mean_kelvin) / mean - 1.0), percent, digit(percent)) << row.first;
    };
    check(medium, row.kelvin_medium, row.percent_medium);
    check(longer, row.kelvin_long, row.percent_long);
  }
}

TEST(SpectralResponse, ATriangleWeighsItsBand) {
  const auto points = parse_response("# a filter\nwavelength,response\n8,0\n10,1\n12,0\n");
  ASSERT_TRUE(points.has_value()) << points.error().message;
  const BandRadiance band(*points);
  // Simpson's rule on 2000 panels.
  double sum = 0.0;
  for (int i = 0; i <= 4000; ++i) {
    const double wavelength = 8.0 + i / 1000.0;
    sum += (i % 4000 == 0 ? 1 : i % 2 == 0 ? 2 : 4) * planck_radiance(wavelength, 300.0) * (1.0 - std::abs(wavelength - 10.0) / 2.0);
  }
  EXPECT_NEAR(band.integrate(300.0) / (sum / 3000.0), 1.0, 1e-9);
}

TEST(SpectralResponse, JsonAndLinesSayTheSame) {
  const auto lines = parse_response("3.5;0.1\r\n4.0;0.9\r\n4.5 0.2\n");
  const auto json = parse_response(R"({"wavelength_um": [3.5, 4.0, 4.5], "response": [0.1, 0.9, 0.2]})");
  ASSERT_TRUE(lines.has_value()) << lines.error().message;
  ASSERT_TRUE(json.has_value()) << json.error().message;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ((*lines)[i].wavelength_um, (*json)[i].wavelength_um);
    EXPECT_EQ((*lines)[i].response, (*json)[i].response);
  }
}

TEST(SpectralResponse, ABandCutsTheTable) {
  const auto points = response_of({{"response", "8,0\n10,1\n12,0\n"}, {"band", "9,11"}});
  ASSERT_TRUE(points.has_value());
  ASSERT_EQ(points->size(), 3U);
  EXPECT_EQ((*points)[0].wavelength_um, 9.0);
  EXPECT_EQ((*points)[0].response, 0.5);
  EXPECT_EQ((*points)[2].response, 0.5);
}

TEST(SpectralResponse, RefusesWhatIsNoResponseAndSaysWhere) {
  const auto message = [](const char* text) {
    const auto points = parse_response(text);
    return points ? std::string("taken") : points.error().message;
  };
  EXPECT_NE(message("").find("0 points"), std::string::npos);
  EXPECT_NE(message("8,1\n").find("1 points"), std::string::npos);
  EXPECT_NE(message("8,1\nnine,1\n").find("line 2"), std::string::npos);
  EXPECT_NE(message("8,1\n7,1\n").find("not above"), std::string::npos);
  EXPECT_NE(message("8000,1\n12000,1\n").find("nanometres"), std::string::npos);
  EXPECT_NE(message("8,1\n12,-1\n").find("response is -1"), std::string::npos);
  EXPECT_NE(message("8,nan\n12,1\n").find("response is nan"), std::string::npos);
  EXPECT_NE(message("8,0\n12,0\n").find("0 everywhere"), std::string::npos);
  EXPECT_NE(message("{\"wavelength_um\": [8, 9]}").find("arrays"), std::string::npos);
  for (const char* band : {"8", "12,8", "8,8", "0,4", "8,12,14", "8,nan"}) EXPECT_FALSE(response_of({{"band", band}}).has_value()) << band;
}

}  // namespace
}  // namespace vt::channels
