// A sensor's band as users give it: two edges, a table of a response, or both. Pure functions, any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "builder/channels/codec/channel_settings.h"
#include "builder/channels/sensor/planck.h"
#include "store/result.h"

namespace vt::channels {

// A table of wavelengths in micrometres and responses, in increasing order of wavelength. Either JSON,
// {"wavelength_um": [...], "response": [...]}; or lines of two numbers with commas, semicolons or blanks
// between them, where lines that begin with # and one first line of headings are passed over. kInvalidData:
// anything else, negative responses, or wavelengths that are not from 0.2 to 1000.
[[nodiscard]] Result<std::vector<ResponsePoint>> parse_response(std::string_view text);

// What the options "band" and "response" say: the table, cut to the band when both are given; a response of 1
// between the band's edges when only the band is; empty when neither is. kUsage: no such band.
[[nodiscard]] Result<std::vector<ResponsePoint>> response_of(const Options& options);

}  // namespace vt::channels
