#include "tools/cli/open_store.h"

#include "tools/cli/cli_support.h"

namespace vt::cli {

Result<store::StoreReader> open_store(std::string_view program, const std::filesystem::path& path) {
  auto reader = store::StoreReader::open(path);
  if (reader && reader->health() == store::StoreHealth::kMayBeOlder) print_note(program, path.string() + ": " + reader->health_remark());
  return reader;
}

std::string_view health_name(store::StoreHealth health) {
  switch (health) {
    case store::StoreHealth::kWhole:
      return "whole";
    case store::StoreHealth::kOneSuperblock:
      return "one superblock";
    case store::StoreHealth::kMayBeOlder:
      return "may be older";
  }
  return "";
}

}  // namespace vt::cli
