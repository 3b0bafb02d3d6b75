#include "builder/text/json_schema.h"

#include <exception>
#include <nlohmann/json.hpp>
#include <utility>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

namespace vt::text {

Result<std::vector<SchemaComplaint>> schema_complaints(const nlohmann::json& document, const nlohmann::json& schema) {
  try {
    valijson::Schema parsed;
    valijson::SchemaParser(valijson::SchemaParser::kDraft7).populateSchema(valijson::adapters::NlohmannJsonAdapter(schema), parsed);
    valijson::ValidationResults results;
    valijson::Validator validator;
    std::vector<SchemaComplaint> complaints;
    if (validator.validate(parsed, valijson::adapters::NlohmannJsonAdapter(document), &results)) return complaints;
    for (valijson::ValidationResults::Error error; results.popError(error);)
      complaints.push_back({std::move(error.context), std::move(error.description)});
    if (complaints.empty()) complaints.push_back({{"<root>"}, "does not follow the schema"});
    return complaints;
  } catch (const std::exception& e) {
    return fail(ErrorCode::kInternal, std::string("the schema could not be applied: ") + e.what());
  }
}

}  // namespace vt::text
