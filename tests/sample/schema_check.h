// Validation against schemas/dataset.schema.json, as the builder will do it.
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "builder/text/json_schema.h"

namespace vt::sample {

// Empty when the document is valid, otherwise the first complaint.
inline std::string schema_complaint(const nlohmann::json& document) {
  std::ifstream file(VT_SCHEMAS "/dataset.schema.json");
  const nlohmann::json schema_json = nlohmann::json::parse(file);
  const auto complaints = text::schema_complaints(document, schema_json);
  if (!complaints) return complaints.error().message;
  if (complaints->empty()) return "";
  std::string text = "invalid";
  for (const text::SchemaComplaint& complaint : *complaints) {
    text += ";";
    for (const std::string& part : complaint.place) text += " " + part;
    text += ": " + complaint.description;
  }
  return text;
}

}  // namespace vt::sample
