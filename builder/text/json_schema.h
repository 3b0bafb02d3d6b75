// Documents held against JSON schemas (draft 7), by valijson, which takes a compiler half a minute and is
// therefore compiled here alone. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "store/result.h"

namespace vt::text {

struct SchemaComplaint {
  std::vector<std::string> place;  // from the root: "<root>", "[layers]", "[0]"
  std::string description;
};

// Empty: the document follows the schema. Complaints come from the outside in; outer ones only repeat that
// something inside is wrong. kInternal: the schema is none.
[[nodiscard]] Result<std::vector<SchemaComplaint>> schema_complaints(const nlohmann::json& document, const nlohmann::json& schema);

}  // namespace vt::text
