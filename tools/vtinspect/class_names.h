// The classes of a material layer as its metadata list them (schemas/store-metadata.schema.json), for
// programs that print and draw them. Metadata may be anything: what is not there or not as it should be is
// left out. Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "store/layer.h"

namespace vt::inspect {

struct ClassInfo {
  std::string name;
  std::optional<std::array<std::uint8_t, 3>> color;  // red, green, blue
};

struct ClassTable {
  std::map<int, ClassInfo> classes;  // by id
  std::optional<int> no_data;        // the code that is no class

  // The name of a texel's code: the class's name, "no data", or "" when the table does not know it.
  [[nodiscard]] std::string name_of(int code) const;
  // The class's colour; grey of the code's lowest 8 bits for classes without one. nullopt: no data.
  [[nodiscard]] std::optional<std::array<std::uint8_t, 3>> color_of(int code) const;
  [[nodiscard]] bool has_colors() const;
  // The first classes on one line, "1 water, 3 rock, 7 road, and 12 more"; "" when there are none.
  [[nodiscard]] std::string summary() const;
};

// Empty for layers of other channels, and for layers that were given no table.
[[nodiscard]] ClassTable class_table_of(const LayerInfo& layer);

}  // namespace vt::inspect
