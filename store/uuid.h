// The names that stores carry for life.
#pragma once

#include "store/layout.h"

namespace vt::store {

// RFC 4122, version 4: random. Any thread.
[[nodiscard]] Uuid random_uuid();

}  // namespace vt::store
