// Buffers that are used again and again. Private to this folder.
#pragma once

#include <cstddef>
#include <vector>

namespace vt::resample {

// As resize(), but a buffer that grows takes what is asked for and not twice as much, and what was in it is
// not copied.
template <class T>
void refit(std::vector<T>& buffer, std::size_t count) {
  if (buffer.capacity() < count) {
    std::vector<T>().swap(buffer);
    buffer.reserve(count);
  }
  buffer.resize(count);
}

}  // namespace vt::resample
