// Noise from integer hashes: smooth random functions of world position, the same bits on every machine.
// Only + - * / and integers decide the values; pure functions, any thread.
#pragma once

#include <cstdint>

namespace vt::sample {

// A well-mixed 32-bit number for a lattice cell. `salt` tells the uses apart.
constexpr std::uint32_t hash(std::uint32_t salt, std::int64_t x, std::int64_t y) {
  std::uint32_t h = salt ^ static_cast<std::uint32_t>(x) * 0x8DA6B343U ^ static_cast<std::uint32_t>(y) * 0xD8163841U;
  h = (h ^ h >> 16U) * 0x7FEB352DU;
  h = (h ^ h >> 15U) * 0x846CA68BU;
  return h ^ h >> 16U;
}

// 0 <= result < 1, from the upper 24 bits so that float holds it exactly.
constexpr float unit(std::uint32_t bits) { return static_cast<float>(bits >> 8U) * (1.0F / 16777216.0F); }

// Another number from the same hash, for cells that need several.
constexpr std::uint32_t rehash(std::uint32_t bits, std::uint32_t salt) { return hash(bits, salt, 0x51ED); }

constexpr std::int64_t floor_int(double value) {
  const auto truncated = static_cast<std::int64_t>(value);
  return truncated - (static_cast<double>(truncated) > value ? 1 : 0);
}

constexpr float smoothstep(float low, float high, float value) {
  const float t = (value - low) / (high - low);
  if (t <= 0.0F) return 0.0F;
  if (t >= 1.0F) return 1.0F;
  return t * t * (3.0F - 2.0F * t);
}

constexpr float mix(float a, float b, float t) { return a + (b - a) * t; }

// Value and slope (per lattice unit) of a function.
struct Noise1 {
  float value, slope;
};
struct Noise2 {
  float value, slope_x, slope_y;
};

// Random values -1..1 at the integers, fifth-order interpolation between: two continuous derivatives.
constexpr Noise1 noise1(std::uint32_t salt, double x) {
  const std::int64_t cell = floor_int(x);
  const auto t = static_cast<float>(x - static_cast<double>(cell));
  const float a = 2.0F * unit(hash(salt, cell, 0)) - 1.0F;
  const float b = 2.0F * unit(hash(salt, cell + 1, 0)) - 1.0F;
  const float ease = t * t * t * (t * (t * 6.0F - 15.0F) + 10.0F);
  const float ease_slope = 30.0F * t * t * (t * (t - 2.0F) + 1.0F);
  return {a + (b - a) * ease, (b - a) * ease_slope};
}

constexpr Noise2 noise2(std::uint32_t salt, double x, double y) {
  const std::int64_t cell_x = floor_int(x);
  const std::int64_t cell_y = floor_int(y);
  const auto tx = static_cast<float>(x - static_cast<double>(cell_x));
  const auto ty = static_cast<float>(y - static_cast<double>(cell_y));
  const float a = unit(hash(salt, cell_x, cell_y));
  const float b = unit(hash(salt, cell_x + 1, cell_y));
  const float c = unit(hash(salt, cell_x, cell_y + 1));
  const float d = unit(hash(salt, cell_x + 1, cell_y + 1));
  const float ease_x = tx * tx * tx * (tx * (tx * 6.0F - 15.0F) + 10.0F);
  const float ease_y = ty * ty * ty * (ty * (ty * 6.0F - 15.0F) + 10.0F);
  const float ease_slope_x = 30.0F * tx * tx * (tx * (tx - 2.0F) + 1.0F);
  const float ease_slope_y = 30.0F * ty * ty * (ty * (ty - 2.0F) + 1.0F);
  const float mixed = a - b - c + d;
  return {2.0F * (a + (b - a) * ease_x + (c - a) * ease_y + mixed * ease_x * ease_y) - 1.0F, 2.0F * (b - a + mixed * ease_y) * ease_slope_x,
          2.0F * (c - a + mixed * ease_x) * ease_slope_y};
}

}  // namespace vt::sample
