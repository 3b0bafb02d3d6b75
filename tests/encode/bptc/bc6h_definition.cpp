#include "tests/encode/bptc/bc6h_definition.h"

#include <bit>
#include <utility>
#include <vector>

#include "builder/encode/bptc/bc6h_block.h"
#include "store/texel/bc6h_table.h"
#include "tests/encode/bptc/bptc_definition.h"

namespace vt::encode {
namespace {

using namespace definition;

constexpr float kLargest = 31743;

float light(std::uint32_t code) {
  return code < 1024 ? std::ldexp(static_cast<float>(code), -24)
                     : std::ldexp(static_cast<float>(1024 + code % 1024), static_cast<int>(code / 1024) - 25);
}
float light_step(std::uint32_t code) { return std::ldexp(1.0F, std::max(static_cast<int>(code / 1024), 1) - 25); }

// A step of the ends to where the sum of light is the source's, at the least cost in squared error.
Line<3> nearer_in_light(const Line<3>& line, const Projection<3>& projection, unsigned index_bits, const Texels<3>& texels,
                        std::uint32_t subset) {
  float a = 0, b = 0, c = 0, count = 0;
  Color<3> missing{}, slope0{}, slope1{}, error{};
  for (std::size_t i = 0; i < 16; ++i) {
    if (!has(subset, i)) continue;
    count += 1;
    const float t = static_cast<float>(store::bptc_weight(index_bits, projection.index(texels[i]))) / 64.0F;
    const float s = 1.0F - t;
    a += s * s, b += s * t, c += t * t;
    for (std::size_t k = 0; k < 3; ++k) {
      const float fitted = std::nearbyint(std::clamp(line.end0[k] * s + line.end1[k] * t, 0.0F, kLargest));
      const auto code = static_cast<std::uint32_t>(fitted);
      missing[k] += light(static_cast<std::uint32_t>(texels[i][k])) - light(code);
      slope0[k] += light_step(code) * s;
      slope1[k] += light_step(code) * t;
      error[k] += (fitted - texels[i][k]) * (fitted - texels[i][k]);
    }
  }
  const float determinant = a * c - b * b;
  const bool solvable = determinant > 1e-3F;
  Line<3> moved;
  for (std::size_t k = 0; k < 3; ++k) {
    const float scale = 1.0F / (solvable ? determinant : 1.0F);
    const float both = (slope0[k] + slope1[k]) / count;
    const float along0 = solvable ? (c * slope0[k] - b * slope1[k]) * scale : both;
    const float along1 = solvable ? (a * slope1[k] - b * slope0[k]) * scale : both;
    const float gain = slope0[k] * along0 + slope1[k] * along1;
    float factor = gain > 0 ? missing[k] / std::max(gain, 1e-30F) : 0.0F;
    const float cost = missing[k] * factor;
    const float allowed = error[k] + count;
    if (cost > allowed) factor *= std::sqrt(allowed / std::max(cost, 1e-30F));
    moved.end0[k] = std::clamp(line.end0[k] + along0 * factor, 0.0F, kLargest);
    moved.end1[k] = std::clamp(line.end1[k] + along1 * factor, 0.0F, kLargest);
  }
  return moved;
}

Line<3> with_light_kept(const Line<3>& line, unsigned index_bits, const Texels<3>& texels, std::uint32_t subset) {
  const Projection<3> projection(line, index_bits);
  return nearer_in_light(nearer_in_light(line, projection, index_bits, texels, subset), projection, index_bits, texels, subset);
}

using EndCode = std::array<std::uint32_t, 3>;

EndCode nearest(const Color<3>& end, int bits) {
  EndCode codes{};
  for (std::size_t k = 0; k < 3; ++k) {
    const float number = end[k] * (64.0F / 31.0F) + 32.0F / 31.0F;
    const float position = bits == 16 ? number : number * (1.0F / static_cast<float>(1 << (16 - bits))) - 0.5F;
    codes[k] = static_cast<std::uint32_t>(std::nearbyint(std::clamp(position, 0.0F, static_cast<float>((1 << bits) - 1))));
  }
  return codes;
}

std::uint32_t unquantized(std::uint32_t code, int bits) {
  if (bits == 16 || code == 0) return code;
  return code == (1U << bits) - 1U ? 0xFFFFU : (code << 16U | 0x8000U) >> bits;
}

// What a candidate stores, and what it costs: over subsets and channels, the squared error of codes, and
// kLightWeight times the least such error that would bring the sum of light back, but for a share kFreeLight
// of it.
struct Candidate {
  Bc6hChoice choice;
  float cost = 0;
};
constexpr float kLightWeight = 128;
constexpr float kFreeLight = 0.02F;

unsigned index_bits(const Candidate& candidate) { return store::kBc6hModes[candidate.choice.mode].subsets == 1 ? 4 : 3; }
float weight_of(const Candidate& candidate, std::size_t i) {
  return static_cast<float>(store::bptc_weight(index_bits(candidate), static_cast<unsigned>(candidate.choice.indices >> (4 * i) & 15U)));
}

// Indices of subset `subset`, whose texels are those in `mask`. Texels move with the line from `fitted` to
// `kept`.
void pick_indices(Candidate& candidate, std::size_t subset, std::uint32_t mask, const Line<3>& fitted, const Line<3>& kept,
                  const Texels<3>& texels) {
  const store::Bc6hMode& mode = store::kBc6hModes[candidate.choice.mode];
  Line<3> line;
  for (std::size_t k = 0; k < 3; ++k) {
    line.end0[k] = static_cast<float>(unquantized(candidate.choice.ends[2 * subset][k], mode.base_bits)) * (31.0F / 64.0F) - 0.5F;
    line.end1[k] = static_cast<float>(unquantized(candidate.choice.ends[2 * subset + 1][k], mode.base_bits)) * (31.0F / 64.0F) - 0.5F;
  }
  const Projection<3> projection(line, index_bits(candidate)), on_fitted(fitted, index_bits(candidate));
  for (std::size_t i = 0; i < 16; ++i) {
    if (!has(mask, i)) continue;
    const auto weight = static_cast<float>(store::bptc_weight(index_bits(candidate), on_fitted.index(texels[i])));
    Color<3> moved = texels[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const float shift0 = kept.end0[k] - fitted.end0[k];
      const float shift_along = ((kept.end1[k] - fitted.end1[k]) - shift0) * (1.0F / 64.0F);
      moved[k] += shift0 + shift_along * weight;
    }
    candidate.choice.indices |= std::uint64_t{projection.index(moved)} << (4 * i);
  }
}

// For each channel of a subset: its light, and kLightWeight over the square of the light that a unit of
// squared error buys at the texels' positions, see nearer_in_light().
struct SubsetLight {
  Color<3> total{};
  Color<3> cost{};
};

SubsetLight light_of_subset(const Candidate& candidate, std::uint32_t mask, const Texels<3>& texels) {
  float a = 0, b = 0, c = 0, count = 0;
  Color<3> slope0{}, slope1{};
  SubsetLight result;
  for (std::size_t i = 0; i < 16; ++i) {
    if (!has(mask, i)) continue;
    count += 1;
    const float t = weight_of(candidate, i) * (1.0F / 64.0F);
    const float s = 1.0F - t;
    a += s * s, b += s * t, c += t * t;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto code = static_cast<std::uint32_t>(texels[i][k]);
      slope0[k] += light_step(code) * s;
      slope1[k] += light_step(code) * t;
      result.total[k] += light(code);
    }
  }
  const float determinant = a * c - b * b;
  for (std::size_t k = 0; k < 3; ++k) {
    const float both = slope0[k] + slope1[k];
    const float gain = determinant > 1e-3F
                           ? (slope0[k] * (c * slope0[k] - b * slope1[k]) + slope1[k] * (a * slope1[k] - b * slope0[k])) / determinant
                           : both * both / std::max(count, 1.0F);
    result.cost[k] = kLightWeight / std::max(gain, 1e-30F);
  }
  return result;
}

// For each channel of a subset with these ends, a share `free_light` of the light being free.
Color<3> channel_costs(const Candidate& candidate, const EndCode& end0, const EndCode& end1, std::uint32_t mask, const SubsetLight& wanted,
                       float free_light, const Texels<3>& texels) {
  const store::Bc6hMode& mode = store::kBc6hModes[candidate.choice.mode];
  Color<3> squares{}, total{}, costs{};
  for (std::size_t i = 0; i < 16; ++i) {
    if (!has(mask, i)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t decoded = store::bptc_interpolated(unquantized(end0[k], mode.base_bits), unquantized(end1[k], mode.base_bits),
                                                             static_cast<unsigned>(weight_of(candidate, i))) *
                                    31 / 64;
      const float d = static_cast<float>(decoded) - texels[i][k];
      squares[k] += d * d;
      total[k] += light(decoded);
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const float excess = std::max(std::abs(wanted.total[k] - total[k]) - free_light * wanted.total[k], 0.0F);
    costs[k] = squares[k] + excess * excess * wanted.cost[k];
  }
  return costs;
}

std::uint32_t subset_mask(std::size_t partition, std::size_t subset) {
  return subset == 1 ? store::kTwoSubsets[partition] : store::kTwoSubsets[partition] ^ kWholeBlock;
}
std::uint32_t subset_mask(const Candidate& candidate, std::size_t subset) {
  if (store::kBc6hModes[candidate.choice.mode].subsets == 1) return subset == 0 ? kWholeBlock : 0;
  return subset_mask(candidate.choice.partition, subset);
}

void add_costs(Candidate& candidate, const Texels<3>& texels) {
  candidate.cost = 0;
  for (std::size_t s = 0; s < 2; ++s) {
    const std::uint32_t mask = subset_mask(candidate, s);
    const Color<3> costs = channel_costs(candidate, candidate.choice.ends[2 * s], candidate.choice.ends[2 * s + 1], mask,
                                         light_of_subset(candidate, mask, texels), kFreeLight, texels);
    for (const float cost : costs) candidate.cost += cost;
  }
}

// Whether a transformed mode holds these ends whatever their order.
bool differences_fit(const EndCode& p, const EndCode& q, const store::Bc6hMode& mode) {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(static_cast<int>(p[k]) - static_cast<int>(q[k])) >= 1 << (mode.delta_bits[k] - 1)) return false;
  return true;
}

Candidate one_subset(const Texels<3>& texels, int passes) {
  const Moments<3> m(texels, kWholeBlock);
  Line<3> line = extremes(texels, kWholeBlock, m);
  Candidate best;
  for (int pass = 0; pass < passes; ++pass) {
    line = refined(line, 4, texels, kWholeBlock, m).line;
    const Line<3> kept = with_light_kept(line, 4, texels, kWholeBlock);
    Candidate candidate;
    for (const std::uint32_t row : {13U, 12U, 11U, 10U}) {
      const store::Bc6hMode& mode = store::kBc6hModes[row];
      const EndCode end0 = nearest(kept.end0, mode.base_bits), end1 = nearest(kept.end1, mode.base_bits);
      candidate.choice.mode = row;
      candidate.choice.ends = {end0, end1, end0, end1};
      if (!mode.transformed || differences_fit(end0, end1, mode)) break;
    }
    pick_indices(candidate, 0, kWholeBlock, line, kept, texels);
    add_costs(candidate, texels);
    if (pass == 0 || candidate.cost < best.cost) best = candidate;
  }
  return best;
}

Candidate two_subsets(const Texels<3>& texels, std::size_t partition) {
  std::array<Line<3>, 2> fitted, kept;
  for (std::size_t s = 0; s < 2; ++s) {
    const std::uint32_t mask = subset_mask(partition, s);
    const Moments<3> m(texels, mask);
    fitted[s] = extremes(texels, mask, m);
    for (int pass = 0; pass < 2; ++pass) fitted[s] = refined(fitted[s], 3, texels, mask, m).line;
    kept[s] = with_light_kept(fitted[s], 3, texels, mask);
  }
  Candidate candidate;
  candidate.choice.partition = static_cast<std::uint32_t>(partition);
  // Finest first.
  for (const std::uint32_t row : {2U, 3U, 4U, 0U, 5U, 6U, 7U, 8U, 1U, 9U}) {
    const store::Bc6hMode& mode = store::kBc6hModes[row];
    auto& ends = candidate.choice.ends;
    for (std::size_t s = 0; s < 2; ++s) {
      ends[2 * s] = nearest(kept[s].end0, mode.base_bits);
      ends[2 * s + 1] = nearest(kept[s].end1, mode.base_bits);
    }
    candidate.choice.mode = row;
    bool fits = true;
    for (std::size_t p = 0; p < 4; ++p)
      for (std::size_t q = 0; q < p; ++q) fits = fits && differences_fit(ends[p], ends[q], mode);
    if (fits || !mode.transformed) break;
  }
  for (std::size_t s = 0; s < 2; ++s) pick_indices(candidate, s, subset_mask(partition, s), fitted[s], kept[s], texels);
  add_costs(candidate, texels);
  return candidate;
}

// All texels in the half nearest to their mean light.
Candidate one_color(const Texels<3>& texels) {
  Color<3> sum{};
  for (const Color<3>& texel : texels)
    for (std::size_t k = 0; k < 3; ++k) sum[k] += light(static_cast<std::uint32_t>(texel[k]));
  Color<3> mean{};
  for (std::size_t k = 0; k < 3; ++k) {
    // Exponent and mantissa of a half are those of a float 112 octaves down; halves up.
    const auto bits = std::bit_cast<std::uint32_t>(sum[k] * (0x1p-112F / 16.0F));
    mean[k] = static_cast<float>((bits + 0x1000U) >> 13U);
  }
  Candidate candidate;
  candidate.choice.mode = 13;
  candidate.choice.ends.fill(nearest(mean, 16));
  add_costs(candidate, texels);
  return candidate;
}

// Single steps of single codes, as long as they cost less, two rounds of them; the indices stay.
void step_ends(Candidate& candidate, const Texels<3>& texels) {
  const store::Bc6hMode& mode = store::kBc6hModes[candidate.choice.mode];
  const std::size_t subsets = mode.subsets == 1 ? 1 : 2;
  auto& ends = candidate.choice.ends;
  for (int round = 0; round < 2; ++round)
    for (std::size_t s = 0; s < subsets; ++s) {
      const std::uint32_t mask = subset_mask(candidate, s);
      const SubsetLight wanted = light_of_subset(candidate, mask, texels);
      Color<3> best = channel_costs(candidate, ends[2 * s], ends[2 * s + 1], mask, wanted, 0.0F, texels);
      const std::array<EndCode, 2> start{ends[2 * s], ends[2 * s + 1]};
      std::array<EndCode, 2> kept = start;
      for (const std::size_t end : {0, 1})
        for (const int step : {-1, 1}) {
          std::array<EndCode, 2> moved = start;
          std::array<bool, 3> is_possible{};
          for (std::size_t k = 0; k < 3; ++k) {
            const int code = static_cast<int>(start[end][k]) + step;
            is_possible[k] = code >= 0 && code < 1 << mode.base_bits;
            if (is_possible[k]) moved[end][k] = static_cast<std::uint32_t>(code);
            std::uint32_t low = moved[0][k], high = moved[0][k];
            for (std::size_t e = 0; e < 2 * subsets; ++e) {
              const std::uint32_t other = e / 2 == s ? moved[e % 2][k] : ends[e][k];
              low = std::min(low, other), high = std::max(high, other);
            }
            is_possible[k] = is_possible[k] && (!mode.transformed || high - low < 1U << (mode.delta_bits[k] - 1));
          }
          const Color<3> costs = channel_costs(candidate, moved[0], moved[1], mask, wanted, 0.0F, texels);
          for (std::size_t k = 0; k < 3; ++k) {
            if (!is_possible[k] || !(costs[k] < best[k])) continue;
            best[k] = costs[k];
            kept[0][k] = moved[0][k], kept[1][k] = moved[1][k];
          }
        }
      ends[2 * s] = kept[0], ends[2 * s + 1] = kept[1];
      if (subsets == 1) ends[2] = kept[0], ends[3] = kept[1];
    }
}

// Sums of channels and products over some texels, in the order in which the encoder adds them.
struct Sums {
  Color<3> sum{};
  std::array<Color<3>, 3> rows{};

