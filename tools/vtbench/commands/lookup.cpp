// vtbench lookup: how long a reader takes to find a tile in a large index, beside key-value stores with the
// same keys; what opening and updating such an index takes; and how long it takes to hand out a tile's
// texels.

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <memory>
#include <random>

#include "builder/encode/bc1/bc1_encoder.h"
#include "builder/sample/painter.h"
#include "store/format/layout.h"
#include "store/io/file.h"
#include "store/io/mapping.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/inputs/large_index.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/peers/key_value.h"

namespace vt::bench {
namespace {

struct LookupFlags {
  std::vector<std::uint64_t> tiles = {1000000};
  std::uint64_t peer_tiles = 20000000;
  int runs = 9;
  std::string scratch;
  ResultFlags results;
};

constexpr std::uint8_t kTileExponent = 8;
constexpr std::uint32_t kPaintedSide = 8;  // painted tiles along an edge: 64 of them are 12 MiB of RGB
constexpr Level kPaintedLevel{3};
constexpr std::size_t kCalls = std::size_t{1} << 18;  // look-ups a pass
constexpr std::size_t kUpdates = 1000;                // tiles changed in one commit

Table empty_lookup_table() {
  return Table({{"what", "what"},
                {"tiles", "tiles", 0},
                {"median_ns", "median ns", 1},
                {"min_ns", "min", 1},
                {"max_ns", "max", 1},
                {"mb_per_s", "MB/s", 0},
                {"note", "note"},
                {"runs", "", 0},
                {"cpu", ""},
                {"cores", "", 0}});
}

// Rows under one table.
struct Figures {
  Table table = empty_lookup_table();
  int runs = 0;
  Machine machine = this_machine();

