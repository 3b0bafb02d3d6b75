// One open file: positioned reads and writes that finish or fail, locking, syncing. Leaves what the bytes
// mean to layout.h. Threads: read_at and write_at may be called from many at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "store/io/file_hook.h"
#include "store/result.h"

namespace vt::store {

class File {
 public:
  enum class Mode {
    kRead,
    kReadWrite,
    kCreate,         // also read; fails with kExists when the name is taken, by a link too
    kCreatePrivate,  // the same, for its owner only
  };
  // kNotFound is reported as kIo: to the user a missing file is the disk's answer.
  // The descriptor is never 0 to 2, also when the process has closed its standard streams.
  [[nodiscard]] static Result<File> open(const std::filesystem::path& path, Mode mode);
  File() = default;
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  ~File();

  // Not owned; null for none.
  void set_hook(const FileHook* hook) { hook_ = hook; }
  void set_name(std::filesystem::path path) { path_ = std::move(path); }  // after a rename, for messages
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] int descriptor() const { return fd_; }

  [[nodiscard]] Result<std::uint64_t> size() const;
  // kIo also when the file ends before `out` is full.
  [[nodiscard]] Result<void> read_at(std::uint64_t offset, std::span<std::byte> out) const;
  // Two pieces, one after the other, then zeros up to a multiple of `alignment`.
  [[nodiscard]] Result<void> write_at(std::uint64_t offset, std::span<const std::byte> first, std::span<const std::byte> second = {},
                                      std::size_t alignment = 1);
  [[nodiscard]] Result<void> sync();
  // Asks the system to begin writing this part to the disk, so that a later sync finds less to wait for. A
  // hint: does not wait for the disk (unless its queue is full) and cannot fail.
  void start_writeback(std::uint64_t offset, std::uint64_t bytes) const;
  [[nodiscard]] Result<void> truncate(std::uint64_t bytes);
  // False when another process (or another descriptor of this one) holds the lock.
  [[nodiscard]] Result<bool> try_lock();
  // False when path() names another file by now, or nothing: something was put in the place of this one after
  // it was opened.
  [[nodiscard]] Result<bool> still_named() const { return is_at(path_); }
  [[nodiscard]] Result<bool> is_at(const std::filesystem::path& path) const;
  // Removes path() where it still names this file: another that took the name meanwhile, or was given it, is
  // nobody's to remove. For a file that is given up; what fails leaves a leftover.
  void remove_own_name() const;
  // Owner, group and permissions become those of `other`; kIo when they cannot.
  [[nodiscard]] Result<void> take_owner_and_mode_of(const File& other);
  [[nodiscard]] Result<void> close();

 private:
  [[nodiscard]] tl::unexpected<Error> refuse(const char* act, int error_number) const;
  [[nodiscard]] int ask_hook(FileOperation::Kind kind, std::uint64_t offset, std::span<const std::byte> bytes) const;

  int fd_ = -1;
  std::filesystem::path path_;
  const FileHook* hook_ = nullptr;
};

// Renames without ever replacing something (kExists), and makes the new name durable when `sync`.
[[nodiscard]] Result<void> rename_into_place(const std::filesystem::path& from, const std::filesystem::path& to, bool sync);
// The same, in the place of `replaced`, which `to` names. Who has that one open keeps it. kExists when `to`
// names another file by now; then nothing is changed.
[[nodiscard]] Result<void> replace_file(const std::filesystem::path& from, const std::filesystem::path& to, const File& replaced,
                                        bool sync);

}  // namespace vt::store
