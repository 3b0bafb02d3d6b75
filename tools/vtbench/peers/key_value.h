// Key-value stores to measure beside our index: the same keys with 16 bytes each, the size of an entry. Which
// there are is decided when the program is built; each stays in its own file behind this interface. Threads:
// one at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "store/result.h"

namespace vt::bench {

// Gives keys in ascending order, one a call of the function it gets, until there are no more.
using KeySource = std::function<Result<void>(const std::function<Result<void>(std::uint64_t key)>& take)>;

class KeyValueStore {
 public:
  virtual ~KeyValueStore() = default;
  [[nodiscard]] virtual std::string name() const = 0;  // with its version
  // Makes a new database in `folder`, loaded in the way that suits it best, and opens it for reading. `bytes`
  // is about what it will take.
  [[nodiscard]] virtual Result<void> load(const std::filesystem::path& folder, std::uint64_t bytes, const KeySource& keys) = 0;
  // Whether the key is there with its value, which is touched.
  [[nodiscard]] virtual Result<bool> get(std::uint64_t key) = 0;
};

[[nodiscard]] std::vector<std::unique_ptr<KeyValueStore>> key_value_stores();

// Null when the program was built without it.
[[nodiscard]] std::unique_ptr<KeyValueStore> make_lmdb();
[[nodiscard]] std::unique_ptr<KeyValueStore> make_sqlite();

}  // namespace vt::bench
