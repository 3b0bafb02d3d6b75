// A store file that is written once, from front to back: packing and bulk loading. It is written under
// another name beside its own and gets its own when it is whole and durable, so nobody ever sees half of it;
// if it never comes to that, the file goes away again. Leaves to its user which records there are and where
// references to them lie. Threads: one at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "store/format/catalog.h"
#include "store/format/layout.h"
#include "store/io/file.h"
#include "store/result.h"
#include "store/writer_options.h"

namespace vt::store {

class NewStore {
 public:
  // Begins a file that will be called `path`: where nothing is, or in the place of `replaced`, which outlives
  // it.
  [[nodiscard]] static Result<std::unique_ptr<NewStore>> begin(const std::filesystem::path& path, WriterOptions options = {},
                                                               const File* replaced = nullptr);
  NewStore(const NewStore&) = delete;
  NewStore& operator=(const NewStore&) = delete;
  ~NewStore();  // the file goes, unless it was published

  // Where the next record goes: the end of the log so far.
  [[nodiscard]] std::uint64_t end() const { return end_; }

  // Leaves room at the end, to be filled by write_page() and publish(). A multiple of 64.
  [[nodiscard]] Result<std::uint64_t> reserve(std::uint64_t bytes);
  // Writes an index page into room that was reserved for it, and gives the reference to it.
  [[nodiscard]] Result<Reference> write_page(std::uint64_t offset, std::uint64_t key, std::span<const std::byte> payload);
  // Appends a record.
  [[nodiscard]] Result<Reference> append(RecordType type, std::uint64_t key, std::span<const std::byte> payload);
  // Appends a record that is whole already: asks for the room with `next_record`, fills it, and says so with
  // `keep_record`, which gives its offset. `bytes` are header and payload, the same in both calls.
  [[nodiscard]] Result<std::span<std::byte>> next_record(std::uint64_t bytes);
  std::uint64_t keep_record(std::uint64_t bytes);

  // How much room the record of a catalog takes.
  [[nodiscard]] static Result<std::uint64_t> catalog_room(const Catalog& catalog);

  struct Seal {
    Uuid uuid = {};
    std::uint64_t generation = 0;  // the older superblock's; the newer one says one more. Both hold the same state
    std::uint64_t catalog_at = 0;  // reserved, catalog_room() long
    Extent cold_start = {};
  };
  // Writes catalog and superblocks, makes all of it durable, and gives the file its name. kExists when
  // another file has it by now.
  [[nodiscard]] Result<void> publish(const Catalog& catalog, const Seal& seal);

 private:
  NewStore() = default;
  [[nodiscard]] Result<void> write_buffer(std::size_t bytes);  // from its front

  std::filesystem::path path_;
  WriterOptions options_;
  const File* replaced_ = nullptr;
  File file_;
  bool is_published_ = false;
  std::uint64_t end_ = kLogStart;
  std::vector<std::byte> buffer_;        // records on their way to the file...
  std::size_t buffered_ = 0;             // ...of which so many bytes are filled...
  std::uint64_t buffer_at_ = kLogStart;  // ...and belong here
};

}  // namespace vt::store
