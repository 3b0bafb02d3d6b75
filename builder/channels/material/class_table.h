// The names and colours of a layer's classes, as the user lists them and as the layer's metadata keep them.
// Pure functions, any thread.
#pragma once

#include <string>
#include <string_view>

#include "builder/channels/codec/class_planes.h"
#include "store/result.h"

namespace vt::channels {

// Checks a table of classes, the JSON text [{"id": 1, "name": "water", "color": "#265480"}, ...] or an object
// whose member "classes" is such a list; colours may also be [38, 84, 128], and may be missing. Returns it as
// a JSON list in the order of the ids, colours as "#rrggbb". kInvalidData says which entry is wrong: an id
// that `classes` cannot have or that comes twice, no name, another member.
[[nodiscard]] Result<std::string> checked_class_table(std::string_view text, const ClassCounting& classes);

}  // namespace vt::channels
