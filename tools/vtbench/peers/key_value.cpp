#include "tools/vtbench/peers/key_value.h"

#include <utility>

namespace vt::bench {

std::vector<std::unique_ptr<KeyValueStore>> key_value_stores() {
  std::vector<std::unique_ptr<KeyValueStore>> stores;
  for (auto* make : {make_lmdb, make_sqlite})
    if (auto made = make()) stores.push_back(std::move(made));
  return stores;
}

}  // namespace vt::bench
