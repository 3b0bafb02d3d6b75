// libsquish's BC1 encoder: cluster fit, the slow method that others are measured by.
#pragma once

#include <cstddef>
#include <vector>

#include "tests/encode/bc1/bc1_images.h"

namespace vt::encode {

// `iterative`: up to eight rounds, each along the line of the last, instead of one.
[[nodiscard]] std::vector<std::byte> encoded_by_squish(const Image& image, bool iterative = true);

}  // namespace vt::encode
