#include "tests/encode/bc7_definition.h"

#include "builder/encode/bc7_block.h"
#include "store/bc7.h"
#include "tests/encode/bptc_definition.h"

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
float distance2(const Color<n>& p, const Color<n>& q) {
  Color<n> d = p;
  for (std::size_t c = 0; c < n; ++c) d[c] -= q[c];
  return dot(d, d);
}

template <std::size_t n>
struct SubsetCode {
  Codes<n> end0, end1;
  std::array<int, 2> lowest{};
  std::array<std::uint32_t, 16> indices{};
  int error = 0;
};

// The lowest bits that bring both ends nearest: each its own choice, or one for both.
template <std::size_t n>
SubsetCode<n> quantized(const Line<n>& line, int code_bits, int lowest_bits, bool ones) {
  SubsetCode<n> subset;
  const bool has_lowest = lowest_bits != 0;
  if (has_lowest) {
    const auto loss = [&](const Color<n>& end, int lowest) { return distance2(nearest(end, code_bits, true, lowest).value, end); };
    const auto& [e0, e1] = line;
    if (lowest_bits == 2) {
      subset.lowest = {loss(e0, 1) < loss(e0, 0) ? 1 : 0, loss(e1, 1) < loss(e1, 0) ? 1 : 0};
    } else {
      subset.lowest.fill(loss(e0, 1) + loss(e1, 1) < loss(e0, 0) + loss(e1, 0) ? 1 : 0);
    }
    if (ones) subset.lowest = {1, 1};
  }
  subset.end0 = nearest(line.end0, code_bits, has_lowest, subset.lowest[0]);
  subset.end1 = nearest(line.end1, code_bits, has_lowest, subset.lowest[1]);
  return subset;
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
};

template <std::size_t n>
void put_subset(Bc7Choice& choice, std::size_t subset, const SubsetCode<n>& code) {
  for (unsigned c = 0; c < n; ++c) {
    choice.ends[2 * subset] |= code.end0.code[c] << (8 * c);
    choice.ends[2 * subset + 1] |= code.end1.code[c] << (8 * c);
  }
  for (unsigned end = 0; end < 2; ++end)
    choice.head |= static_cast<std::uint32_t>(code.lowest[end]) << (Bc7Choice::kLowestBitShift + 2 * static_cast<unsigned>(subset) + end);
  for (std::size_t i = 0; i < 16; ++i) choice.indices |= std::uint64_t{code.indices[i]} << (4 * i);
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
  Candidate best;
  if (is_flat) {
    best.choice.head = Bc7Choice::kSolid;
    for (unsigned c = 0; c < 4; ++c) best.choice.ends[0] |= static_cast<std::uint32_t>(values[0][c]) << (8 * c);
  } else {
    best.choice.head = 6;
    put_subset(best.choice, 0, fitted<4>(texels, kWholeBlock, 7, 2, 4, is_opaque, quality == Quality::kFast ? 2 : 4));
  }
  std::array<std::byte, 16> block{};
  write_bc7_block(best.choice, block);
  return block;
}

}  // namespace vt::encode
