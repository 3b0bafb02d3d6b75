// A file in memory, read-only, and what happens when another program cuts that file off meanwhile.
//
// Touching a part of a mapping that is not in the file any more, or that the disk fails to give, raises
// SIGBUS, which ends the process. After guard_mappings() it does not: the whole mapping turns into zeros, for
// good, and is_lost() says so to whoever has read it. The guard is the process's, so it is the program that
// decides about it and not this library; all our programs do. Threads: any number may read a mapping and ask
// is_lost(); guard_mappings() may be called from any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "store/io/file.h"
#include "store/mapping_guard.h"
#include "store/result.h"

namespace vt::store {

struct MappingWatch;  // what the signal handler knows of one mapping

class Mapping {
 public:
  // Behind the file's bytes lie so many zeros, for whoever follows a number that is wrong by no more than an
  // index page is long.
  static constexpr std::size_t kSlack = std::size_t{32} << 10;

  // The first `bytes` of the file, which has that many.
  [[nodiscard]] static Result<Mapping> map(const File& file, std::uint64_t bytes);
  Mapping() = default;
  Mapping(Mapping&& other) noexcept;
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
  // Tells the system that these bytes are wanted soon, and goes on at once. Offsets inside bytes().
  void read_ahead(std::uint64_t offset, std::uint64_t bytes) const;
  // What was read before this call may be zeros in place of the file. Never true without guard_mappings().
  [[nodiscard]] bool is_lost() const;

 private:
  std::span<const std::byte> bytes_;
  MappingWatch* watch_ = nullptr;
};

}  // namespace vt::store
