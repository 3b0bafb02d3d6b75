// How a store is written, apart from what is in it: one set of options for everything that writes
// (store_writer.h, pack.h).
#pragma once

#include <cstdint>
#include <functional>

#include "store/codec/codec.h"
#include "store/io/file_hook.h"

namespace vt::store {

struct WriterOptions {
  // Called before every write and sync the writer makes. For tests; null in production.
  FileHook before_operation = nullptr;
  // Stands in for the hash by which put() looks for a payload that was written before. For tests, which make
  // different payloads collide; null in production.
  std::function<std::uint64_t(const PayloadView&)> payload_fingerprint = nullptr;
  // false: commits order writes but do not wait for the disk; a power cut may then lose the store (a killed
  // process may not).
  bool sync = true;
};

}  // namespace vt::store
