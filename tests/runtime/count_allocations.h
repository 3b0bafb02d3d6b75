// How often this thread has called operator new, which this test program replaces.
#pragma once

#include <cstdint>

namespace vt::runtime::test {
[[nodiscard]] std::uint64_t allocations_of_this_thread();
}
