// A raster in memory, bands interleaved.
#pragma once

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "builder/source/raster_source.h"

namespace vt::resample {

class MemorySource final : public source::RasterSource {
 public:
  MemorySource(std::int64_t width, std::int64_t height, int bands, SampleType type, std::vector<std::byte> samples)
      : samples_(std::move(samples)) {
    info_.width = width;
    info_.height = height;
    info_.bands = bands;
    info_.sample_type = type;
  }

  [[nodiscard]] Result<void> read(const source::Window& window, std::span<const int> bands, std::span<std::byte> out,
                                  std::size_t row_pitch_bytes, store::ContentHasher* content) const override {
    const std::size_t bytes = sample_bytes(info_.sample_type);
    largest_read = std::max(largest_read, window.width * window.height);
    for (std::int64_t y = 0; y < window.height; ++y) {
      std::byte* to = out.data() + static_cast<std::size_t>(y) * row_pitch_bytes;
      for (std::int64_t x = 0; x < window.width; ++x)
        for (const int band : bands) {
          const std::int64_t index = ((window.y + y) * info_.width + window.x + x) * info_.bands + band;
          std::memcpy(to, samples_.data() + static_cast<std::size_t>(index) * bytes, bytes);
          to += bytes;
        }
      if (content != nullptr) content->add({out.data() + static_cast<std::size_t>(y) * row_pitch_bytes, to});
    }
    return {};
  }

  [[nodiscard]] Result<void> hash(const source::Window& window, std::span<const int> bands, store::ContentHasher& content) const override {
    const std::size_t pitch = static_cast<std::size_t>(window.width) * bands.size() * sample_bytes(info_.sample_type);
    std::vector<std::byte> samples(pitch * static_cast<std::size_t>(window.height));
    return read(window, bands, samples, pitch, &content);
  }

  void release_rows_before(std::int64_t row) const override { released.push_back(row); }
  [[nodiscard]] std::size_t resident_bytes() const override { return 0; }
  [[nodiscard]] std::uint64_t decoded_bytes() const override { return 0; }

  mutable std::vector<std::int64_t> released;  // hints in the order they came
  mutable std::int64_t largest_read = 0;       // samples

 private:
  std::vector<std::byte> samples_;
};

}  // namespace vt::resample
