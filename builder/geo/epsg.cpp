#include "builder/geo/epsg.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

namespace vt::geo {
namespace {

struct EllipsoidRow {
  int code;
  const char* name;
  double semi_major_m;
  double inverse_flattening;  // 0: from the semi-minor axis
  double semi_minor_m = 0.0;
};

// EPSG registry, table of ellipsoids. Those that it defines by both axes are kept by both axes.
constexpr EllipsoidRow kEllipsoids[] = {
    {7030, "WGS 84", 6378137.0, 298.257223563},
    {7019, "GRS 1980", 6378137.0, 298.257222101},
    {7043, "WGS 72", 6378135.0, 298.26},
    {7008, "Clarke 1866", 6378206.4, 0.0, 6356583.8},
    {7011, "Clarke 1880 (IGN)", 6378249.2, 0.0, 6356515.0},
    {7012, "Clarke 1880 (RGS)", 6378249.145, 293.465},
    {7013, "Clarke 1880 (Arc)", 6378249.145, 293.4663077},
    {7004, "Bessel 1841", 6377397.155, 299.1528128},
    {7022, "International 1924", 6378388.0, 297.0},
    {7024, "Krassowsky 1940", 6378245.0, 298.3},
    {7001, "Airy 1830", 6377563.396, 299.3249646},
    {7002, "Airy Modified 1849", 6377340.189, 299.3249646},
    {7003, "Australian National Spheroid", 6378160.0, 298.25},
    {7036, "GRS 1967", 6378160.0, 298.247167427},
    {7050, "GRS 1967 Modified", 6378160.0, 298.25},
    {7015, "Everest 1830 (1937 Adjustment)", 6377276.345, 300.8017},
    {1024, "CGCS2000", 6378137.0, 298.257222101},
};

struct GeographicRow {
  int code;
  int datum_code;
  int ellipsoid_code;
  const char* name;  // Greenwich and degrees for all of them
};

constexpr GeographicRow kGeographic[] = {
    {4326, 6326, 7030, "WGS 84"},
    {4979, 6326, 7030, "WGS 84"},  // with ellipsoidal heights; the horizontal part is all that counts here
    {4322, 6322, 7043, "WGS 72"},
    {4269, 6269, 7019, "NAD83"},
    {4267, 6267, 7008, "NAD27"},
    {4152, 6152, 7019, "NAD83(HARN)"},
    {4759, 6759, 7019, "NAD83(NSRS2007)"},
    {6318, 1116, 7019, "NAD83(2011)"},
    {4617, 6140, 7019, "NAD83(CSRS)"},
    {4258, 6258, 7019, "ETRS89"},
    {4230, 6230, 7022, "ED50"},
    {4674, 6674, 7019, "SIRGAS 2000"},
    {4170, 6170, 7019, "SIRGAS 1995"},
    {4618, 6618, 7050, "SAD69"},
    {4248, 6248, 7022, "PSAD56"},
    {4283, 6283, 7019, "GDA94"},
    {7844, 1168, 7019, "GDA2020"},
    {4202, 6202, 7003, "AGD66"},
    {4203, 6203, 7003, "AGD84"},
    {4167, 6167, 7019, "NZGD2000"},
    {4272, 6272, 7022, "NZGD49"},
    {4148, 6148, 7030, "Hartebeesthoek94"},
    {4222, 6222, 7013, "Cape"},
    {4209, 6209, 7013, "Arc 1950"},
    {4210, 6210, 7012, "Arc 1960"},
    {4612, 6612, 7019, "JGD2000"},
    {6668, 1128, 7019, "JGD2011"},
    {4301, 6301, 7004, "Tokyo"},
    {4490, 1043, 1024, "China Geodetic Coordinate System 2000"},
    {4214, 6214, 7024, "Beijing 1954"},
    {4284, 6284, 7024, "Pulkovo 1942"},
    {4277, 6277, 7001, "OSGB36"},
    {4173, 6173, 7019, "IRENET95"},
    {4299, 6299, 7002, "TM65"},
    {4314, 6314, 7004, "DHDN"},
    {4312, 6312, 7004, "MGI"},
    {4124, 6124, 7004, "RT90"},
    {4619, 6619, 7019, "SWEREF99"},
    {4171, 6171, 7019, "RGF93 v1"},
    {4275, 6275, 7011, "NTF"},
    {4289, 6289, 7004, "Amersfoort"},
    {4265, 6265, 7022, "Monte Mario"},
    {4218, 6218, 7022, "Bogota 1975"},
    {4211, 6211, 7004, "Batavia"},
    {4686, 6686, 7019, "MAGNA-SIRGAS"},
    {4141, 6141, 7019, "Israel 1993"},
    {4240, 6240, 7015, "Indian 1975"},
    {4737, 6737, 7019, "Korea 2000"},
    {4159, 6159, 7022, "ELD79"},
};

constexpr double kFootM = 0.3048;
constexpr double kUsFootM = 1200.0 / 3937.0;

constexpr double dms(int degrees, int minutes, double seconds = 0.0) { return degrees + minutes / 60.0 + seconds / 3600.0; }

struct GridRow {
  int code;
  int geographic_code;
  const char* name;
  double latitude_of_origin_deg;
  double central_meridian_deg;
  double scale_factor;
  double false_easting;  // in the grid's unit
  double false_northing;
  double metres_per_unit = 1.0;
};

// Transverse Mercator grids outside the families that have formulas below.
constexpr GridRow kGrids[] = {
    {2193, 4167, "NZGD2000 / New Zealand Transverse Mercator 2000", 0.0, 173.0, 0.9996, 1600000.0, 10000000.0},
    {27700, 4277, "OSGB36 / British National Grid", 49.0, -2.0, 0.9996012717, 400000.0, -100000.0},
    {2157, 4173, "IRENET95 / Irish Transverse Mercator", 53.5, -8.0, 0.99982, 600000.0, 750000.0},
    {29902, 4299, "TM65 / Irish Grid", 53.5, -8.0, 1.000035, 200000.0, 250000.0},
    {3006, 4619, "SWEREF99 TM", 0.0, 15.0, 0.9996, 500000.0, 0.0},
    {3021, 4124, "RT90 2.5 gon V", 0.0, dms(15, 48, 29.8), 1.0, 1500000.0, 0.0},
    {3003, 4265, "Monte Mario / Italy zone 1", 0.0, 9.0, 0.9996, 1500000.0, 0.0},
    {3004, 4265, "Monte Mario / Italy zone 2", 0.0, 15.0, 0.9996, 2520000.0, 0.0},
    {2039, 4141, "Israel 1993 / Israeli TM Grid", dms(31, 44, 3.817), dms(35, 12, 16.261), 1.0000067, 219529.584, 626907.39},
    {21891, 4218, "Bogota 1975 / Colombia West zone", dms(4, 35, 56.57), -dms(77, 4, 51.3), 1.0, 1000000.0, 1000000.0},
    {21892, 4218, "Bogota 1975 / Colombia Bogota zone", dms(4, 35, 56.57), -dms(74, 4, 51.3), 1.0, 1000000.0, 1000000.0},
    {21897, 4218, "Bogota 1975 / Colombia Bogota zone", dms(4, 35, 56.57), -dms(74, 4, 51.3), 1.0, 1000000.0, 1000000.0},
    {26729, 4267, "NAD27 / Alabama East", 30.5, -dms(85, 50), 0.99996, 500000.0, 0.0, kUsFootM},
    {26730, 4267, "NAD27 / Alabama West", 30.0, -87.5, 0.999933333, 500000.0, 0.0, kUsFootM},
    {26771, 4267, "NAD27 / Illinois East", dms(36, 40), -dms(88, 20), 0.999975, 500000.0, 0.0, kUsFootM},
    {26772, 4267, "NAD27 / Illinois West", dms(36, 40), -dms(90, 10), 0.999941177, 500000.0, 0.0, kUsFootM},
    {26966, 4269, "NAD83 / Georgia East", 30.0, -dms(82, 10), 0.9999, 200000.0, 0.0},
    {26967, 4269, "NAD83 / Georgia West", 30.0, -dms(84, 10), 0.9999, 700000.0, 0.0},
    {26971, 4269, "NAD83 / Illinois East", dms(36, 40), -dms(88, 20), 0.999975, 300000.0, 0.0},
    {26972, 4269, "NAD83 / Illinois West", dms(36, 40), -dms(90, 10), 0.999941177, 700000.0, 0.0},
    {32145, 4269, "NAD83 / Vermont", 42.5, -72.5, 0.999964286, 500000.0, 0.0},
    {5179, 4737, "Korea 2000 / Unified CS", 38.0, 127.5, 0.9996, 1000000.0, 2000000.0},
};

struct MercatorRow {
  int code;
  int geographic_code;
  const char* name;
  Mercator projection;
};
constexpr MercatorRow kMercatorGrids[] = {
    {3395, 4326, "WGS 84 / World Mercator", {}},
    {3832, 4326, "WGS 84 / PDC Mercator", {.central_meridian_deg = 150.0}},
    {3994, 4326, "WGS 84 / Mercator 41", {.central_meridian_deg = 100.0, .standard_parallel_deg = -41.0}},
    {3388, 4284, "Pulkovo 1942 / Caspian Sea Mercator", {.central_meridian_deg = 51.0, .standard_parallel_deg = 42.0}},
    {5641,
     4674,
     "SIRGAS 2000 / Brazil Mercator",
     {.central_meridian_deg = -43.0, .standard_parallel_deg = -2.0, .false_easting_m = 5000000.0, .false_northing_m = 10000000.0}},
    {3001,
     4211,
     "Batavia / NEIEZ",
     {.central_meridian_deg = 110.0, .scale_factor = 0.997, .false_easting_m = 3900000.0, .false_northing_m = 900000.0}},
};

// UTM families and their national twins: code = first + (zone - first_zone); some run over zone 60 into zone
// 1.
struct UtmRow {
  int first_code;
  int last_code;
  int first_zone;
  bool south;
  int geographic_code;
  const char* grid = "UTM";  // Australia calls the same projection AMG and MGA
};
constexpr UtmRow kUtm[] = {
    {32601, 32660, 1, false, 4326},      {32701, 32760, 1, true, 4326},         {32201, 32260, 1, false, 4322},
    {32301, 32360, 1, true, 4322},       {26901, 26923, 1, false, 4269},        {26701, 26722, 1, false, 4267},
    {3740, 3749, 10, false, 4152},       {3706, 3726, 59, false, 4759},         {6328, 6348, 59, false, 6318},
    {2955, 2957, 11, false, 4617},       {2958, 2962, 17, false, 4617},         {3154, 3157, 7, false, 4617},
    {25828, 25838, 28, false, 4258},     {23028, 23038, 28, false, 4230},       {31965, 31976, 11, false, 4674},
    {31977, 31985, 17, true, 4674},      {29168, 29172, 18, false, 4618},       {29187, 29195, 17, true, 4618},
    {24817, 24821, 17, false, 4248},     {24877, 24880, 17, true, 4248},        {28348, 28358, 48, true, 4283, "MGA"},
    {7846, 7859, 46, true, 7844, "MGA"}, {20248, 20258, 48, true, 4202, "AMG"}, {20348, 20358, 48, true, 4203, "AMG"},
    {3097, 3101, 51, false, 4612},       {6688, 6692, 51, false, 6668},
};

// Gauss-Krueger families with a zone number before the easting: every zone of `degrees` width, scale 1.
struct GaussKruegerRow {
  int first_code;
  int last_code;
  int first_zone;
  int zone_degrees;
  int zone_offset_deg;  // central meridian = zone * degrees + offset
  int geographic_code;
  const char* name;
};
constexpr GaussKruegerRow kGaussKrueger[] = {
    {31466, 31469, 2, 3, 0, 4314, "DHDN / 3-degree Gauss-Kruger zone"},
    {28404, 28432, 4, 6, -3, 4284, "Pulkovo 1942 / Gauss-Kruger zone"},
    {4491, 4501, 13, 6, -3, 4490, "CGCS2000 / Gauss-Kruger zone"},
};

std::optional<CrsDefinition> geographic_definition(const GeographicRow& row) {
  CrsDefinition definition;
  definition.projection = Geographic{};
  definition.name = row.name;
  definition.epsg = row.code;
  definition.datum = row.name;
  definition.datum_epsg = row.code == 4979 ? 4326 : row.code;
  const auto ellipsoid = ellipsoid_from_epsg(row.ellipsoid_code);
  if (!ellipsoid) return std::nullopt;
  definition.ellipsoid = *ellipsoid;
  return definition;
}

std::optional<CrsDefinition> geographic_from_code(int code) {
  for (const GeographicRow& row : kGeographic) {
    if (row.code == code) return geographic_definition(row);
  }
  return std::nullopt;
}

std::optional<CrsDefinition> projected(int code, int geographic_code, std::string name, const Projection& projection,
                                       double metres_per_unit = 1.0) {
  auto definition = geographic_from_code(geographic_code);
  if (!definition) return std::nullopt;
  definition->projection = projection;
  definition->name = std::move(name);
  definition->epsg = code;
  definition->metres_per_unit = metres_per_unit;
  return definition;
}

std::string utm_name(const std::string& datum, const UtmRow& row, int zone) {
  const bool hemisphere_said = std::string_view(row.grid) == "UTM";
  return fmt::format("{} / {} zone {}{}", datum, row.grid, zone, hemisphere_said ? (row.south ? "S" : "N") : "");
}

std::optional<CrsDefinition> utm_from_code(int code) {
  for (const UtmRow& row : kUtm) {
    if (code < row.first_code || code > row.last_code) continue;
    const int zone = (row.first_zone + code - row.first_code - 1) % 60 + 1;
    const auto geographic = geographic_from_code(row.geographic_code);
    if (!geographic) return std::nullopt;
    return projected(code, row.geographic_code, utm_name(geographic->name, row, zone), TransverseMercator::utm(zone, row.south));
  }
  return std::nullopt;
}

std::optional<CrsDefinition> gauss_krueger_from_code(int code) {
  for (const GaussKruegerRow& row : kGaussKrueger) {
    if (code < row.first_code || code > row.last_code) continue;
    const int zone = row.first_zone + code - row.first_code;
    double meridian_deg = zone * row.zone_degrees + row.zone_offset_deg;
    if (meridian_deg > 180.0) meridian_deg -= 360.0;
    return projected(code, row.geographic_code, fmt::format("{} {}", row.name, zone),
                     TransverseMercator{.central_meridian_deg = meridian_deg, .false_easting_m = 1000000.0 * zone + 500000.0});
  }
  return std::nullopt;
}

std::optional<CrsDefinition> transverse_mercator_grid_from_code(int code) {
  for (const GridRow& row : kGrids) {
    if (row.code != code) continue;
    return projected(code, row.geographic_code, row.name,
                     TransverseMercator{.latitude_of_origin_deg = row.latitude_of_origin_deg,
                                        .central_meridian_deg = row.central_meridian_deg,
                                        .scale_factor = row.scale_factor,
                                        .false_easting_m = row.false_easting * row.metres_per_unit,
                                        .false_northing_m = row.false_northing * row.metres_per_unit},
                     row.metres_per_unit);
  }
  return std::nullopt;
}

std::optional<CrsDefinition> mercator_from_code(int code) {
  for (const MercatorRow& row : kMercatorGrids)
    if (row.code == code) return projected(code, row.geographic_code, row.name, row.projection);
  return std::nullopt;
}

std::optional<CrsDefinition> cylindrical_equal_area_from_code(int code) {
  if (code != 6933) return std::nullopt;
  return projected(code, 4326, "WGS 84 / NSIDC EASE-Grid 2.0 Global", CylindricalEqualArea{.standard_parallel_deg = 30.0});
}

std::optional<CrsDefinition> web_mercator_from_code(int code) {
  const bool is_one_of_its_names = code == 3857 || code == 900913 || code == 3785;
  return is_one_of_its_names ? projected(3857, 4326, "WGS 84 / Pseudo-Mercator", WebMercator{}) : std::nullopt;
}

struct UnitRow {
  int code;
  double size;
};
constexpr UnitRow kLengthUnits[] = {
    {9001, 1.0},
    {9002, kFootM},
    {9003, kUsFootM},
    {9005, 0.3047972654},        // Clarke's foot
    {9014, 1.8288},              // fathom
    {9030, 1852.0},              // nautical mile
    {9036, 1000.0},              // kilometre
    {9040, 0.9143984146160287},  // Sears' yard
    {9042, 20.116765121552632},  // Sears' chain
    {9084, 0.9143985307444408},  // Indian yard
    {9093, 1609.344},            // statute mile
    {9096, 0.9144},              // yard
    {9097, 20.1168},             // chain
    {1025, 0.001},
    {1033, 0.01},
};
constexpr UnitRow kAngleUnits[] = {
    {9102, 1.0}, {9122, 1.0}, {9101, 180.0 / std::numbers::pi}, {9103, 1.0 / 60.0}, {9104, 1.0 / 3600.0}, {9105, 0.9},  // grad
    {9106, 0.9},                                                                                                        // gon
};

std::optional<double> unit_size(std::span<const UnitRow> rows, int code) {
  for (const UnitRow& row : rows) {
    if (row.code == code) return row.size;
  }
  return std::nullopt;
}

}  // namespace

std::optional<CrsDefinition> definition_from_epsg(int code) {
  for (const auto& look_up : {geographic_from_code, web_mercator_from_code, mercator_from_code, cylindrical_equal_area_from_code,
                              utm_from_code, gauss_krueger_from_code, transverse_mercator_grid_from_code})
    if (auto definition = look_up(code)) return definition;
  return std::nullopt;
}

std::optional<CrsDefinition> geographic_from_datum(int datum_code) {
  for (const GeographicRow& row : kGeographic) {
    if (row.datum_code == datum_code) return geographic_definition(row);
  }
  return std::nullopt;
}

std::optional<Ellipsoid> ellipsoid_from_epsg(int code) {
  for (const EllipsoidRow& row : kEllipsoids) {
    if (row.code != code) continue;
    const bool by_axes = row.semi_minor_m > 0.0;
    return Ellipsoid{.name = row.name,
                     .semi_major_m = row.semi_major_m,
                     .inverse_flattening = by_axes ? row.semi_major_m / (row.semi_major_m - row.semi_minor_m) : row.inverse_flattening};
  }
  return std::nullopt;
}

std::optional<double> metres_from_length_unit(int code) { return unit_size(kLengthUnits, code); }
std::optional<double> degrees_from_angle_unit(int code) { return unit_size(kAngleUnits, code); }

int length_unit_code(double metres_per_unit) {
  for (const UnitRow& row : kLengthUnits) {
    if (std::abs(row.size - metres_per_unit) <= 1e-12 * row.size) return row.code;
  }
  return 0;
}

}  // namespace vt::geo
