// What tells a layer that is in a store from what is asked for now, in words for people: the settings in its
// metadata against those of a plan. Pure functions, any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace vt::pipeline {

// The first settings that differ, without the sources: "`kernel`: kaiser3 there, box here". Empty when none
// does.
[[nodiscard]] std::string settings_difference(const nlohmann::ordered_json& there, const nlohmann::ordered_json& here);

// How the lists of sources differ, by the names of files: "changed: a.tif; new: b.tif". Empty when they are
// the same.
[[nodiscard]] std::string source_difference(const nlohmann::ordered_json& there, const nlohmann::ordered_json& here);

}  // namespace vt::pipeline
