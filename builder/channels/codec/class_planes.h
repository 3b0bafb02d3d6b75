// What the planes of a layer of classes hold. Classes are names, not amounts: they are never averaged. The
// source planes are the class and the weight (1, or 0 without data); the planes of a coarser texel tell of
// its most frequent classes, which ClassCascade (builder/pyramid/class_cascade.h) finds by counting.
// Arithmetic only, any thread.
#pragma once

namespace vt::channels {

inline constexpr int kMostRankedClasses = 4;
// The greatest number that a class can have in any layer: planes hold it exactly, and so do counts of classes
// (builder/pyramid/class_counts.h).
inline constexpr int kGreatestClass = 65535;
static_assert(kGreatestClass <= 1 << 24, "planes are floats");

struct ClassCounting {
  int ranked = 1;      // how many classes the planes tell of, the most frequent first; 1 to kMostRankedClasses
  int greatest = 255;  // classes are 0 to this, without no_data
  int no_data = 255;   // what is stored where there are no data; no class may be it
};

inline constexpr int kClassWeightPlane = 1;

// The class of rank `rank` (0 = most frequent), and its share of the area that has data, 0 to 1. A rank that
// no class has is class 0 with share 0. The class of rank 0 is the first source plane.
[[nodiscard]] constexpr int class_plane(int rank) { return rank == 0 ? 0 : 2 * rank + 1; }
[[nodiscard]] constexpr int share_plane(int rank) { return 2 * rank + 2; }
[[nodiscard]] constexpr int class_planes(int ranked) { return 2 * ranked + 1; }

}  // namespace vt::channels
