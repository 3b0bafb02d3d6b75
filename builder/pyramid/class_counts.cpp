#include "builder/pyramid/class_counts.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vt::pyramid {
namespace {

// The sum of two ascending lists. Returns the end of what was written; `out` has room for all.
ClassCount* add_lists(const ClassCount* a, const ClassCount* a_end, const ClassCount* b, const ClassCount* b_end, ClassCount* out) {
  while (a != a_end && b != b_end) {
    const std::uint32_t class_a = class_of(*a);
    const std::uint32_t class_b = class_of(*b);
    if (class_a == class_b) {
      *out++ = *a++ + area_of(*b++);
    } else {
      *out++ = class_a < class_b ? *a++ : *b++;
    }
  }
  out = std::copy(a, a_end, out);
  return std::copy(b, b_end, out);
}

// Puts one texel of `id` into an ascending list of `size`; returns the new size.
std::size_t insert_texel(ClassCount* list, std::size_t size, std::uint64_t id) {
  std::size_t at = size;
  while (at > 0 && class_of(list[at - 1]) > id) --at;
  if (at > 0 && class_of(list[at - 1]) == id) {
    ++list[at - 1];
    return size;
  }
  std::copy_backward(list + at, list + size, list + size + 1);
  list[at] = class_count(id, 1);
  return size + 1;
}

struct Ranked {
  std::uint64_t area = 0;
  std::uint32_t id = 0;
};

// The most frequent classes of a texel, the first `ranked` of `best`. Returns the area of all.
std::uint64_t find_most_frequent(std::span<const ClassCount> classes, int ranked, std::array<Ranked, channels::kMostRankedClasses>& best) {
  best = {};
  std::uint64_t total = 0;
  for (const ClassCount count : classes) {
    const std::uint64_t area = area_of(count);
    total += area;
    // Classes come in ascending order: an equal area stays behind the lower class that is there already.
    std::size_t rank = static_cast<std::size_t>(ranked);
    while (rank > 0 && area > best[rank - 1].area) --rank;
    if (rank == static_cast<std::size_t>(ranked)) continue;
    std::copy_backward(best.begin() + static_cast<std::ptrdiff_t>(rank), best.begin() + ranked - 1, best.begin() + ranked);
    best[rank] = {area, class_of(count)};
  }
  return total;
}

}  // namespace

CountRow CountRow::nothing(std::int64_t texels) {
  CountRow row;
  for (std::int64_t i = 0; i < texels; ++i) row.end_texel();
  row.finish();
  return row;
}

void CountRow::begin(std::size_t classes) {
  used_ = 0;
  ends_.assign(2, 0);
  if (entries_.size() < classes) entries_.resize(classes + classes / 4);
}

void CountRow::append(std::span<const ClassCount> classes) {
  if (entries_.size() < used_ + classes.size()) entries_.resize(2 * (used_ + classes.size()));
  std::copy(classes.begin(), classes.end(), next());
  used_ += classes.size();
}

void count_classes(const ClassRow& upper, const ClassRow& lower, std::int64_t start, std::int64_t count, CountRow& out) {
  out.begin(static_cast<std::size_t>(4 * count));
  for (std::int64_t x = start; x < start + 2 * count; x += 2) {
    const std::array<float, 4> id{upper.classes[x], upper.classes[x + 1], lower.classes[x], lower.classes[x + 1]};
    const std::array<float, 4> weight{upper.weights[x], upper.weights[x + 1], lower.weights[x], lower.weights[x + 1]};
    const bool is_one_class = id[0] == id[1] && id[0] == id[2] && id[0] == id[3];
    if (is_one_class && weight[0] + weight[1] + weight[2] + weight[3] == 4.0F) {
      out.add(class_count(static_cast<std::uint32_t>(id[0]), 4));
    } else {
      std::size_t size = 0;
      for (std::size_t i = 0; i < 4; ++i)
        if (weight[i] > 0.0F) size = insert_texel(out.next(), size, static_cast<std::uint32_t>(id[i]));
      out.added(size);
    }
    out.end_texel();
  }
  out.finish();
}

