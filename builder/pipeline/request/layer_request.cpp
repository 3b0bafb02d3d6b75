#include "builder/pipeline/request/layer_request.h"

#include <charconv>

#include "builder/text/number_text.h"

namespace vt::pipeline {

Result<CoverageChoice> coverage_choice_from(std::string_view text) {
  if (text == "auto") return CoverageChoice{};
  if (text == "none") return CoverageChoice{.kind = CoverageChoice::Kind::kNone};
  int band = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), band);
  if (status == std::errc{} && end == text.data() + text.size() && band >= 1)
    return CoverageChoice{.kind = CoverageChoice::Kind::kBand, .band = band};
  return fail(ErrorCode::kUsage, "coverage comes from auto, none or the number of a band, not from '" + std::string(text) + "'");
}

Result<void> check_range(const LayerRequest& request) {
  if (!request.range || (*request.range)[0] < (*request.range)[1]) return {};
  return fail(ErrorCode::kUsage, "layer '" + request.name + "': `range` is LOW,HIGH, and " + text::number_text((*request.range)[0]) +
                                     " does not lie below " + text::number_text((*request.range)[1]));
}

}  // namespace vt::pipeline