  void add(const Color<3>& texel) {
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] += texel[c];
      for (std::size_t d = 0; d < 3; ++d) rows[c][d] += texel[c] * texel[d];
    }
  }
  float off_line(float count) const {
    std::array<Color<3>, 3> scatter = rows;
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t d = 0; d < 3; ++d) scatter[c][d] -= sum[c] * sum[d] * (1.0F / count);
    const Color<3> axis = principal_axis(scatter, 3);
    Color<3> image{};
    for (std::size_t c = 0; c < 3; ++c) image[c] = dot(scatter[c], axis);
    return scatter[0][0] + scatter[1][1] + scatter[2][2] - dot(image, axis) / std::max(dot(axis, axis), 1e-20F);
  }
};

// The 32 partitions, best first.
std::vector<std::size_t> ranked(const Texels<3>& texels) {
  Texels<3> centred = texels;
  for (std::size_t c = 0; c < 3; ++c) {
    float sum = 0;
    for (const Color<3>& texel : texels) sum += texel[c];
    for (Color<3>& texel : centred) texel[c] -= std::nearbyint(sum / 16.0F);
  }
  Sums total;
  for (const Color<3>& texel : centred) total.add(texel);
  std::vector<std::pair<float, std::size_t>> errors;
  for (std::size_t p = 0; p < 32; ++p) {
    Sums second, first = total;
    float count = 0;
    for (std::size_t i = 0; i < 16; ++i)
      if (has(store::kTwoSubsets[p], i)) second.add(centred[i]), count += 1;
    for (std::size_t c = 0; c < 3; ++c) {
      first.sum[c] -= second.sum[c];
      for (std::size_t d = 0; d < 3; ++d) first.rows[c][d] -= second.rows[c][d];
    }
    errors.emplace_back(first.off_line(16.0F - count) + second.off_line(count), p);
  }
  std::sort(errors.begin(), errors.end());
  std::vector<std::size_t> order;
  for (const auto& [error, p] : errors) order.push_back(p);
  return order;
}

}  // namespace

std::array<std::byte, 16> encode_bc6h_block_by_definition(const HalfTexels& halves, Quality quality) {
  Texels<3> texels{};
  for (std::size_t i = 0; i < 16; ++i)
    for (std::size_t k = 0; k < 3; ++k) texels[i][k] = halves[i][k] == 0x7C00 ? kLargest : halves[i][k] > 0x7C00 ? 0.0F : halves[i][k];
  Candidate best = one_subset(texels, quality == Quality::kFast ? 1 : 4);
  if (quality != Quality::kFast) {
    const std::vector<std::size_t> order = ranked(texels);
    for (std::size_t k = 0; k < (quality == Quality::kBest ? 6 : 1); ++k) {
      const Candidate candidate = two_subsets(texels, order[k]);
      if (candidate.cost < best.cost) best = candidate;
    }
  }
  if (const Candidate flat = one_color(texels); flat.cost < best.cost) best = flat;
  step_ends(best, texels);
  std::array<std::byte, 16> block{};
  write_bc6h_block(best.choice, block);
  return block;
}

}  // namespace vt::encode
