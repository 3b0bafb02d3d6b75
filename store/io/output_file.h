// One file that a program writes for its user: a picture, a GeoTIFF, a table. It gets its name when it is
// whole, durable and closed, in one step; until then the name stays what it was, and whatever goes wrong the
// unfinished file is gone.
//
// The unfinished file lies in the target's folder and has no name at all (O_TMPFILE), so that not even a
// killed program leaves one; where the file system has no such files, it has a random name that nothing else
// had (O_EXCL). It has the owner and the mode of the file that it will replace before its first byte, or
// those that the umask gives to a new one. A target that is a symbolic link is followed: what it points to is
// replaced and the link stays. Two writers of one target write two files; the later one to finish is the one
// that is seen.
//
// A device or a pipe cannot be replaced; it is written to as the bytes come, and only from front to back.
//
// The first failure of a write is kept and comes back from every call after it, finish() included: a library
// that writes through this and passes over its errors cannot turn half a file into a result. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "store/result.h"

namespace vt::store {

class OutputFile {
 public:
  struct Options {
    bool may_be_unnamed = true;  // tests switch O_TMPFILE off
    bool sync = true;            // wait for the disk before the file gets its name
  };

  // kIo: the folder is not there or not writable, the target is a folder, or a pipe that nobody reads.
  [[nodiscard]] static Result<OutputFile> create(const std::filesystem::path& target, const Options& options);
  [[nodiscard]] static Result<OutputFile> create(const std::filesystem::path& target);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  ~OutputFile();  // without finish() the file goes and the target stays as it was

  // After the last byte that was appended.
  [[nodiscard]] Result<void> append(std::span<const std::byte> bytes) { return write_at(end_, bytes); }
  // Anywhere; a gap before `offset` is filled with zeros.
  [[nodiscard]] Result<void> write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  // What was written so far. Returns how many of the bytes there were.
  [[nodiscard]] Result<std::size_t> read_at(std::uint64_t offset, std::span<std::byte> out);
  // One byte past the last.
  [[nodiscard]] std::uint64_t size() const { return end_; }

  // Gives the file its name. kIo: it is not whole, and the target is what it was before; "cannot close" is
  // the exception, after which the target may be either.
  [[nodiscard]] Result<void> finish();

  // The name as the user gave it, for messages.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  // What went wrong first, if anything did.
  [[nodiscard]] const std::optional<Error>& failure() const { return failure_; }

 private:
  OutputFile() = default;
  [[nodiscard]] Result<void> open_stream();
  [[nodiscard]] Result<void> open_beside(const Options& options);
  [[nodiscard]] Result<void> flush();
  [[nodiscard]] Result<void> give_name();
  [[nodiscard]] tl::unexpected<Error> refuse(std::string_view act, int error_number);
  void discard();

  std::filesystem::path path_;
  std::filesystem::path target_;  // path_ with links followed
  std::filesystem::path beside_;  // the unfinished file's name; empty while it has none
  int fd_ = -1;
  bool is_stream_ = false;  // a device or a pipe
  bool sync_ = true;
  std::uint64_t end_ = 0;
  std::vector<std::byte> pending_;  // not yet given to the system
  std::uint64_t pending_at_ = 0;
  std::optional<Error> failure_;
};

// All of a file at once.
[[nodiscard]] Result<void> write_whole_file(const std::filesystem::path& target, std::string_view text);

}  // namespace vt::store
