// Which prediction to use: the one whose residuals have the least entropy on a sample of rows. Private to
// prediction*.cpp; prediction.h says what the arguments are. At least two rows and two columns.
#pragma once

#include <cstdint>

#include "store/codec/prediction.h"
#include "store/codec/prediction_words.h"

namespace vt::store {

[[nodiscard]] Prediction choose_for_bytes(const std::uint8_t* texels, const TileShape& shape);
template <std::unsigned_integral Word>
[[nodiscard]] Prediction choose_for_words(WordOrder order, const std::uint8_t* texels, const TileShape& shape);

}  // namespace vt::store