void add_counts(const CountRow& upper, const CountRow& lower, std::int64_t start, std::int64_t count, CountRow& out) {
  out.begin(upper.entry_count() + lower.entry_count());
  const std::uint32_t* u = upper.offsets() + 1 + start;
  const std::uint32_t* l = lower.offsets() + 1 + start;
  std::vector<ClassCount> upper_pair;
  std::vector<ClassCount> lower_pair;
  for (std::int64_t i = 0; i < count; ++i, u += 2, l += 2) {
    const ClassCount* const a = upper.entries() + u[0];
    const ClassCount* const c = lower.entries() + l[0];
    if (u[1] - u[0] == 1 && u[2] - u[0] == 2 && l[1] - l[0] == 1 && l[2] - l[0] == 2) {
      const ClassCount differ = (a[0] ^ a[1]) | (a[0] ^ c[0]) | (a[0] ^ c[1]);
      if (differ >> kAreaBits == 0) {
        out.add(a[0] + area_of(a[1]) + area_of(c[0]) + area_of(c[1]));
        out.end_texel();
        continue;
      }
    }
    upper_pair.resize(std::max<std::size_t>(upper_pair.size(), u[2] - u[0]));
    lower_pair.resize(std::max<std::size_t>(lower_pair.size(), l[2] - l[0]));
    const ClassCount* upper_end = add_lists(a, upper.entries() + u[1], upper.entries() + u[1], upper.entries() + u[2], upper_pair.data());
    const ClassCount* lower_end = add_lists(c, lower.entries() + l[1], lower.entries() + l[1], lower.entries() + l[2], lower_pair.data());
    const ClassCount* end = add_lists(upper_pair.data(), upper_end, lower_pair.data(), lower_end, out.next());
    out.added(static_cast<std::size_t>(end - out.next()));
    out.end_texel();
  }
  out.finish();
}

void count_areas(std::span<const channels::ClassArea> classes, std::uint64_t full_area, std::vector<ClassCount>& out) {
  const auto full = static_cast<double>(full_area);
  std::vector<double> lost;
  double without_data = full;
  std::uint64_t left = full_area;
  const std::size_t first = out.size();
  for (const channels::ClassArea& one : classes) {
    const double exact = std::min(one.area * full, full);
    const auto whole = static_cast<std::uint64_t>(exact);
    out.push_back(class_count(static_cast<std::uint32_t>(one.id), whole));
    lost.push_back(exact - static_cast<double>(whole));
    without_data -= exact;
    left -= std::min(left, whole);
  }
  const double void_area = std::max(0.0, without_data);
  left -= std::min(left, static_cast<std::uint64_t>(void_area));
  lost.push_back(void_area - std::floor(void_area));
  for (; left > 0; --left) {
    const auto most = static_cast<std::size_t>(std::ranges::max_element(lost) - lost.begin());
    if (most < classes.size()) ++out[first + most];
    lost[most] = -1.0;
  }
  std::erase_if(out, [](ClassCount count) { return area_of(count) == 0; });
}

bool rank_classes(const CountRow& row, std::uint64_t full_area, int ranked, const channels::PlaneRow& out) {
  const auto plane = [&](int p) { return out[static_cast<std::size_t>(p)]; };
  const float part_of_full = 1.0F / static_cast<float>(full_area);  // exact: areas of texels are powers of two
  for (int rank = 1; rank < ranked; ++rank) {
    std::fill_n(plane(channels::class_plane(rank)), row.texels(), 0.0F);
    std::fill_n(plane(channels::share_plane(rank)), row.texels(), 0.0F);
  }
  float* const majority = plane(channels::class_plane(0));
  float* const share = plane(channels::share_plane(0));
  float* const weight = plane(channels::kClassWeightPlane);
  bool opaque = true;
  std::array<Ranked, channels::kMostRankedClasses> best;
  for (std::int64_t i = 0; i < row.texels(); ++i) {
    const std::span<const ClassCount> classes = row.texel(i);
    if (classes.size() <= 1) {
      const ClassCount only = classes.empty() ? 0 : classes[0];
      majority[i] = static_cast<float>(class_of(only));
      share[i] = classes.empty() ? 0.0F : 1.0F;
      weight[i] = static_cast<float>(area_of(only)) * part_of_full;
      opaque = opaque && area_of(only) == full_area;
      continue;
    }
    const std::uint64_t total = find_most_frequent(classes, ranked, best);
    for (int rank = 0; rank < ranked; ++rank) {
      const Ranked& here = best[static_cast<std::size_t>(rank)];
      plane(channels::class_plane(rank))[i] = static_cast<float>(here.id);
      plane(channels::share_plane(rank))[i] = static_cast<float>(static_cast<double>(here.area) / static_cast<double>(total));
    }
    weight[i] = static_cast<float>(total) * part_of_full;
    opaque = opaque && total == full_area;
  }
  return opaque;
}

}  // namespace vt::pyramid
