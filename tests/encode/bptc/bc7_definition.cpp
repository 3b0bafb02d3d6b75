#include "tests/encode/bptc/bc7_definition.h"

#include <utility>
#include <vector>

#include "builder/encode/bptc/bc7_block.h"
#include "store/texel/bc7.h"
#include "tests/encode/bptc/bptc_definition.h"

namespace vt::encode {
namespace {

using namespace definition;

// Codes of one end point in a mode, and what they decode to.
template <std::size_t n>
struct Codes {
  std::array<std::uint32_t, n> code{};
  Color<n> value{};
};

template <std::size_t n>
Codes<n> nearest(const Color<n>& color, int code_bits, bool has_lowest, int lowest) {
  const int total_bits = code_bits + (has_lowest ? 1 : 0);
  Codes<n> codes;
  for (std::size_t c = 0; c < n; ++c) {
    float step = color[c] * (static_cast<float>((1 << total_bits) - 1) / 255.0F);
    if (has_lowest) step = (step - static_cast<float>(lowest)) * 0.5F;
    codes.code[c] = static_cast<std::uint32_t>(std::nearbyint(std::clamp(step, 0.0F, static_cast<float>((1 << code_bits) - 1))));
    const unsigned total = has_lowest ? codes.code[c] * 2 + static_cast<unsigned>(lowest) : codes.code[c];
    codes.value[c] = static_cast<float>(total << (8 - total_bits) | total >> (2 * total_bits - 8));
  }
  return codes;
}

template <std::size_t n>
Color<n> difference(const Color<n>& p, const Color<n>& q) {
  Color<n> d = p;
  for (std::size_t c = 0; c < n; ++c) d[c] -= q[c];
  return d;
}

template <std::size_t n>
struct SubsetCode {
  Codes<n> end0, end1;
  std::array<int, 2> lowest{};
  std::array<std::uint32_t, 16> indices{};
  int error = 0;
};

// The lowest bits that cost least: each end's own, or one for both.
template <std::size_t n>
SubsetCode<n> quantized(const Solution<n>& solution, int code_bits, int lowest_bits, bool ones) {
  SubsetCode<n> best;
  float least = 0;
  std::vector<std::array<int, 2>> choices{{0, 0}};
  if (lowest_bits == 1) choices = {{1, 1}, {0, 0}};
  if (lowest_bits == 2) choices = {{1, 1}, {0, 1}, {1, 0}, {0, 0}};
  if (ones) choices.resize(1);
  for (const std::array<int, 2>& lowest : choices) {
    SubsetCode<n> candidate;
    candidate.lowest = lowest;
    candidate.end0 = nearest(solution.line.end0, code_bits, lowest_bits != 0, lowest[0]);
    candidate.end1 = nearest(solution.line.end1, code_bits, lowest_bits != 0, lowest[1]);
    const Color<n> d0 = difference(candidate.end0.value, solution.line.end0), d1 = difference(candidate.end1.value, solution.line.end1);
    const float cost = solution.a * dot(d0, d0) + solution.c * dot(d1, d1) + (solution.b + solution.b) * dot(d0, d1);
    if (lowest != choices[0] && cost >= least) continue;
    least = cost;
    best = candidate;
  }
  return best;
}

template <std::size_t n>
void evaluate(const Texels<n>& texels, std::uint32_t mask, unsigned index_bits, SubsetCode<n>& subset) {
  const Projection<n> projection({subset.end0.value, subset.end1.value}, index_bits);
  for (std::size_t i = 0; i < 16; ++i) {
    if (!has(mask, i)) continue;
    subset.indices[i] = projection.index(texels[i]);
    for (std::size_t c = 0; c < n; ++c) {
      const auto decoded = static_cast<int>(store::bptc_interpolated(static_cast<std::uint32_t>(subset.end0.value[c]),
                                                                     static_cast<std::uint32_t>(subset.end1.value[c]),
                                                                     store::bptc_weight(index_bits, subset.indices[i])));
      const int d = decoded - static_cast<int>(texels[i][c]);
      subset.error += d * d;
    }
  }
}

// The best of `passes` rounds of least squares and rounding.
template <std::size_t n>
SubsetCode<n> fitted(const Texels<n>& texels, std::uint32_t mask, int code_bits, int lowest_bits, unsigned index_bits, bool ones,
                     int passes) {
  const Moments<n> m(texels, mask);
  Line<n> line = extremes(texels, mask, m);
  SubsetCode<n> best;
  for (int pass = 0; pass < passes; ++pass) {
    SubsetCode<n> candidate = quantized(refined(line, index_bits, texels, mask, m), code_bits, lowest_bits, ones);
    evaluate(texels, mask, index_bits, candidate);
    line = {candidate.end0.value, candidate.end1.value};
    if (pass == 0 || candidate.error < best.error) best = candidate;
  }
  return best;
}

struct Candidate {
  Bc7Choice choice;
  int error = 0;
  explicit Candidate(std::uint32_t mode, std::size_t partition = 0) {
    choice.head = mode | static_cast<std::uint32_t>(partition) << Bc7Choice::kPartitionShift;
  }
};

template <std::size_t n>
void put_subset(Candidate& candidate, std::size_t subset, const SubsetCode<n>& code) {
  Bc7Choice& choice = candidate.choice;
  candidate.error += code.error;
  for (unsigned c = 0; c < n; ++c) {
    choice.ends[2 * subset] |= code.end0.code[c] << (8 * c);
    choice.ends[2 * subset + 1] |= code.end1.code[c] << (8 * c);
  }
  for (unsigned end = 0; end < 2; ++end)
    choice.head |= static_cast<std::uint32_t>(code.lowest[end]) << (Bc7Choice::kLowestBitShift + 2 * static_cast<unsigned>(subset) + end);
  for (std::size_t i = 0; i < 16; ++i) choice.indices |= std::uint64_t{code.indices[i]} << (4 * i);
}

std::uint32_t subset_mask(std::size_t subsets, std::size_t partition, std::size_t subset) {
  std::uint32_t mask = 0;
  for (std::size_t i = 0; i < 16; ++i)
    if (store::bptc_subset(subsets, partition, i) == subset) mask |= 1U << i;
  return mask;
}

// The mode's own numbers from the specification's table.
template <std::size_t n>
Candidate partitioned(const Texels<n>& texels, std::uint32_t mode_number, std::size_t partition) {
  const store::Bc7Mode& mode = store::kBc7Modes[mode_number];
  Candidate candidate(mode_number, partition);
  for (std::size_t s = 0; s < mode.subsets; ++s)
    put_subset(candidate, s,
               fitted<n>(texels, subset_mask(mode.subsets, partition, s), mode.color_bits, mode.p_bits, mode.index_bits, false, 2));
  return candidate;
}

// Squared error of a line through the texels in `mask`, whose values have the block's rounded mean taken
// away.
template <std::size_t n>
float off_line(const Texels<n>& centred, std::uint32_t mask) {
  float count = 0;
  Color<n> sum{};
  std::array<Color<n>, n> rows{};
  for (std::size_t i = 0; i < 16; ++i) {
    if (!has(mask, i)) continue;
    count += 1;
    for (std::size_t c = 0; c < n; ++c) {
      sum[c] += centred[i][c];
      for (std::size_t d = 0; d < n; ++d) rows[c][d] += centred[i][c] * centred[i][d];
    }
  }
  for (std::size_t c = 0; c < n; ++c)
    for (std::size_t d = 0; d < n; ++d) rows[c][d] -= sum[c] * sum[d] * (1.0F / count);
  const Color<n> axis = principal_axis(rows, 3);
  float trace = 0;
  Color<n> image{};
  for (std::size_t c = 0; c < n; ++c) trace += rows[c][c], image[c] = dot(rows[c], axis);
  return trace - dot(image, axis) / std::max(dot(axis, axis), 1e-20F);
}

// The first `partitions` partitions, best first.
template <std::size_t n>
std::vector<std::size_t> ranked(const Texels<n>& texels, std::size_t subsets, std::size_t partitions) {
  Texels<n> centred = texels;
  for (std::size_t c = 0; c < n; ++c) {
    float sum = 0;
    for (const Color<n>& texel : texels) sum += texel[c];
    for (Color<n>& texel : centred) texel[c] -= std::nearbyint(sum / 16.0F);
  }
  std::vector<std::pair<float, std::size_t>> errors;
  for (std::size_t p = 0; p < partitions; ++p) {
    float error = 0;
    for (std::size_t s = 0; s < subsets; ++s) error += off_line(centred, subset_mask(subsets, p, s));
    errors.emplace_back(error, p);
  }
  std::sort(errors.begin(), errors.end());
  std::vector<std::size_t> order;
  for (const auto& [error, p] : errors) order.push_back(p);
  return order;
}

Candidate separated(const Texels<4>& texels, std::uint32_t mode_number, std::size_t rotation, std::uint32_t selection, int passes) {
  const store::Bc7Mode& mode = store::kBc7Modes[mode_number];
  Texels<3> color{};
  Texels<1> alpha{};
  for (std::size_t i = 0; i < 16; ++i) {
    Color<4> texel = texels[i];
    if (rotation != 0) std::swap(texel[rotation - 1], texel[3]);
    std::copy_n(texel.begin(), 3, color[i].begin());
    alpha[i][0] = texel[3];
  }
  const unsigned color_index_bits = selection == 0 ? mode.index_bits : mode.index_bits_more;
  const unsigned alpha_index_bits = selection == 0 ? mode.index_bits_more : mode.index_bits;
  Candidate candidate(mode_number);
  candidate.choice.head |= static_cast<std::uint32_t>(rotation) << Bc7Choice::kRotationShift | selection << Bc7Choice::kSelectionShift;
  put_subset(candidate, 0, fitted<3>(color, kWholeBlock, mode.color_bits, 0, color_index_bits, false, passes));
  const SubsetCode<1> own = fitted<1>(alpha, kWholeBlock, mode.alpha_bits, 0, alpha_index_bits, false, passes);
  candidate.error += own.error;
  candidate.choice.ends[0] |= own.end0.code[0] << 24U;
  candidate.choice.ends[1] |= own.end1.code[0] << 24U;
  for (std::size_t i = 0; i < 16; ++i) candidate.choice.alpha_indices |= std::uint64_t{own.indices[i]} << (4 * i);
  return candidate;
}

// The candidates of a block in the order in which they compete.
std::vector<Candidate> candidates(const Texels<4>& texels, bool is_opaque, Quality quality) {
  const bool is_best = quality == Quality::kBest;
  std::vector<Candidate> list{Candidate(6)};
  put_subset(list[0], 0, fitted<4>(texels, kWholeBlock, 7, 2, 4, is_opaque, quality == Quality::kFast ? 2 : 4));
  if (!is_opaque) {
    const int passes = is_best ? 4 : 2;
    list.push_back(separated(texels, 5, 0, 0, passes));
    if (quality == Quality::kFast) return list;
    const std::vector<std::size_t> order = ranked(texels, 2, 64);
    for (std::size_t k = 0; k < (is_best ? 8 : 1); ++k) list.push_back(partitioned(texels, 7, order[k]));
    for (std::size_t rotation = 0; is_best && rotation < 4; ++rotation) {
      if (rotation != 0) list.push_back(separated(texels, 5, rotation, 0, passes));
      for (const std::uint32_t selection : {0U, 1U}) list.push_back(separated(texels, 4, rotation, selection, passes));
    }
    return list;
  }

  if (quality == Quality::kFast) return list;
  Texels<3> rgb{};
  for (std::size_t i = 0; i < 16; ++i) std::copy_n(texels[i].begin(), 3, rgb[i].begin());
  const std::vector<std::size_t> order = ranked(rgb, 2, 64);
  for (std::size_t k = 0; k < (is_best ? 8 : 2); ++k) list.push_back(partitioned(rgb, 1, order[k]));
  for (std::size_t k = 0; k < (is_best ? 8 : 1); ++k) list.push_back(partitioned(rgb, 3, order[k]));
  if (!is_best) return list;
  const std::vector<std::size_t> order16 = ranked(rgb, 3, 16), order64 = ranked(rgb, 3, 64);
  for (std::size_t k = 0; k < 4; ++k) {
    list.push_back(partitioned(rgb, 0, order16[k]));
    list.push_back(partitioned(rgb, 2, order64[k]));
  }
  for (std::size_t rotation = 1; rotation < 4; ++rotation) {
    list.push_back(separated(texels, 5, rotation, 0, 2));
    for (const std::uint32_t selection : {0U, 1U}) list.push_back(separated(texels, 4, rotation, selection, 2));
  }
  return list;
}

}  // namespace

std::array<std::byte, 16> encode_bc7_block_by_definition(const RgbaTexels& values, Quality quality) {
  Texels<4> texels{};
  bool is_opaque = true, is_flat = true;
  for (std::size_t i = 0; i < 16; ++i) {
    for (std::size_t c = 0; c < 4; ++c) texels[i][c] = static_cast<float>(values[i][c]);
    is_opaque = is_opaque && values[i][3] == 255;
    is_flat = is_flat && values[i] == values[0];
  }
  Bc7Choice choice;
  if (is_flat) {
    choice.head = Bc7Choice::kSolid;
    for (unsigned c = 0; c < 4; ++c) choice.ends[0] |= static_cast<std::uint32_t>(values[0][c]) << (8 * c);
  } else {
    const std::vector<Candidate> list = candidates(texels, is_opaque, quality);
    const auto less = [](const Candidate& p, const Candidate& q) { return p.error < q.error; };
    choice = std::min_element(list.begin(), list.end(), less)->choice;
  }
  std::array<std::byte, 16> block{};
  write_bc7_block(choice, block);
  return block;
}

}  // namespace vt::encode
