// vtbench lookup: how long a reader takes to find a tile in the index, and to hand out its texels.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <random>

#include "builder/encode/bc1_encoder.h"
#include "builder/sample/painter.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "tools/bench_commands.h"
#include "tools/bench_support.h"
#include "tools/cli_support.h"

namespace vt::bench {
namespace {

struct LookupFlags {
  std::uint64_t tiles = 1000000;
  int runs = 9;
  std::string scratch;
  ResultFlags results;
};

constexpr std::uint8_t kTileExponent = 8;
constexpr std::uint32_t kPaintedSide = 8;  // painted tiles along an edge: 64 of them are 12 MiB of RGB

LayerInfo square_layer(std::string name, TexelFormat format, std::uint8_t finest) {
  LayerInfo layer;
  layer.name = std::move(name);
  layer.format = format;
  layer.transfer = Transfer::kSrgb;
  layer.tile_exponent = kTileExponent;
  layer.finest = Level{finest};
  const std::int64_t edge = std::int64_t{1} << (finest + kTileExponent);
  layer.data = {0, 0, edge, edge};
  return layer;
}

struct PaintedLayer {
  std::string name;
  TexelFormat format;
  std::string compression;
};
const std::vector<PaintedLayer>& painted_layers() {
  static const std::vector<PaintedLayer> layers = {
      {"rgb8 none", TexelFormat::kRgb8, "none"},
      {"rgb8 zstd:3", TexelFormat::kRgb8, "zstd:3"},
      {"bc1 none", TexelFormat::kBc1, "none"},
      {"bc1 zstd:3", TexelFormat::kBc1, "zstd:3"},
  };
  return layers;
}

// The level that has room for `tiles` tiles.
std::uint8_t level_for(std::uint64_t tiles) {
  std::uint8_t level = 0;
  while ((std::uint64_t{1} << (2 * level)) < tiles) ++level;
  return level;
}

Result<void> fill_store(store::StoreWriter& writer, std::uint64_t tiles) {
  // A large index of constant tiles: what is measured is finding them, so what they hold does not matter.
  const std::uint8_t finest = level_for(tiles);
  VT_ASSIGN(const LayerId index, writer.add_layer(square_layer("index", TexelFormat::kRgb8, finest)));
  for (std::uint64_t i = 0; i < tiles; ++i) {
    const TileId tile{Level{finest}, static_cast<std::uint32_t>(i & ((std::uint64_t{1} << finest) - 1)),
                      static_cast<std::uint32_t>(i >> finest)};
    const std::array<std::byte, 3> texel = {static_cast<std::byte>(i % 7), std::byte{1}, std::byte{2}};
    VT_CHECK(writer.put_constant(index, tile, texel));
    if (i % 65536 == 0) VT_CHECK(check_interrupt());
  }

  // Few tiles, but real pictures, so that decompression has its real work.
  const sample::World world(1);
  sample::Painter painter(world);
  const auto square = std::make_unique<sample::Square>();
  static_assert(sample::kSquare == 1 << kTileExponent);
  std::vector<LayerId> ids;
  for (const PaintedLayer& layer : painted_layers()) {
    VT_ASSIGN(const LayerId id, writer.add_layer(square_layer(layer.name, layer.format, level_for(kPaintedSide * kPaintedSide))));
    ids.push_back(id);
  }
  for (std::uint32_t y = 0; y < kPaintedSide; ++y)
    for (std::uint32_t x = 0; x < kPaintedSide; ++x) {
      painter.paint(std::int64_t{x} * sample::kSquare, std::int64_t{y} * sample::kSquare, *square);
      const auto rgb = std::as_bytes(std::span(square->rgb));
      for (std::size_t l = 0; l < ids.size(); ++l) {
        const PaintedLayer& layer = painted_layers()[l];
        std::vector<std::byte> texels(payload_bytes(format_info(layer.format), sample::kSquare, sample::kSquare));
        if (layer.format == TexelFormat::kBc1) {
          encode::encode_bc1_image(rgb, sample::kSquare, sample::kSquare, sample::kSquare * 3, 3, texels);
        } else {
          texels.assign(rgb.begin(), rgb.end());
        }
        VT_ASSIGN(const store::Compression compression, store::parse_compression(layer.compression));
        VT_ASSIGN(const store::EncodedPayload payload,
                  store::encode_payload(texels, store::tile_shape(layer.format, sample::kSquare), compression));
        VT_CHECK(writer.put(ids[l], {Level{level_for(kPaintedSide * kPaintedSide)}, x, y}, payload));
      }
    }
  return writer.finish();
}

// Nanoseconds a call, over `runs` passes after one that warms the caches.
template <class Call>
Result<Spread> nanoseconds_per_call(const std::vector<TileId>& tiles, int runs, const Call& call) {
  std::vector<double> values;
  for (int run = 0; run <= runs; ++run) {
    VT_CHECK(check_interrupt());
    Result<void> status;
    const double seconds = seconds_of([&] {
      for (const TileId& tile : tiles)
        if (status = call(tile); !status) return;
    });
    VT_CHECK(status);
    if (run > 0) values.push_back(1e9 * seconds / static_cast<double>(tiles.size()));
  }
  return spread_of(values);
}

// `count` tiles of the index layer in random order: anywhere, or within one square of `side` tiles.
std::vector<TileId> random_tiles(std::uint64_t tiles, std::uint64_t side, std::size_t count) {
  const std::uint8_t finest = level_for(tiles);
  const std::uint64_t columns = std::min(std::uint64_t{1} << finest, side);
  const std::uint64_t rows = std::min(std::max<std::uint64_t>(tiles >> finest, 1), side);
  std::mt19937_64 random(1);
  std::vector<TileId> chosen;
  for (std::size_t i = 0; i < count; ++i)
    chosen.push_back({Level{finest}, static_cast<std::uint32_t>(random() % columns), static_cast<std::uint32_t>(random() % rows)});
  return chosen;
}

Result<int> run(const LookupFlags& flags) {
  warn_about_conditions();
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  const auto path = scratch / "lookup.vts";
  {
    VT_ASSIGN(store::StoreWriter writer, store::StoreWriter::create(path, {}, {.sync = false}));
    VT_CHECK(fill_store(writer, flags.tiles));
  }
  VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(path));

