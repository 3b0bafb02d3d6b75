#include "builder/channels/sensor/symmetric_eigen.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace vt::channels {

// The cyclic Jacobi method, Golub and Van Loan, Matrix Computations, section 8.5.
std::vector<std::vector<double>> leading_eigenvectors(std::vector<double> matrix, std::size_t size, std::size_t count) {
  assert(matrix.size() == size * size && count <= size);
  const auto at = [&](std::size_t row, std::size_t column) -> double& { return matrix[row * size + column]; };
  std::vector<std::vector<double>> vectors(size, std::vector<double>(size, 0.0));
  for (std::size_t i = 0; i < size; ++i) vectors[i][i] = 1.0;

  // Convergence is quadratic; in double it takes eight sweeps or so.
  constexpr int kMostSweeps = 40;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    bool is_diagonal = true;
    for (std::size_t p = 0; p < size; ++p)
      for (std::size_t q = p + 1; q < size; ++q) {
        const double off = at(p, q);
        if (std::abs(off) <= 1e-18 * std::sqrt(std::abs(at(p, p)) * std::abs(at(q, q))) || off == 0.0) continue;
        is_diagonal = false;
        const double theta = (at(q, q) - at(p, p)) / (2.0 * off);
        const double tangent = (theta < 0.0 ? -1.0 : 1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
        const double cosine = 1.0 / std::sqrt(tangent * tangent + 1.0);
        const double sine = tangent * cosine;
        for (std::size_t i = 0; i < size; ++i) {
          const double a = at(i, p);
          const double b = at(i, q);
          at(i, p) = cosine * a - sine * b;
          at(i, q) = sine * a + cosine * b;
        }
        for (std::size_t i = 0; i < size; ++i) {
          const double a = at(p, i);
          const double b = at(q, i);
          at(p, i) = cosine * a - sine * b;
          at(q, i) = sine * a + cosine * b;
          const double u = vectors[p][i];
          const double v = vectors[q][i];
          vectors[p][i] = cosine * u - sine * v;
          vectors[q][i] = sine * u + cosine * v;
        }
        at(p, q) = at(q, p) = 0.0;
      }
    if (is_diagonal) break;
  }

  std::vector<std::size_t> order(size);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return at(a, a) > at(b, b); });
  std::vector<std::vector<double>> leading;
  for (std::size_t k = 0; k < count; ++k) leading.push_back(vectors[order[k]]);
  return leading;
}

}  // namespace vt::channels
