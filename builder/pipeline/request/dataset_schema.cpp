#include "builder/pipeline/request/dataset_schema.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/request/embedded_schemas.h"
#include "builder/text/json_schema.h"

namespace vt::pipeline {
namespace {

using nlohmann::json;

// "[layers][0][channel]" of the validator as "/layers/0/channel".
std::string json_pointer(const std::vector<std::string>& context) {
  std::string pointer;
  for (const std::string& part : context) {
    if (part == "<root>") continue;
    pointer += '/';
    for (char c : part)
      if (c != '[' && c != ']') pointer += c;
  }
  return pointer.empty() ? "/" : pointer;
}

Result<void> check(const json& document, const json& schema, const std::string& where) {
  auto complaints = text::schema_complaints(document, schema);
  if (!complaints) return fail(complaints.error().code, where + ": " + complaints.error().message);
  if (complaints->empty()) return {};
  // The deepest place is the one that a person can act on.
  const text::SchemaComplaint* deepest = &complaints->front();
  for (const text::SchemaComplaint& complaint : *complaints)
    if (complaint.place.size() >= deepest->place.size()) deepest = &complaint;
  return fail(ErrorCode::kInvalidData, where + ": at " + json_pointer(deepest->place) + ": " + deepest->description +
                                           " See schemas/dataset.schema.json for what is accepted.");
}

// The file's, with the channels that this program was linked with.
json schema_of_this_program() {
  json schema = json::parse(kDatasetSchema);
  json& names = schema["definitions"]["layer"]["properties"]["channel"]["enum"];
  names = json::array();
  for (const channels::ChannelKind* const kind : channels::all_channels()) names.push_back(kind->name);
  return schema;
}

}  // namespace

Result<void> check_against_dataset_schema(const json& document, const std::string& where) {
  return check(document, schema_of_this_program(), where);
}

Result<void> check_against_layer_schema(const json& layer, const std::string& where) {
  // A schema of its own around the same definitions.
  const json all = schema_of_this_program();
  json schema = all["definitions"]["layer"];
  schema["definitions"] = all["definitions"];
  return check(layer, schema, where);
}

}  // namespace vt::pipeline
