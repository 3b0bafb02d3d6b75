#include "builder/pipeline/blocks/built_layer.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "builder/pipeline/blocks/block_marks.h"
#include "builder/pipeline/blocks/block_quality.h"
#include "builder/pipeline/plan/build_state.h"
#include "builder/pipeline/plan/settings_difference.h"
#include "builder/text/json_text.h"

namespace vt::pipeline {
namespace {

using Json = nlohmann::ordered_json;

std::string carry_name(const std::string& layer) { return layer + "/carry"; }

// Members of a layer's metadata that are the builder's; a channel's have other names.
constexpr std::array kOwnMembers = std::to_array<const char*>(
    {"components", "unit", "periodic", "settings", "block_levels", "recipe", kUpdating, kFailed, "quality", "losses", "alpha_coverage"});

// What the numbers of a part are, in the words of its channel.
Json values_of(const LayerPlan& plan, std::size_t part) {
  Json values = text::json_or_null(plan.part(part).metadata_json);
  assert(std::ranges::none_of(kOwnMembers, [&](const char* member) { return values.contains(member); }));
  values["components"] = plan.part(part).components;
  values["unit"] = plan.part(part).unit;  // also when it has none: the channel's own would be wrong then
  if (plan.is_closed) values["periodic"] = "x";
  return values;
}

// `updating` is null for a layer that is not.
std::string metadata_of(const LayerPlan& plan, int block_levels, const Json& updating, const Json& quality = {}, const Json& losses = {},
                        const Json& alpha_coverage = {}) {
  Json metadata = values_of(plan, 0);
  metadata["settings"] = plan.settings;
  metadata["block_levels"] = block_levels;
  if (!plan.recipe.is_null()) metadata["recipe"] = plan.recipe;
  if (!updating.is_null()) metadata[kUpdating] = updating;
  if (!quality.is_null()) metadata["quality"] = quality;
  if (!losses.is_null()) metadata["losses"] = losses;
  if (!alpha_coverage.is_null()) metadata["alpha_coverage"] = alpha_coverage;
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

// A tile of carry is one record of the store. (Counts of classes take what they take.)
Result<void> check_carry_size(const LayerPlan& plan) {
  const std::uint64_t texels = std::uint64_t{plan.info.tile_texels()} * plan.info.tile_texels();
  const std::uint64_t bytes = texels * static_cast<std::uint64_t>(plan.codec->planes()) * sizeof(float);
  if (bytes <= store::kMaxRawBytes) return {};
  return fail(ErrorCode::kUsage, "layer '" + plan.info.name + "' has " + std::to_string(plan.codec->planes()) +
                                     " numbers a texel, which is too much for tiles of " + std::to_string(plan.info.tile_texels()) +
                                     "; use a smaller `tile`");
}

// A layer that was never finished is in nobody's way: what an interrupted build has come to is kept for the
// command that began it, but a build that came to nothing, or cannot come to its end, gives way to the next
// one.
Result<bool> gives_way(const store::StoreWriter& writer, const LayerPlan& plan, const LayerInfo& existing, const BuildState& state) {
  if (!state.is_ours || state.was_complete) return false;
  if (without_sources(state.settings) == without_sources(plan.settings)) return false;
  if (state.has_failed) return true;
  const auto marks = writer.find_layer(BlockMarks::describe(plan, 1).name);
  if (!marks || marks->role != LayerRole::kCarry || marks->owner != existing.id) return false;
  VT_ASSIGN(const bool has_built, BlockMarks::any_built(writer, *marks));
  return !has_built;
}

// Why a layer that is there cannot be gone on with.
std::string other_settings(const LayerPlan& plan, const BuildState& state) {
  const std::string difference = state.is_ours ? " (" + settings_difference(state.settings, plan.settings) + ")" : std::string();
  if (state.is_ours && !state.was_complete)
    return "the store has an unfinished layer '" + plan.info.name + "' that was begun with other settings" + difference +
           "; finish it by the command that began it, remove the layer, or choose another `name` or another store";
  return "the store already has a layer '" + plan.info.name + "' that was built with other settings" + difference +
         "; remove the layer, or choose another `name` or another store";
}

Result<BuiltLayer> open_existing(const store::StoreWriter& writer, const LayerPlan& plan, const LayerInfo& existing,
                                 const BuildState& state, bool may_differ_in_sources) {
  BuiltLayer layer;
  layer.was_there = true;
  if (!state.is_ours || without_sources(state.settings) != without_sources(plan.settings))
    return fail(ErrorCode::kExists, other_settings(plan, state));
  layer.was_complete = state.was_complete;
  layer.sources_differ = state.settings != plan.settings;
  if (layer.sources_differ && !may_differ_in_sources && state.was_complete)
    return fail(ErrorCode::kExists, "the store already has a layer '" + plan.info.name +
                                        "' that was built from other sources, or they have changed since; update it (`update`), or "
                                        "choose another `name` or another store");
  if (layer.sources_differ && !may_differ_in_sources)
    layer.remark =
        "layer '" + plan.info.name + "' was never finished, and its sources have changed since; what was built of it is compared with them";
  for (const LayerInfo& part : plan.parts) {
    const auto found = writer.find_layer(part.name);
    if (!found || found->role != LayerRole::kTexture || (found->id != existing.id && (!found->is_part || found->owner != existing.id)))
      return fail(ErrorCode::kInvalidData, "layer '" + plan.info.name + "' cannot be built further: its part '" + part.name +
                                               "' is not in the store; remove the layer and build it again");
    layer.ids.parts.push_back(found->id);
  }
  layer.is_complete = existing.state == LayerState::kComplete;
  layer.is_updating = state.is_updating;
  layer.block_levels = state.block_levels;
  if (layer.block_levels < 1 || layer.block_levels > kMaxTileExponent)
    return fail(ErrorCode::kInvalidData, "layer '" + plan.info.name + "': its metadata say block_levels " +
                                             std::to_string(layer.block_levels) + ", 1 to 12 are possible");
  if (layer.is_complete && !may_differ_in_sources) return layer;
  VT_ASSIGN(layer.ids.marks, find_helper(writer, plan, existing.id, BlockMarks::describe(plan, layer.block_levels).name));
  VT_ASSIGN(layer.ids.quality, find_helper(writer, plan, existing.id, describe_quality(plan, layer.block_levels).name));
  if (has_carry(plan, layer.block_levels)) {
    VT_ASSIGN(layer.ids.carry, find_helper(writer, plan, existing.id, carry_name(plan.info.name)));
  }
  return layer;
}

}  // namespace

Result<BuiltLayer> open_built_layer(store::StoreWriter& writer, const LayerPlan& plan, int block_levels, bool may_differ_in_sources) {
  BuiltLayer layer;
  if (const auto existing = writer.find_layer(plan.info.name)) {
    const BuildState state = state_of(*existing);
    VT_ASSIGN(const bool makes_place, gives_way(writer, plan, *existing, state));
    if (!makes_place) return open_existing(writer, plan, *existing, state, may_differ_in_sources);
    layer.remark = "layer '" + plan.info.name + "' was begun with other settings and " +
                   (state.has_failed ? "could not be finished" : "never came to anything") + "; it is built anew";
    VT_CHECK(writer.remove_layer(existing->id));
  }

  if (has_carry(plan, block_levels)) VT_CHECK(check_carry_size(plan));
  layer.block_levels = block_levels;
  for (std::size_t i = 0; i < plan.parts.size(); ++i) {
    LayerInfo info = plan.parts[i];
    info.is_part = i > 0;
    if (info.is_part) info.owner = layer.ids.texture();
    info.metadata_json = i == 0 ? metadata_of(plan, block_levels, nullptr) : values_of(plan, i).dump();
    VT_ASSIGN(const LayerId id, writer.add_layer(info));
    layer.ids.parts.push_back(id);
  }
  LayerInfo marks = BlockMarks::describe(plan, block_levels);
  marks.owner = layer.ids.texture();
  VT_ASSIGN(layer.ids.marks, writer.add_layer(marks));
  LayerInfo quality = describe_quality(plan, block_levels);
  quality.owner = layer.ids.texture();
  VT_ASSIGN(layer.ids.quality, writer.add_layer(quality));
  if (has_carry(plan, block_levels)) {
    LayerInfo carry = plan.info;
    carry.name = carry_name(plan.info.name);
    carry.role = LayerRole::kCarry;
    carry.owner = layer.ids.texture();
    carry.format = TexelFormat::kBlob;
    carry.transfer = Transfer::kLinear;
    carry.components = {};
    carry.zero_is_nodata = false;
    carry.is_point_sampled = false;
    carry.metadata_json = "{}";
    VT_ASSIGN(layer.ids.carry, writer.add_layer(carry));
  }
  // From here on the same command finds its layers again.
  VT_CHECK(writer.commit());
  return layer;
}

Result<void> begin_update(store::StoreWriter& writer, const LayerPlan& plan, BuiltLayer& layer) {
  VT_CHECK(writer.set_metadata(layer.ids.texture(), metadata_of(plan, layer.block_levels, layer.was_complete)));
  for (const LayerId part : layer.ids.parts) VT_CHECK(writer.set_state(part, LayerState::kBuilding));
  layer.is_complete = false;
  layer.is_updating = true;
  return {};
}

Result<void> note_failure(store::StoreWriter& writer, const BuiltLayer& layer, bool has_failed) {
  if (layer.was_complete) return {};
  const auto layers = writer.layers();
  const auto info = std::ranges::find(layers, layer.ids.texture(), &LayerInfo::id);
  if (info == layers.end()) return {};
  Json metadata = text::json_or_null(info->metadata_json);
  if (!metadata.is_object() || metadata.contains(kFailed) == has_failed) return {};
  if (has_failed) {
    metadata[kFailed] = true;
  } else {
    metadata.erase(kFailed);
  }
  return writer.set_metadata(info->id, metadata.dump());
}

Result<bool> holds_built_work(const store::StoreWriter& writer) {
  for (const LayerInfo& layer : writer.layers()) {
    if (layer.role == LayerRole::kTexture && was_ever_complete(layer)) return true;
    VT_ASSIGN(const bool has_built, BlockMarks::any_built(writer, layer));
    if (has_built) return true;
  }
  return false;
}

Result<std::vector<std::string>> complete(store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work, const BuiltLayer& layer,
                                          const PassFindings& findings) {
  VT_ASSIGN(const LayerQuality measured, collect_quality(writer, plan, work, layer.ids.quality));
  Json quality = quality_json(plan, measured.levels);
  if (!findings.surface.is_null()) quality.push_back(findings.surface);
  VT_CHECK(writer.set_metadata(layer.ids.texture(), metadata_of(plan, layer.block_levels, nullptr, quality,
                                                                losses_json(plan, measured.losses), findings.alpha_coverage)));
  for (const LayerId part : layer.ids.parts) VT_CHECK(writer.set_state(part, LayerState::kComplete));
  VT_CHECK(writer.set_state(layer.ids.marks, LayerState::kComplete));
  VT_CHECK(writer.set_state(layer.ids.quality, LayerState::kComplete));
  if (has_carry(plan, layer.block_levels)) VT_CHECK(writer.set_state(layer.ids.carry, LayerState::kComplete));
  VT_CHECK(writer.commit());
  std::vector<std::string> remarks = loss_remarks(plan, measured.losses);
  for (std::string& remark : light_remarks(plan, measured.levels)) remarks.push_back(std::move(remark));
  return remarks;
}

}  // namespace vt::pipeline
