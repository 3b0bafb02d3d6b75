// Eigenvectors of small symmetric matrices by Jacobi's rotations: slow, accurate, and with nothing but sums,
// products, divisions and square roots, so every CPU gets the same bits. Pure function, any thread.
#pragma once

#include <cstddef>
#include <vector>

namespace vt::channels {

// `matrix`: `size` rows of `size` numbers, symmetric and finite. The eigenvectors of its `count` greatest
// eigenvalues, each of length 1, the greatest first; among equals that of the lower column first.
[[nodiscard]] std::vector<std::vector<double>> leading_eigenvectors(std::vector<double> matrix, std::size_t size, std::size_t count);

}  // namespace vt::channels