  void add(const std::string& what, double tiles, const Spread& ns, double bytes = 0.0, const std::string& note = "") {
    table.add_row({what, tiles, ns.median, ns.min, ns.max, bytes > 0.0 ? Cell(1e3 * bytes / ns.median) : Cell(),
                   note.empty() ? Cell() : Cell(note), double(runs), machine.cpu, double(machine.cores)});
  }
  // Something that is done once.
  void add_once(const std::string& what, double tiles, double seconds, const std::string& note) {
    table.add_row({what, tiles, 1e9 * seconds, Cell(), Cell(), Cell(), note, 1.0, machine.cpu, double(machine.cores)});
  }
  void add_missing(const std::string& what, double tiles, const std::string& note) {
    table.add_row({what, tiles, Cell(), Cell(), Cell(), Cell(), note, 0.0, machine.cpu, double(machine.cores)});
  }
};

std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t size = 0;
  std::uint64_t resident = 0;
  statm >> size >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::uint64_t available_memory() {
  std::ifstream info("/proc/meminfo");
  for (std::string word; info >> word;)
    if (word == "MemAvailable:") {
      std::uint64_t kibibytes = 0;
      info >> kibibytes;
      return kibibytes << 10;
    }
  return ~std::uint64_t{0};
}

// `pass(n)` does pass number n and gives its seconds for `calls` calls; the first one only warms the caches.
Result<Spread> nanoseconds_per_call(int runs, std::size_t calls, const std::function<Result<double>(int)>& pass) {
  std::vector<double> values;
  for (int run = 0; run <= runs; ++run) {
    VT_CHECK(check_interrupt());
    VT_ASSIGN(const double seconds, pass(run));
    if (run > 0) values.push_back(1e9 * seconds / static_cast<double>(calls));
  }
  return spread_of(values);
}

// The tiles of a pass; each pass asks for others, so that none finds what the one before left in the caches.
using TileSource = std::vector<TileId> (*)(const IndexShape&, std::size_t, std::mt19937_64&);

tl::unexpected<Error> not_found() { return fail(ErrorCode::kInternal, "lookup: a tile that was written was not found"); }

// Independent calls in a row: the processor begins the next one while it waits for memory.
Result<Spread> measure_lookups(const store::StoreReader& reader, LayerId layer, const IndexShape& shape, TileSource source, int runs) {
  std::mt19937_64 random(1);
  return nanoseconds_per_call(runs, kCalls, [&](int) -> Result<double> {
    const std::vector<TileId> tiles = source(shape, kCalls, random);
    std::size_t found = 0;
    Result<void> status;
    const double seconds = seconds_of([&] {
      for (const TileId tile : tiles) {
        const auto lookup = reader.lookup(layer, tile);
        if (!lookup) {
          status = tl::unexpected(lookup.error());
          return;
        }
        found += lookup->kind != store::TileKind::kAbsent ? 1 : 0;
      }
    });
    VT_CHECK(status);
    if (found != tiles.size()) return not_found();
    return seconds;
  });
}

// Each call waits for the answer of the one before.
Result<Spread> measure_latency(const store::StoreReader& reader, LayerId layer, const IndexShape& shape, TileSource source, int runs) {
  std::mt19937_64 random(1);
  return nanoseconds_per_call(runs, kCalls, [&](int) -> Result<double> {
    const std::vector<TileId> tiles = source(shape, kCalls, random);
    std::uint64_t last = 0;
    Result<void> status;
    const double seconds = seconds_of([&] {
      for (const TileId tile : tiles) {
        // Offsets have 48 bits: nothing is added, but the processor has to know the offset to see that.
        const TileId next{tile.level, tile.x + static_cast<std::uint32_t>(last >> 63), tile.y};
        const auto lookup = reader.lookup(layer, next);
        if (!lookup) {
          status = tl::unexpected(lookup.error());
          return;
        }
        last = lookup->offset;
      }
    });
    VT_CHECK(status);
    if (last == 0) return not_found();
    return seconds;
  });
}

// What the memory takes for one line anywhere in the index, each waiting for the one before: no look-up that
// has to go there is faster.
Result<Spread> measure_memory(const std::filesystem::path& path, int runs) {
  VT_ASSIGN(const store::File file, store::File::open(path, store::File::Mode::kRead));
  VT_ASSIGN(const std::uint64_t bytes, file.size());
  VT_ASSIGN(const store::Mapping mapping, store::Mapping::map(file, bytes));
  const auto contents = mapping.bytes();
  std::uint64_t sum = 0;
  for (std::size_t at = 0; at < contents.size(); at += 4096) sum += std::to_integer<std::uint64_t>(contents[at]);
  std::mt19937_64 random(1);
  VT_ASSIGN(const Spread ns, nanoseconds_per_call(runs, kCalls, [&](int) -> Result<double> {
              std::vector<std::uint64_t> places;
              while (places.size() < kCalls) places.push_back(random() % (contents.size() - 1));
              return seconds_of([&] {
                for (const std::uint64_t place : places) sum += std::to_integer<std::uint64_t>(contents[place + (sum >> 63)]);
              });
            }));
  // The sum is there to be waited for; with at most 2^32 terms below 256 its highest bit stays 0.
  if (sum >> 63 != 0) return fail(ErrorCode::kInternal, "lookup: an impossible sum");
  return ns;
}

Result<Spread> measure_many(const store::StoreReader& reader, LayerId layer, const IndexShape& shape, TileSource source, int runs) {
  constexpr std::size_t kBatch = 256;
  std::mt19937_64 random(1);
  std::array<store::TileLookup, kBatch> found;
  return nanoseconds_per_call(runs, kCalls, [&](int) -> Result<double> {
    const std::vector<TileId> tiles = source(shape, kCalls, random);
    Result<void> status;
    std::size_t present = 0;
    const double seconds = seconds_of([&] {
      for (std::size_t first = 0; first < tiles.size() && status; first += kBatch) {
        status = reader.lookup_many(layer, std::span(tiles).subspan(first, kBatch), found);
        for (const store::TileLookup& lookup : found) present += lookup.kind != store::TileKind::kAbsent ? 1 : 0;
      }
    });
    VT_CHECK(status);
    if (present != tiles.size()) return not_found();
    return seconds;
  });
}

std::uint64_t key_of(TileId tile) { return store::record_key(LayerId{0}, tile.level, store::morton_code(tile.x, tile.y)); }

Result<Spread> measure_gets(KeyValueStore& store, const IndexShape& shape, TileSource source, int runs) {
  std::mt19937_64 random(1);
  return nanoseconds_per_call(runs, kCalls, [&](int) -> Result<double> {
    std::vector<std::uint64_t> keys;
    for (const TileId tile : source(shape, kCalls, random)) keys.push_back(key_of(tile));
    Result<void> status;
    const double seconds = seconds_of([&] {
      for (const std::uint64_t key : keys) {
        const auto found = store.get(key);
        if (!found) status = tl::unexpected(found.error());
        if (found && !*found) status = not_found();
        if (!status) return;
      }
    });
    VT_CHECK(status);
    return seconds;
  });
}

// Opens the store for writing, changes some tiles anywhere in it, and makes that durable.
Result<void> measure_update(const std::filesystem::path& path, const IndexShape& shape, Figures& figures) {
  std::mt19937_64 random(2);
  const std::vector<TileId> tiles = anywhere(shape, kUpdates, random);
  const auto start = std::chrono::steady_clock::now();
  const auto seconds_so_far = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  VT_ASSIGN(store::StoreWriter writer, store::StoreWriter::open(path));
  const double opened = seconds_so_far();
  const LayerId layer = writer.find_layer("index")->id;
  const std::array<std::byte, 3> texel = {std::byte{200}, std::byte{1}, std::byte{2}};
  for (const TileId tile : tiles) VT_CHECK(writer.put_constant(layer, tile, texel));
  const double put = seconds_so_far();
  VT_CHECK(writer.finish());
  const double committed = seconds_so_far();
  figures.add_once(
      fmt::format("update {} tiles anywhere", kUpdates), static_cast<double>(shape.tiles()), committed,
      fmt::format("open {:.1f} ms, put {:.1f} ms, commit {:.1f} ms", 1e3 * opened, 1e3 * (put - opened), 1e3 * (committed - put)));

  VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(path));
  std::vector<std::byte> texels(reader.find_layer(layer)->tile_payload_bytes());
  for (const TileId tile : tiles) {
    VT_CHECK(reader.read(layer, tile, texels));
    if (texels.front() != texel.front()) return fail(ErrorCode::kInternal, "lookup: an updated tile reads back as it was before");
  }
  return {};
}

// A part of the tiles with the pages above them, as many as a person waits for.
Result<void> measure_validation(const std::filesystem::path& path, double tiles, Figures& figures) {
  constexpr std::uint64_t kSample = 100000;
  Result<store::ValidationReport> report;
  const double seconds = seconds_of([&] { report = store::validate(path, {.sample_tiles = kSample}); });
  VT_CHECK(report);
  if (!report->ok()) return fail(ErrorCode::kInternal, "lookup: the index is not valid: " + report->findings.front().sentence);
  figures.add_once("validate", tiles, seconds,
                   fmt::format("{} of {} tiles, {} in {:.2f} s", report->tiles_checked, report->tiles_in_store,
                               cli::format_bytes(report->bytes_checked), seconds));
  return {};
}

Result<void> measure_peers(const std::filesystem::path& folder, const IndexShape& shape, std::uint64_t most_tiles, Figures& figures) {
  const auto tiles = static_cast<double>(shape.tiles());
  for (const auto& peer : key_value_stores()) {
    if (shape.tiles() > most_tiles) {
      figures.add_missing(peer->name(), tiles,
                          fmt::format("left out: more than {} keys take it too long to load (--peer-tiles)", most_tiles));
      continue;
    }
    cli::print_note("vtbench", fmt::format("loading {} keys into {}", shape.tiles(), peer->name()));
    const KeySource keys = [&](const auto& take) -> Result<void> {
      for (int level = 0; level <= shape.finest().value; ++level) {
        const Level l{static_cast<std::uint8_t>(level)};
        const auto take_run = [&](std::uint64_t first, std::uint64_t count) -> Result<void> {
          for (std::uint64_t morton = first; morton < first + count; ++morton) VT_CHECK(take(store::record_key(LayerId{0}, l, morton)));
          return check_interrupt();
        };
        VT_CHECK(shape.for_each_run(l, take_run));
      }
      return {};
    };
    VT_CHECK(peer->load(folder, shape.tiles() * 48, keys));
    VT_ASSIGN(const Spread random, measure_gets(*peer, shape, anywhere, figures.runs));
    figures.add(peer->name() + ", anywhere", tiles, random);
    VT_ASSIGN(const Spread local, measure_gets(*peer, shape, flight, figures.runs));
    figures.add(peer->name() + ", along a flight", tiles, local);
  }
  return {};
}

Result<void> measure_index(const LookupFlags& flags, std::uint64_t wanted_tiles, Figures& figures) {
  const IndexShape shape(wanted_tiles);
  const auto tiles = static_cast<double>(shape.tiles());
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  const auto path = scratch / "index.vts";
  {
    cli::Progress progress({.title = "writing the index", .unit = "tiles", .total = shape.tiles()});
    Result<void> written;
    const double seconds = seconds_of([&] {
      written = write_index(path, shape, [&](std::uint64_t done) {
        progress.update(done);
        return check_interrupt();
      });
    });
    VT_CHECK(written);
    const auto bytes = std::filesystem::file_size(path);
    figures.add_once("write the index", tiles, seconds,
                     fmt::format("{}, {:.1f} bytes a tile, {} tiles/s", cli::format_bytes(bytes), static_cast<double>(bytes) / tiles,
                                 cli::format_quantity(tiles / seconds)));
    if (bytes > available_memory())
      cli::print_note("vtbench",
                      fmt::format("an index of {} tiles does not fit into what memory is free; figures include the disk", shape.tiles()));
  }
  {
    VT_ASSIGN(const Spread memory, measure_memory(path, flags.runs));
    figures.add("memory: any line of the file, each waits for the last", tiles, memory);
  }
  {
    const std::uint64_t resident_before = resident_bytes();
    const auto start = std::chrono::steady_clock::now();
    VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(path));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::uint64_t resident_after = resident_bytes();
    figures.add_once("open", tiles, seconds,
                     fmt::format("{:.2f} ms, {} more resident", 1e3 * seconds,
                                 cli::format_bytes(resident_after - std::min(resident_before, resident_after))));
    const LayerId layer = reader.find_layer("index")->id;
    Result<void> warmed;
    const double warm_seconds = seconds_of([&] { warmed = warm_index(reader, layer, shape); });
    VT_CHECK(warmed);
    figures.add_once("check every page once", tiles, warm_seconds, fmt::format("{:.1f} ms", 1e3 * warm_seconds));

    struct Kind {
      const char* name;
      Result<Spread> (*measure)(const store::StoreReader&, LayerId, const IndexShape&, TileSource, int);
      TileSource source;
    };
    for (const Kind& kind :
         {Kind{"lookup, anywhere", measure_lookups, anywhere}, Kind{"lookup, anywhere, each waits for the last", measure_latency, anywhere},
          Kind{"lookup_many, anywhere", measure_many, anywhere}, Kind{"lookup, along a flight", measure_lookups, flight},
          Kind{"lookup_many, along a flight", measure_many, flight}}) {
      VT_ASSIGN(const Spread ns, kind.measure(reader, layer, shape, kind.source, flags.runs));
      figures.add(kind.name, tiles, ns);
    }
  }
  VT_CHECK(measure_update(path, shape, figures));
  VT_CHECK(measure_validation(path, tiles, figures));
  std::error_code ignored;
  std::filesystem::remove(path, ignored);  // the peers may need its room
  return measure_peers(scratch.path(), shape, flags.peer_tiles, figures);
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

LayerInfo square_layer(const PaintedLayer& painted) {
  LayerInfo layer;
  layer.name = painted.name;
  layer.format = painted.format;
  layer.transfer = Transfer::kSrgb;
  layer.tile_exponent = kTileExponent;
  layer.finest = kPaintedLevel;
  const std::int64_t edge = std::int64_t{kPaintedSide} << kTileExponent;
  layer.data = {0, 0, edge, edge};
  return layer;
}

// Few tiles, but real pictures, so that decompression has its real work.
Result<void> paint_store(store::StoreWriter& writer) {
  const sample::World world(1);
  sample::Painter painter(world);
  const auto square = std::make_unique<sample::Square>();
  static_assert(sample::kSquare == 1 << kTileExponent);
  std::vector<LayerId> ids;
  for (const PaintedLayer& layer : painted_layers()) {
    VT_ASSIGN(const LayerId id, writer.add_layer(square_layer(layer)));
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
        VT_CHECK(writer.put(ids[l], {kPaintedLevel, x, y}, payload));
      }
    }
  return writer.finish();
}

