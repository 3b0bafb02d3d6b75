// What the sources of a build hold open together: a bounded number of descriptors and of idle decoders,
// whatever the number of files. Any number of threads and files.
#pragma once

#include <cstddef>
#include <list>
#include <mutex>

#include "builder/source/files/reader_pool.h"
#include "store/result.h"

namespace vt::source {

class FileBytes;

class FilePool {
 public:
  static constexpr std::size_t kMostIdleReaders = 32;  // some of them hold a descriptor of their own

  // 0: as many as default_limit() says.
  explicit FilePool(std::size_t most_descriptors = 0);
  FilePool(const FilePool&) = delete;
  FilePool& operator=(const FilePool&) = delete;
  ~FilePool() = default;

  // 256, or a quarter of the process's own limit where that is less: other parts of the program open files
  // too.
  [[nodiscard]] static std::size_t default_limit();
  [[nodiscard]] std::size_t open_descriptors() const;  // now; threads in the middle of a read may push it above the limit
  [[nodiscard]] ReaderPool& readers() { return readers_; }

 private:
  friend class FileBytes;

  // The descriptor of one file; lies in its FileBytes, guarded by mutex_.
  struct Slot {
    int descriptor = -1;
    int users = 0;                        // threads reading from it
    std::list<Slot*>::iterator age = {};  // while it is open
  };
  // Counts the caller among the users. -1: the file is not open.
  [[nodiscard]] int acquire(Slot& slot);
  // The file has been opened for the caller, who becomes a user; another thread may have been faster. Returns
  // the descriptor to use.
  [[nodiscard]] int adopt(Slot& slot, int descriptor);
  void release(Slot& slot);
  void forget(Slot& slot);
  void close_all_idle();

  const std::size_t most_descriptors_;
  mutable std::mutex mutex_;
  std::list<Slot*> by_age_;  // most recent first; open ones only
  ReaderPool readers_;
};

}  // namespace vt::source
