// What GDAL notes about a raster in XML: in the TIFF tag 42112 and in NAME.aux.xml beside a file of any
// format. Reading only.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::source {

struct DeclaredBand {
  std::optional<double> scale;
  std::optional<double> offset;
  std::optional<double> nodata;
  std::string unit;
  std::string role_name;  // of the colour interpretation: "Red", "Undefined"
};

struct DeclaredMetadata {
  std::map<int, DeclaredBand> bands;  // counted from 0
  std::vector<std::string> not_read;  // what else it holds that would change the meaning of the samples or their place, in words
};

// The text of TIFF tag 42112. kInvalidData: a scale or an offset that is no number.
[[nodiscard]] Result<DeclaredMetadata> parse_gdal_metadata(std::string_view xml);
// The text of NAME.aux.xml. Errors likewise.
[[nodiscard]] Result<DeclaredMetadata> parse_aux_xml(std::string_view xml);

// A no-data value as GDAL writes it: a decimal number, or "nan" and "inf" in the spellings of several C
// libraries. Empty: none of these.
[[nodiscard]] std::optional<double> parse_nodata(std::string_view text);

// NAME.aux.xml beside the raster: what it declares, and empty when there is none. `info` (whose path is set)
// is told that it was read, and what it holds that is not used. kIo, kInvalidData.
[[nodiscard]] Result<DeclaredMetadata> read_aux_xml(RasterInfo& info);

// All that `upper` declares, and of the rest what `lower` declares.
[[nodiscard]] DeclaredMetadata overlaid(const DeclaredMetadata& upper, const DeclaredMetadata& lower);

// Puts what is declared into the bands of `info`. Bands that it does not have are ignored.
void apply_declared(const DeclaredMetadata& declared, RasterInfo& info);

}  // namespace vt::source
