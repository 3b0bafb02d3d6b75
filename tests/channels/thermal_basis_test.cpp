#include "builder/channels/sensor/thermal_basis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "builder/channels/all_channels.h"
#include "builder/channels/sensor/symmetric_eigen.h"
#include "store/texel/texel_decoder.h"
#include "tests/channels/row_fixture.h"
#include "tests/channels/thermal_fixture.h"

namespace vt::channels {
namespace {

const BandRadiance& long_wave() {
  static const BandRadiance band({{8.0, 1.0}, {12.0, 1.0}});
  return band;
}

ThermalLibrary library() { return parse_thermal_library(test::thermal_library_json(), &long_wave()).value(); }

TEST(SymmetricEigen, VectorsAreOrthonormalAndReproduceTheMatrix) {
  constexpr std::size_t kSize = 12;
  std::mt19937 random(5);
  std::vector<double> root(kSize * kSize), matrix(kSize * kSize, 0.0);
  for (double& value : root) value = static_cast<double>(random() % 2001) / 1000.0 - 1.0;
  for (std::size_t i = 0; i < kSize; ++i)
    for (std::size_t j = 0; j < kSize; ++j)
      for (std::size_t k = 0; k < kSize; ++k) matrix[i * kSize + j] += root[i * kSize + k] * root[j * kSize + k];
  const auto vectors = leading_eigenvectors(matrix, kSize, kSize);
  double before = 1e300;
  for (std::size_t a = 0; a < kSize; ++a) {
    std::vector<double> image(kSize, 0.0);
    for (std::size_t i = 0; i < kSize; ++i)
      for (std::size_t j = 0; j < kSize; ++j) image[i] += matrix[i * kSize + j] * vectors[a][j];
    double value = 0.0;
    for (std::size_t i = 0; i < kSize; ++i) value += image[i] * vectors[a][i];
    EXPECT_LE(value, before) << "the greatest first";
    before = value;
    for (std::size_t i = 0; i < kSize; ++i) EXPECT_NEAR(image[i], value * vectors[a][i], 1e-12);
    for (std::size_t b = 0; b < kSize; ++b) {
      double product = 0.0;
      for (std::size_t i = 0; i < kSize; ++i) product += vectors[a][i] * vectors[b][i];
      EXPECT_NEAR(product, a == b ? 1.0 : 0.0, 1e-13);
    }
  }
}

TEST(ThermalBasis, ACompleteBasisReproducesTheLibrary) {
  const ThermalLibrary all = library();
  const BasisError error = basis_error(all, make_thermal_basis(all, static_cast<int>(all.hours.size()), &long_wave()), &long_wave());
  EXPECT_LT(error.largest, 1e-8);
}

// 64 diurnal materials, hot ones among them; the bounds are those that principal components of radiance
// reached before on such a set.
TEST(ThermalBasis, FewComponentsDescribeADay) {
  const ThermalLibrary all = library();
  ASSERT_EQ(all.classes.size(), 64U);
  constexpr std::array kBounds{1.4, 0.85, 0.18};
  double before = 1e9;
  for (int components = 3; components <= 5; ++components) {
    const BasisError error = basis_error(all, make_thermal_basis(all, components, &long_wave()), &long_wave());
    RecordProperty("rms_mK_of_" + std::to_string(components), static_cast<int>(error.root_mean_square * 1000));
    EXPECT_LT(error.root_mean_square, kBounds[static_cast<std::size_t>(components - 3)]);
    EXPECT_LT(error.root_mean_square, before);
    before = error.root_mean_square;
  }
}

TEST(ThermalBasis, WeighingByKelvinsIsBetterInKelvinsThanRadianceAlone) {
  const ThermalLibrary all = library();
  for (int components = 3; components <= 4; ++components)
    EXPECT_LT(basis_error(all, make_thermal_basis(all, components, &long_wave()), &long_wave()).root_mean_square,
              basis_error(all, make_thermal_basis(all, components, nullptr), &long_wave()).root_mean_square);
}

TEST(ThermalBasis, MixturesAreMixturesOfCoefficients) {
  const ThermalLibrary all = library();
  const ThermalBasis basis = make_thermal_basis(all, 4, &long_wave());
  for (const double hour : {0.0, 5.3, 12.0, 23.9}) {
    std::vector<double> mixed(4, 0.0);
    double radiance = 0.0;
    for (const auto& [m, share] : {std::pair{3, 0.25}, {17, 0.5}, {63, 0.25}}) {
      const std::vector<double>& c = basis.coefficients[static_cast<std::size_t>(m)];
      for (std::size_t k = 0; k < 4; ++k) mixed[k] += share * c[k];
      radiance += share * reconstruct(basis, c, hour);
    }
    EXPECT_NEAR(reconstruct(basis, mixed, hour), radiance, 1e-12);
  }
}

TEST(ThermalBasis, HoursLieBetweenHoursAndDaysFollowOneAnother) {
  const ThermalLibrary all = library();
  const ThermalBasis basis = make_thermal_basis(all, 4, &long_wave());
  const std::vector<double>& c = basis.coefficients[10];
  const auto at = [&](double hour) { return reconstruct(basis, c, hour); };
  EXPECT_NEAR(at(6.5), (at(6.0) + at(7.0)) / 2.0, 1e-12);
  EXPECT_NEAR(at(23.25), 0.75 * at(23.0) + 0.25 * at(0.0), 1e-12);
  EXPECT_NEAR(at(24.0), at(0.0), 1e-12);
  EXPECT_NEAR(at(-1.0), at(23.0), 1e-12);
  ThermalBasis late{.hours = {6.0, 18.0}, .mean = {10.0, 20.0}, .curves = {}, .coefficients = {}};
  EXPECT_NEAR(reconstruct(late, {}, 0.0), 15.0, 1e-12);
  EXPECT_NEAR(reconstruct(late, {}, 3.0), 12.5, 1e-12);
}

TEST(ThermalBasis, RefusesWhatIsNoLibraryAndNamesTheClass) {
  const auto message = [](const std::string& text, const BandRadiance* band = &long_wave()) {
    const auto parsed = parse_thermal_library(text, band);
    return parsed ? std::string("taken") : parsed.error().message;
  };
  const std::string head = R"({"kind": "temperature", "times": [0, 12], "classes": [)";
  EXPECT_EQ(message(head + R"({"id": 1, "curve": [280, 290]}]})"), "taken");
  EXPECT_NE(message(head + R"({"id": 1, "curve": [280, 290]}]})", nullptr).find("`band`"), std::string::npos);
  EXPECT_NE(message(head + R"({"id": 7, "curve": [280]}]})").find("class 7"), std::string::npos);
  EXPECT_NE(message(head + R"({"id": 7, "curve": [280, -1]}]})").find("class 7"), std::string::npos);
  EXPECT_NE(message(head + R"({"id": 7, "curve": [280, "x"]}]})").find("class 7"), std::string::npos);
  EXPECT_NE(message(head + R"({"id": 7, "curve": [280, 290]}, {"id": 7, "curve": [280, 290]}]})").find("twice"), std::string::npos);
  EXPECT_NE(message(head + R"({"curve": [280, 290]}]})").find("\"id\""), std::string::npos);
  EXPECT_NE(message(head + "]}").find("classes"), std::string::npos);
  EXPECT_NE(message(R"({"kind": "temperature", "times": [12, 0], "classes": []})").find("increase"), std::string::npos);
  EXPECT_NE(message(R"({"kind": "colour"})").find("kind"), std::string::npos);
  for (const char* text : {"", "[]", "{", "null", "{\"kind\": 3}"}) EXPECT_NE(message(text), "taken") << text;
}

struct Encoded {
  std::unique_ptr<const ChannelCodec> codec;
  std::vector<std::vector<float>> stored;  // by part, interleaved samples
};

// `codes` of classes, averaged in groups of `group`, encoded.
Encoded encoded(const std::vector<std::uint8_t>& codes, std::size_t group, TexelFormat format, const Options& more = {}) {
  Options options{{"basis", test::thermal_library_json()}, {"band", "8,12"}};
  options.insert(more.begin(), more.end());
  auto codec = make_codec({.channel = ChannelType::kSensor, .format = format, .options = options}, {.value_bands = 1});
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  Encoded result{std::move(*codec), {}};
  const auto count = static_cast<std::int64_t>(codes.size());
  Rows fine(count);
  Rows coarse(count);
  result.codec->decode_row(bytes_of(codes), count, fine.row(1));
  for (int p = 0; p < result.codec->planes(); ++p)
    for (std::size_t i = 0; i < codes.size() / group; ++i) {
      double sum = 0.0;
      for (std::size_t j = 0; j < group; ++j) sum += static_cast<double>(fine.row(1)[static_cast<std::size_t>(p)][i * group + j]);
      coarse.row(1)[static_cast<std::size_t>(p)][i] = static_cast<float>(sum / static_cast<double>(group));
    }
  const std::size_t texels = codes.size() / group;
  for (std::size_t part = 0; part < result.codec->parts().size(); ++part) {
    const FormatInfo& info = format_info(result.codec->parts()[part].texel_format);
    std::vector<std::byte> bytes(texels * info.block_bytes);
    EXPECT_TRUE(result.codec->encode_row(part, coarse.middle(false), static_cast<std::int64_t>(texels), bytes.data()).has_value());
    store::decode_texels(info.format, bytes, texels, 1, result.stored.emplace_back(texels * info.channels));
  }
  return result;
}

// What a stored number of a part is worth.
double value_of(const Encoded& e, std::size_t part, std::size_t texel, std::size_t component) {
  const Part& p = e.codec->parts()[part];
  const std::size_t channels = format_info(p.texel_format).channels;
  const double unblocked = p.format == TexelFormat::kBc4 ? 255.0 / 65535.0 : 1.0;
  return p.ranges[component].offset +
         p.ranges[component].scale * unblocked * static_cast<double>(e.stored[part][texel * channels + component]);
}

TEST(ThermalBasis, TemperaturesAreKelvins) {
  const auto message = [](const std::string& curve) {
    const auto parsed = parse_thermal_library(
        R"({"kind": "temperature", "times": [0, 12], "classes": [{"id": 1, "curve": [280, 290]}, {"id": 7, "curve": )" + curve + "}]}",
        &long_wave());
    return parsed ? std::string("taken") : parsed.error().message;
  };
  for (const char* celsius : {"[12.5, 31]", "[0, 20]", "[-5, 20]", "[280, 99.9]", "[280, 3000.1]"}) {
    EXPECT_NE(message(celsius).find("class 7"), std::string::npos) << celsius;
    EXPECT_NE(message(celsius).find("is it in degrees Celsius?"), std::string::npos) << celsius;
  }
  EXPECT_NE(message("[12.5, 31]").find("12.5 K"), std::string::npos) << "the number that is wrong is named";
  EXPECT_EQ(message("[100, 3000]"), "taken");
}

// In the ultraviolet a cold body is so dark that the kelvins of a radiance, or their square, are no doubles.
TEST(ThermalBasis, RefusesWhatHasNoTemperatureInTheBand) {
  const BandRadiance ultraviolet({{0.2, 1.0}, {0.25, 1.0}});
  const auto parse = [&](const std::string& kind, const std::string& curve, const BandRadiance& band) {
    return parse_thermal_library(R"({"kind": ")" + kind + R"(", "times": [0, 12], "classes": [{"id": 7, "curve": )" + curve + "}]}", &band);
  };
  const auto expect_refused = [](const Result<ThermalLibrary>& parsed, const std::string& what) {
    ASSERT_FALSE(parsed.has_value()) << what;
    EXPECT_EQ(parsed.error().code, ErrorCode::kInvalidData);
    EXPECT_NE(parsed.error().message.find("class 7"), std::string::npos) << parsed.error().message;
  };
  ASSERT_GT(ultraviolet.radiance(110.0), 0.0);
  EXPECT_FALSE(std::isfinite(std::pow(kelvins_per_radiance(&ultraviolet, ultraviolet.radiance(110.0)), 2.0)));
  expect_refused(parse("temperature", "[110, 300]", ultraviolet), "radiance of 1e-220");
  expect_refused(parse("radiance", "[1e-320, 1]", long_wave()), "no temperature");
  expect_refused(parse("radiance", "[1, 1e30]", long_wave()), "hotter than everything");
  expect_refused(parse("radiance", "[1, 0]", long_wave()), "none");

  const auto fits = parse("temperature", "[300, 310]", ultraviolet);
  ASSERT_TRUE(fits.has_value());
  const ThermalBasis basis = make_thermal_basis(*fits, 2, &ultraviolet);
  for (const double value : basis.mean) EXPECT_TRUE(std::isfinite(value));
  for (const auto& curve : basis.curves)
    for (const double value : curve) EXPECT_TRUE(std::isfinite(value));
}

TEST(ThermalCodec, FilteringWhatIsStoredIsStoringWhatWasFiltered) {
  std::vector<std::uint8_t> codes(256);
  std::mt19937 random(9);
  for (std::uint8_t& code : codes) code = static_cast<std::uint8_t>(1 + random() % 64);
  for (const TexelFormat format : {TexelFormat::kRgba16, TexelFormat::kRgba16Float, TexelFormat::kRgba32Float, TexelFormat::kBc4}) {
    const Encoded fine = encoded(codes, 1, format, {{"components", "5"}});
    const Encoded coarse = encoded(codes, 16, format, {{"components", "5"}});
    for (std::size_t part = 0; part < fine.codec->parts().size(); ++part)
      for (std::size_t c = 0; c < fine.codec->parts()[part].components.size(); ++c)
        for (std::size_t texel = 0; texel < 16; ++texel) {
          double mean = 0.0;
          for (std::size_t i = 0; i < 16; ++i) mean += value_of(fine, part, texel * 16 + i, c) / 16;
          // Half a step on either side: coefficients go from -1 to 1 at most, in 65534 steps or with 11 or 24
          // bits.
          const double step = format == TexelFormat::kRgba16Float   ? std::ldexp(1.0, -11)
                              : format == TexelFormat::kRgba32Float ? std::ldexp(1.0, -22)
                                                                    : 2.0 / 65534;
          EXPECT_NEAR(value_of(coarse, part, texel, c), mean, step) << format_info(format).name << " part " << part;
        }
  }
}

TEST(ThermalCodec, AnyHourComesBackFromWhatIsStored) {
  std::vector<std::uint8_t> codes(64);
  for (std::size_t i = 0; i < 64; ++i) codes[i] = static_cast<std::uint8_t>(i + 1);
  const ThermalLibrary all = library();
  const ThermalBasis basis = make_thermal_basis(all, 5, &long_wave());
  const double bound = basis_error(all, basis, &long_wave()).largest + 0.02;
  const Encoded e = encoded(codes, 1, TexelFormat::kRgba16, {{"components", "5"}});
  ASSERT_EQ(e.codec->parts().size(), 2U);
  EXPECT_EQ(e.codec->parts()[1].suffix, "c5");
  EXPECT_EQ(e.codec->parts()[1].format, TexelFormat::kR16);
  for (std::size_t m = 0; m < 64; ++m) {
    std::vector<double> c;
    for (std::size_t k = 0; k < 5; ++k) c.push_back(value_of(e, k / 4, m, k % 4));
    for (std::size_t t = 0; t < all.hours.size(); ++t)
      EXPECT_NEAR(long_wave().temperature(reconstruct(basis, c, all.hours[t])), long_wave().temperature(all.classes[m].radiance[t]), bound);
  }
  // What readers need of it is in the metadata.
  const auto metadata = nlohmann::json::parse(e.codec->parts()[1].metadata_json);
  EXPECT_EQ(metadata.at("basis").at("curves").get<std::vector<std::vector<double>>>(), basis.curves);
  EXPECT_EQ(metadata.at("basis").at("mean").get<std::vector<double>>(), basis.mean);
  EXPECT_EQ(metadata.at("basis").at("error").at("unit"), "K");
}

TEST(ThermalCodec, QuantisationCostsLittleOfAKelvin) {
  std::vector<std::uint8_t> codes(64);
  for (std::size_t i = 0; i < 64; ++i) codes[i] = static_cast<std::uint8_t>(i + 1);
  const Encoded e = encoded(codes, 1, TexelFormat::kRgba16);
  Rows rows(64);
  e.codec->decode_row(bytes_of(codes), 64, rows.row(1));
  std::vector<ErrorSum> errors(e.codec->measures().size());
  e.codec->add_errors(0, rows.middle(true).here, e.stored[0].data(), 64, errors);
  EXPECT_EQ(errors[0].count, 64U);
  EXPECT_GT(errors[0].largest, 0.0);
  EXPECT_LT(errors[0].root_mean_square(), 0.02);
  EXPECT_NEAR(errors[0].stored_total / errors[0].reference_total, 1.0, 1e-4);
}

// Temperatures of what is stored and of what should be, hour by hour, by the band's own function: also where
// the error is so large that no slope stands for it, and for classes far from the library's mean.
TEST(ThermalCodec, ReportedKelvinsAreDifferencesOfTemperatures) {
  std::vector<std::uint8_t> codes(64);
  for (std::size_t i = 0; i < 64; ++i) codes[i] = static_cast<std::uint8_t>(i + 1);
  for (const double off : {1e-4, 0.02, 0.3}) {
    const Encoded e = encoded(codes, 1, TexelFormat::kRgba32Float);
    const ThermalBasis basis = make_thermal_basis(library(), 4, &long_wave());
    Rows rows(64);
    e.codec->decode_row(bytes_of(codes), 64, rows.row(1));
    std::vector<float> stored = e.stored[0];
    for (std::size_t i = 0; i < 64; ++i) stored[i * 4] += static_cast<float>(i % 2 == 0 ? off : -off);
    ErrorSum wanted;
    for (std::size_t i = 0; i < 64; ++i) {
      double squares = 0.0;
      for (std::size_t t = 0; t < basis.hours.size(); ++t) {
        double is = basis.mean[t];
        double should_be = basis.mean[t];
        for (std::size_t k = 0; k < 4; ++k) {
          is += basis.curves[k][t] * static_cast<double>(stored[i * 4 + k]);
          should_be += basis.curves[k][t] * static_cast<double>(rows.row(1)[k][static_cast<std::int64_t>(i)]);
        }
        // As the codec says: what has no temperature counts as a millionth of what should be.
        const double error = long_wave().temperature(std::max(is, 1e-6 * should_be)) - long_wave().temperature(should_be);
        squares += error * error;
      }
      wanted.add(std::sqrt(squares / static_cast<double>(basis.hours.size())));
    }
    std::vector<ErrorSum> errors(e.codec->measures().size());
    e.codec->add_errors(0, rows.middle(true).here, stored.data(), 64, errors);
    // Linear between 1024 places an octave of radiance: differences within one are right to 0.1 %.
    EXPECT_NEAR(errors[0].mean(), wanted.mean(), 1e-3 * wanted.mean()) << off;
    EXPECT_NEAR(errors[0].largest, wanted.largest, 1e-3 * wanted.largest) << off;
  }
}

TEST(ThermalCodec, UnknownClassesAreNoDataAndCoverageIsKept) {
  const std::vector<std::uint8_t> codes{1, 200, 0, 0};
  const Encoded e = encoded(codes, 2, TexelFormat::kRgba16Float, {{"components", "3"}});
  EXPECT_EQ(e.codec->parts()[0].components, (std::vector<std::string>{"c1", "c2", "c3", "coverage"}));
  const ThermalBasis basis = make_thermal_basis(library(), 3, &long_wave());
  EXPECT_NEAR(e.stored[0][0], basis.coefficients[0][0], 1e-3) << "only the known one counts";
  EXPECT_EQ(e.stored[0][3], 0.5F);
  EXPECT_TRUE(std::isnan(e.stored[0][4]));
  EXPECT_EQ(e.stored[0][7], 0.0F);
}

TEST(ThermalCodec, RefusesWhatDoesNotFit) {
  const auto message = [](TexelFormat format, Options options) {
    options.emplace("basis", test::thermal_library_json());
    const auto codec = make_codec({.channel = ChannelType::kSensor, .format = format, .options = options}, {.value_bands = 1});
    return codec ? std::string("made") : codec.error().message;
  };
  EXPECT_NE(message(TexelFormat::kRgb8, {{"band", "8,12"}}).find("use rgba16,"), std::string::npos);
  EXPECT_NE(message(TexelFormat::kRgba16, {}).find("`band`"), std::string::npos);
  EXPECT_NE(message(TexelFormat::kRgba16, {{"band", "8,12"}, {"components", "6"}}).find("components"), std::string::npos);
  EXPECT_NE(message(TexelFormat::kRgba16, {{"band", "8,12"}, {"components", "3.5"}}).find("not whole"), std::string::npos);
  EXPECT_NE(message(TexelFormat::kRgba16, {{"band", "8,12"}, {"quantity", "temperature"}}).find("no meaning"), std::string::npos);
  const auto alone =
      make_codec({.channel = ChannelType::kSensor, .format = TexelFormat::kR32Float, .options = {{"components", "3"}}}, {.value_bands = 1});
  EXPECT_NE(alone.error().message.find("`basis`"), std::string::npos);
}

}  // namespace
}  // namespace vt::channels