  const Machine machine = this_machine();
  Table table({{"what", "what"},
               {"tiles", "tiles", 0},
               {"median_ns", "median ns", 1},
               {"min_ns", "min", 1},
               {"max_ns", "max", 1},
               {"mb_per_s", "MB/s", 0},
               {"runs", "", 0},
               {"cpu", ""},
               {"cores", "", 0}});
  const auto add = [&](const std::string& what, double tiles, const Spread& ns, double bytes) {
    table.add_row({what, tiles, ns.median, ns.min, ns.max, bytes > 0.0 ? Cell(1e3 * bytes / ns.median) : Cell(), double(flags.runs),
                   machine.cpu, double(machine.cores)});
  };

  const LayerId index = reader.find_layer("index")->id;
  const auto find = [&](const TileId& tile) -> Result<void> {
    const auto found = reader.lookup(index, tile);
    if (!found) return tl::unexpected(found.error());
    if (found->kind != store::TileKind::kConstant) return fail(ErrorCode::kInternal, "lookup: a tile that was written was not found");
    return {};
  };
  constexpr std::size_t kCalls = 1 << 16;
  VT_ASSIGN(const Spread everywhere, nanoseconds_per_call(random_tiles(flags.tiles, ~std::uint64_t{0}, kCalls), flags.runs, find));
  add("lookup, anywhere in the index", static_cast<double>(flags.tiles), everywhere, 0.0);
  VT_ASSIGN(const Spread nearby, nanoseconds_per_call(random_tiles(flags.tiles, 64, kCalls), flags.runs, find));
  add("lookup, within 64 x 64 tiles", static_cast<double>(flags.tiles), nearby, 0.0);

  std::vector<TileId> painted;
  for (std::uint32_t i = 0; i < kPaintedSide * kPaintedSide; ++i)
    painted.push_back({Level{level_for(kPaintedSide * kPaintedSide)}, i % kPaintedSide, i / kPaintedSide});
  for (const PaintedLayer& layer : painted_layers()) {
    const LayerInfo& info = *reader.find_layer(layer.name);
    std::vector<std::byte> out(info.tile_payload_bytes());
    VT_ASSIGN(const Spread ns,
              nanoseconds_per_call(painted, flags.runs, [&](const TileId& tile) { return reader.read(info.id, tile, out); }));
    add("read a tile, " + layer.name, static_cast<double>(painted.size()), ns, static_cast<double>(out.size()));
  }
  VT_CHECK(
      flags.results.deliver(fmt::format("Warm lookups and reads, one thread; a store of {} tiles of 256 x 256 texels; median of {} passes",
                                        flags.tiles, flags.runs),
                            table, ""));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_lookup_command(CLI::App& app) {
  auto flags = std::make_shared<LookupFlags>();
  CLI::App* command = app.add_subcommand("lookup", "nanoseconds to find a tile in a large index, and to read one; caches warm");
  command->add_option("--tiles", flags->tiles, "tiles in the index; each takes 16 bytes of disk")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 32));
  command->add_option("--runs", flags->runs, "passes, the median counts")->capture_default_str()->check(CLI::Range(1, 1000));
  command->add_option("--scratch", flags->scratch, "folder for the store (default: the system's temporary folder)");
  flags->results.add_to(*command, false);
  cli::add_help_footer(*command, "  vtbench lookup\n  vtbench lookup --tiles 100000000 --scratch /fast/disk --csv lookup.csv\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
