// Where a writer puts its catalogs. Each commit has one, of all layers; if every one were appended to the
// log, a store of many small layers would soon be nothing but old catalogs. So two places take turns: a new
// catalog goes where the one before the last lay, which no superblock reaches any more. A catalog that has
// outgrown its places gets a new one with some space to grow. Leaves writing to its owner. Threads: one at a
// time; the writer's mutex guards it.
#pragma once

#include <cstdint>

#include "store/format/layout.h"
#include "store/io/file.h"
#include "store/result.h"

namespace vt::store {

class CatalogSpace {
 public:
  CatalogSpace() = default;  // of a store without a catalog
  // As the newest superblock of a store says, which both superblocks of the file hold by now.
  explicit CatalogSpace(const Superblock& newest);

  [[nodiscard]] const Extent& current() const { return current_; }
  [[nodiscard]] const Extent& spare() const { return spare_; }

  // Space for a catalog's record of so many bytes: the spare place when it is large enough and `file` has
  // nothing else there. Otherwise offset 0, and the bytes to take at the end of the log.
  [[nodiscard]] Result<Extent> next(std::uint64_t record_bytes, const File& file);
  // The catalog at `place` is going to be that of both superblocks; the one before becomes spare.
  void take(const Extent& place);

 private:
  [[nodiscard]] Result<bool> is_spare_free(const File& file) const;

  Extent current_;
  Extent spare_;
  // What this writer has written or looked at; the rest is what a superblock says.
  bool is_current_known_ = false;
  bool is_spare_known_ = false;
};

}  // namespace vt::store
