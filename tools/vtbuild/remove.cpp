// vtbuild remove: layers go, the others stay as they are.

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "builder/text/names_text.h"
#include "store/format/layout.h"
#include "store/store_writer.h"
#include "tools/vtbuild/build_flags.h"

namespace vt::tools {
namespace {

struct RemoveFlags {
  std::string store;
  std::vector<std::string> layers;
};

std::string names_of(const std::vector<LayerInfo>& layers) { return layers.empty() ? "none" : text::names_text(layers, &LayerInfo::name); }

// Bytes of tiles and of the index's entries. Constants are shared with other layers, so they hardly count.
std::uint64_t garbage_of(const LayerInfo& layer) {
  const std::uint64_t constant = store::aligned(store::kRecordHeaderBytes + format_info(layer.format).block_bytes);
  const std::uint64_t constants = constant * std::min(layer.constant_tiles, layer.tiles);
  return layer.stored_bytes - std::min(layer.stored_bytes, constants) + store::kReferenceBytes * layer.tiles;
}

Result<int> run(const RemoveFlags& flags) {
  VT_ASSIGN(store::StoreWriter writer, store::StoreWriter::open(flags.store));
  print_leftovers(writer.removed_leftovers());
  const std::vector<LayerInfo> before = writer.layers();

  // All names are known before anything goes.
  std::vector<LayerId> wanted;
  for (const std::string& name : flags.layers) {
    const auto layer = writer.find_layer(name);
    if (!layer) return fail(ErrorCode::kUsage, flags.store + ": has no layer '" + name + "'; its layers: " + names_of(before));
    wanted.push_back(layer->id);
  }
  for (const LayerId id : wanted) {
    // A part or a carry layer goes with its owner, perhaps before its own turn comes.
    const auto now = writer.layers();
    if (std::any_of(now.begin(), now.end(), [&](const LayerInfo& layer) { return layer.id == id; })) VT_CHECK(writer.remove_layer(id));
  }
  const std::vector<LayerInfo> left = writer.layers();
  VT_CHECK(writer.finish());

  std::uint64_t garbage = 0;
  for (const LayerInfo& layer : before) {
    if (std::any_of(left.begin(), left.end(), [&](const LayerInfo& other) { return other.id == layer.id; })) continue;
    garbage += garbage_of(layer);
    cli::print(fmt::format("{}: removed layer {}, {} tiles\n", flags.store, layer.name, layer.tiles));
  }
  cli::print(fmt::format("layers left: {}\nabout {} are garbage now; `vtbuild pack {} --keep-carry` frees them\n", names_of(left),
                         cli::format_bytes(garbage), flags.store));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_remove_command(CLI::App& app) {
  auto flags = std::make_shared<RemoveFlags>();
  CLI::App* command = app.add_subcommand("remove", "take layers out of a store; the file gets no shorter until it is packed");
  command->add_option("STORE", flags->store, "the store")->required();
  command
      ->add_option("LAYER", flags->layers, "names of layers, as `vtinspect info` lists them; NAME/carry and the parts of NAME go with NAME")
      ->required();
  cli::add_help_footer(*command,
                       "  vtbuild remove area.vts elevation\n"
                       "  vtbuild remove area.vts color elevation && vtbuild pack area.vts --keep-carry\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::tools
