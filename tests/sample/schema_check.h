// Validation against schemas/dataset.schema.json, as the builder will do it.
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

namespace vt::sample {

// Empty when the document is valid, otherwise the first complaint.
inline std::string schema_complaint(const nlohmann::json& document) {
  std::ifstream file(VT_SCHEMAS "/dataset.schema.json");
  const nlohmann::json schema_json = nlohmann::json::parse(file);
  valijson::Schema schema;
  valijson::SchemaParser(valijson::SchemaParser::kDraft7).populateSchema(valijson::adapters::NlohmannJsonAdapter(schema_json), schema);
  valijson::ValidationResults results;
  if (valijson::Validator().validate(schema, valijson::adapters::NlohmannJsonAdapter(document), &results)) return "";
  valijson::ValidationResults::Error error;
  std::string text = "invalid";
  while (results.popError(error)) {
    text += ";";
    for (const std::string& part : error.context) text += " " + part;
    text += ": " + error.description;
  }
  return text;
}

}  // namespace vt::sample
