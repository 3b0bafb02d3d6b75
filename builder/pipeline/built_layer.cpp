#include "builder/pipeline/built_layer.h"

namespace vt::pipeline {
namespace {

using Json = nlohmann::ordered_json;

std::string carry_name(const std::string& layer) { return layer + "/carry"; }

// Between the checkpoints of an update.
constexpr const char* kUpdating = "updating";

std::string metadata_of(const LayerPlan& plan, int block_levels, bool updating) {
  Json metadata;
  metadata["settings"] = plan.settings;
  metadata["block_levels"] = block_levels;
  if (!plan.recipe.is_null()) metadata["recipe"] = plan.recipe;
  if (updating) metadata[kUpdating] = true;
  return metadata.dump();
}

Json without_sources(Json settings) {
  settings.erase("sources");
  return settings;
}

bool has_carry(const LayerPlan& plan, int block_levels) { return plan.info.finest.value >= block_levels; }

// A layer that only this layer's builds read, or an error that says that there is none.
Result<LayerId> find_helper(const store::StoreWriter& writer, const LayerPlan& plan, LayerId texture, const std::string& name) {
  const auto layer = writer.find_layer(name);
  if (!layer || layer->role != LayerRole::kCarry || layer->owner != texture)
    return fail(ErrorCode::kInvalidData,
                "layer '" + plan.info.name + "' cannot be built further or updated: its working state '" + name +
                    "' is not in the store (packing leaves it out unless told to keep it); remove the layer and build it again");
  return layer->id;
}

Result<BuiltLayer> open_existing(const store::StoreWriter& writer, const LayerPlan& plan, const LayerInfo& existing,
                                 bool may_differ_in_sources) {
  BuiltLayer layer;
  layer.was_there = true;
  const auto metadata = Json::parse(existing.metadata_json, nullptr, false);
  const bool is_ours = metadata.is_object() && metadata.contains("settings") && metadata["settings"].is_object() &&
                       metadata.contains("block_levels") && metadata["block_levels"].is_number_integer();
  if (!is_ours || without_sources(metadata["settings"]) != without_sources(plan.settings))
    return fail(ErrorCode::kExists, "the store already has a layer '" + plan.info.name +
                                        "' that was built with other settings; remove it, or choose another --name or another store");
  layer.sources_differ = metadata["settings"] != plan.settings;
  if (layer.sources_differ && !may_differ_in_sources)
    return fail(ErrorCode::kExists, "the store already has a layer '" + plan.info.name +
                                        "' that was built from other sources, or they have changed since; update it (--update), or "
                                        "choose another --name or another store");
  layer.ids.texture = existing.id;
  layer.is_complete = existing.state == LayerState::kComplete;
  layer.is_updating = metadata.contains(kUpdating);
  layer.block_levels = metadata["block_levels"].get<int>();
  if (layer.block_levels < 1 || layer.block_levels > kMaxTileExponent)
    return fail(ErrorCode::kInvalidData, "layer '" + plan.info.name + "': its metadata say block_levels " +
                                             std::to_string(layer.block_levels) + ", 1 to 12 are possible");
  if (layer.is_complete && !may_differ_in_sources) return layer;
  VT_ASSIGN(layer.ids.marks, find_helper(writer, plan, existing.id, BlockMarks::describe(plan, layer.block_levels).name));
  if (has_carry(plan, layer.block_levels)) {
    VT_ASSIGN(layer.ids.carry, find_helper(writer, plan, existing.id, carry_name(plan.info.name)));
  }
  return layer;
}

}  // namespace

Result<BuiltLayer> open_built_layer(store::StoreWriter& writer, const LayerPlan& plan, int block_levels, bool may_differ_in_sources) {
  if (const auto existing = writer.find_layer(plan.info.name)) return open_existing(writer, plan, *existing, may_differ_in_sources);

  BuiltLayer layer;
  layer.block_levels = block_levels;
  LayerInfo info = plan.info;
  info.metadata_json = metadata_of(plan, block_levels, false);
  VT_ASSIGN(layer.ids.texture, writer.add_layer(info));
  LayerInfo marks = BlockMarks::describe(plan, block_levels);
  marks.owner = layer.ids.texture;
  VT_ASSIGN(layer.ids.marks, writer.add_layer(marks));
  if (has_carry(plan, block_levels)) {
    LayerInfo carry = plan.info;
    carry.name = carry_name(plan.info.name);
    carry.role = LayerRole::kCarry;
    carry.owner = layer.ids.texture;
    carry.format = plan.sampler->codec().carry_format();
    carry.transfer = Transfer::kLinear;
    carry.metadata_json = "{}";
    VT_ASSIGN(layer.ids.carry, writer.add_layer(carry));
  }
  // From here on the same command finds its layers again.
  VT_CHECK(writer.commit());
  return layer;
}

Result<void> begin_update(store::StoreWriter& writer, const LayerPlan& plan, BuiltLayer& layer) {
  VT_CHECK(writer.set_metadata(layer.ids.texture, metadata_of(plan, layer.block_levels, true)));
  VT_CHECK(writer.set_state(layer.ids.texture, LayerState::kBuilding));
  layer.is_complete = false;
  layer.is_updating = true;
  return {};
}

Result<void> complete(store::StoreWriter& writer, const LayerPlan& plan, const BuiltLayer& layer) {
  if (layer.is_updating) VT_CHECK(writer.set_metadata(layer.ids.texture, metadata_of(plan, layer.block_levels, false)));
  VT_CHECK(writer.set_state(layer.ids.texture, LayerState::kComplete));
  VT_CHECK(writer.set_state(layer.ids.marks, LayerState::kComplete));
  if (has_carry(plan, layer.block_levels)) VT_CHECK(writer.set_state(layer.ids.carry, LayerState::kComplete));
  return writer.commit();
}

}  // namespace vt::pipeline