Result<void> measure_reads(const LookupFlags& flags, Figures& figures) {
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  const auto path = scratch / "painted.vts";
  {
    VT_ASSIGN(store::StoreWriter writer, store::StoreWriter::create(path, {}, {.sync = false}));
    VT_CHECK(paint_store(writer));
  }
  VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(path));
  constexpr std::size_t kPainted = std::size_t{kPaintedSide} * kPaintedSide;
  for (const PaintedLayer& layer : painted_layers()) {
    const LayerInfo& info = *reader.find_layer(layer.name);
    std::vector<std::byte> out(info.tile_payload_bytes());
    VT_ASSIGN(const Spread ns, nanoseconds_per_call(flags.runs, kPainted, [&](int) -> Result<double> {
                Result<void> status;
                const double seconds = seconds_of([&] {
                  for (std::uint32_t i = 0; i < kPainted && status; ++i)
                    status = reader.read(info.id, {kPaintedLevel, i % kPaintedSide, i / kPaintedSide}, out);
                });
                VT_CHECK(status);
                return seconds;
              }));
    figures.add("read a tile, " + layer.name, static_cast<double>(kPainted), ns, static_cast<double>(out.size()));
  }
  return {};
}

Result<int> run(const LookupFlags& flags) {
  warn_about_conditions();
  Figures figures{.runs = flags.runs};
  for (const std::uint64_t tiles : flags.tiles) VT_CHECK(measure_index(flags, tiles, figures));
  VT_CHECK(measure_reads(flags, figures));
  VT_CHECK(flags.results.deliver(
      fmt::format(
          "Warm look-ups and reads, one thread; tiles of 256 x 256 texels; median of {} passes of {} look-ups, each pass for other tiles",
          flags.runs, kCalls),
      figures.table, ""));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_lookup_command(CLI::App& app) {
  auto flags = std::make_shared<LookupFlags>();
  CLI::App* command = app.add_subcommand(
      "lookup",
      "nanoseconds to find a tile in a large index, beside LMDB and SQLite where they are built in, and to read one; caches warm");
  command
      ->add_option("--tiles", flags->tiles,
                   "tiles in the index, all levels together; several sizes with commas; each tile takes 16 bytes of disk")
      ->capture_default_str()
      ->delimiter(',')
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 36));
  command->add_option("--peer-tiles", flags->peer_tiles, "largest index at which the peers are measured, too; 0: never")
      ->capture_default_str();
  command->add_option("--runs", flags->runs, "passes, the median counts")->capture_default_str()->check(CLI::Range(1, 1000));
  command->add_option("--scratch", flags->scratch, "folder for the stores (default: the system's temporary folder)");
  flags->results.add_to(*command, false);
  cli::add_help_footer(*command,
                       "  vtbench lookup\n"
                       "  vtbench lookup --tiles 1000000,100000000,1000000000 --scratch /fast/disk --csv lookup.csv\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
