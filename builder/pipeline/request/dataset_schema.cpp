#include "builder/pipeline/request/dataset_schema.h"

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>
#include <vector>

#include "builder/pipeline/request/embedded_schemas.h"

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

Result<void> check(const json& document, const json& schema_document, const std::string& where) {
  try {
    valijson::Schema schema;
    valijson::SchemaParser(valijson::SchemaParser::kDraft7)
        .populateSchema(valijson::adapters::NlohmannJsonAdapter(schema_document), schema);
    valijson::ValidationResults results;
    valijson::Validator validator;
    if (validator.validate(schema, valijson::adapters::NlohmannJsonAdapter(document), &results)) return {};
    // The deepest place is the one that a person can act on; outer ones only repeat that something inside is
    // wrong.
    valijson::ValidationResults::Error error;
    valijson::ValidationResults::Error deepest;
    while (results.popError(error))
      if (error.context.size() >= deepest.context.size()) deepest = error;
    return fail(ErrorCode::kInvalidData, where + ": at " + json_pointer(deepest.context) + ": " + deepest.description +
                                             " See schemas/dataset.schema.json for what is accepted.");
  } catch (const std::exception& e) {
    return fail(ErrorCode::kInternal, where + ": the dataset schema could not be applied: " + e.what());
  }
}

}  // namespace

Result<void> check_against_dataset_schema(const json& document, const std::string& where) {
  return check(document, json::parse(kDatasetSchema), where);
}

Result<void> check_against_layer_schema(const json& layer, const std::string& where) {
  // A schema of its own around the same definitions.
  const json all = json::parse(kDatasetSchema);
  json schema = all["definitions"]["layer"];
  schema["definitions"] = all["definitions"];
  return check(layer, schema, where);
}

}  // namespace vt::pipeline
