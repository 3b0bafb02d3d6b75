// vtbench scoreboard: what this builder and others make of the cases that pyramids go wrong on.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>

#include "builder/channels/samples/read_samples.h"
#include "builder/source/raster_source.h"
#include "store/store_reader.h"
#include "store/texel/texel_decoder.h"
#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/inputs/score_cases.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/peers/child_process.h"

namespace vt::bench {
namespace {

struct ScoreboardFlags {
  std::string scratch;
  bool only_ours = false;
  ResultFlags results;
};

void put_sample(SampleType type, double value, std::byte* out) {
  const auto put = [&](auto typed) { std::memcpy(out, &typed, sizeof typed); };
  if (type == SampleType::kUint8) return put(static_cast<std::uint8_t>(value));
  if (type == SampleType::kInt16) return put(static_cast<std::int16_t>(value));
  put(static_cast<float>(value));
}

Result<void> write_case(const ScoreCase& score, const std::filesystem::path& path) {
  VT_ASSIGN(auto writer, source::GeoTiffWriter::create(path, score.raster));
  const std::size_t bytes = sample_bytes(score.raster.sample_type);
  std::vector<std::byte> row(static_cast<std::size_t>(score.raster.width * score.raster.bands) * bytes);
  for (std::int64_t y = 0; y < score.raster.height; ++y) {
    std::byte* out = row.data();
    for (std::int64_t x = 0; x < score.raster.width; ++x)
      for (int band = 0; band < score.raster.bands; ++band, out += bytes)
        put_sample(score.raster.sample_type, score.value(x, y, band), out);
    VT_CHECK(writer.write_rows(row, 1));
  }
  return writer.finish();
}

// ---- Our pyramids ----

Result<LevelValues> values_of_level(const store::StoreReader& reader, const LayerInfo& layer, Level level) {
  const TexelRect data = layer.data_rect(level);
  const auto channels = static_cast<std::size_t>(format_info(layer.format).channels);
  LevelValues values{
      data.width, data.height, static_cast<int>(channels), SampleType::kFloat64,
      std::vector<double>(static_cast<std::size_t>(data.width * data.height) * channels, std::numeric_limits<double>::quiet_NaN())};
  const std::size_t edge = layer.tile_texels();
  std::vector<std::byte> payload(layer.tile_payload_bytes());
  std::vector<float> samples(edge * edge * channels);
  const TexelRect tiles = layer.tile_rect(level);
  for (std::int64_t ty = tiles.y; ty < tiles.bottom(); ++ty)
    for (std::int64_t tx = tiles.x; tx < tiles.right(); ++tx) {
      const TileId tile{level, static_cast<std::uint32_t>(tx), static_cast<std::uint32_t>(ty)};
      const auto read = reader.read(layer.id, tile, payload);
      if (!read && read.error().code == ErrorCode::kNotFound) continue;
      VT_CHECK(read);
      store::decode_texels(layer.format, payload, edge, edge, samples);
      const TexelRect place = rect_of(tile, layer.tile_exponent);
      const TexelRect part = intersect(place, data);
      for (std::int64_t y = part.y; y < part.bottom(); ++y)
        for (std::int64_t x = part.x; x < part.right(); ++x)
          for (std::size_t c = 0; c < channels; ++c) {
            const float sample = samples[static_cast<std::size_t>((y - place.y) * place.width + (x - place.x)) * channels + c];
            values.values[static_cast<std::size_t>((y - data.y) * data.width + (x - data.x)) * channels + c] =
                layer.components[c].offset + layer.components[c].scale * static_cast<double>(sample);
          }
    }
  return values;
}

Result<std::string> judge_ours(const ScoreCase& score, const std::vector<std::string>& arguments, const std::filesystem::path& input,
                               const std::filesystem::path& vtbuild, const ScratchFolder& scratch) {
  const auto store_path = scratch / "ours.vts";
  std::filesystem::remove(store_path);
  ChildCommand command;
  command.arguments = {vtbuild.string(), "layer", input.string(), "-o",  store_path.string(), "--crs", "pixel",
                       "--tile",         "16",    "--progress",   "none"};
  command.arguments.insert(command.arguments.end(), arguments.begin(), arguments.end());
  command.output = command.errors = scratch / "messages.txt";
  VT_ASSIGN(const ChildRun run, run_child(command));
  if (run.exit_code != 0) {
    VT_ASSIGN(const std::string message, read_text_file(command.errors));
    return fail(ErrorCode::kInternal, score.test + ": vtbuild failed: " + message);
  }
  VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(store_path));
  Pyramids layers;
  for (const LayerInfo& layer : reader.layers()) {
    if (layer.role != LayerRole::kTexture) continue;
    Pyramid& pyramid = layers[layer.name];
    for (std::size_t k = 0; k <= score.overviews; ++k) {
      VT_ASSIGN(LevelValues level, values_of_level(reader, layer, Level{static_cast<std::uint8_t>(layer.finest.value - k)}));
      pyramid.push_back(std::move(level));
    }
  }
  if (score.judge_ours) return score.judge_ours(layers);
  return score.judge(layers.begin()->second);
}

// ---- Pyramids of other tools ----

Result<LevelValues> values_of_file(const std::filesystem::path& path) {
  VT_ASSIGN(const auto raster, source::open_raster(path));
  const source::RasterInfo& info = raster->info();
  std::vector<int> bands;
  for (int band = 0; band < info.bands; ++band) bands.push_back(band);
  const std::size_t bytes = sample_bytes(info.sample_type);
  const std::size_t pitch = static_cast<std::size_t>(info.width) * bands.size() * bytes;
  std::vector<std::byte> samples(pitch * static_cast<std::size_t>(info.height));
  VT_CHECK(raster->read({0, 0, info.width, info.height}, bands, samples, pitch));
  LevelValues values{info.width, info.height, info.bands, info.sample_type, {}};
  for (std::size_t at = 0; at < samples.size(); at += bytes) values.values.push_back(channels::read_sample(info.sample_type, &samples[at]));
  return values;
}

// nullopt: the tool made no such pyramid, or gdal_translate cannot read it; the message is the tool's own
// affair.
Result<std::optional<Pyramid>> levels_of_file(const std::filesystem::path& path, std::size_t overviews, const std::filesystem::path& gdal,
                                              const ScratchFolder& scratch) {
  Pyramid pyramid;
  VT_ASSIGN(LevelValues base, values_of_file(path));
  pyramid.push_back(std::move(base));
  const auto level_file = scratch / "level.tif";
  const auto messages = scratch / "messages.txt";
  for (std::size_t k = 0; k < overviews; ++k) {
    // As an overview; some tools write plain pages instead.
    const std::array<std::vector<std::string>, 2> ways = {
        std::vector<std::string>{"-ovr", std::to_string(k), path.string()},
        std::vector<std::string>{fmt::format("GTIFF_DIR:{}:{}", k + 2, path.string())},
    };
    bool is_read = false;
    for (const std::vector<std::string>& way : ways) {
      if (is_read) break;
      std::filesystem::remove(level_file);
      ChildCommand command{{gdal.string(), "-q"}, {}, messages, messages};
      command.arguments.insert(command.arguments.end(), way.begin(), way.end());
      command.arguments.push_back(level_file.string());
      VT_ASSIGN(const ChildRun run, run_child(command));
      if (run.exit_code != 0) continue;
      auto level = values_of_file(level_file);
      if (!level) continue;
      pyramid.push_back(std::move(*level));
      is_read = true;
    }
    if (!is_read) return std::optional<Pyramid>{};
  }
  return std::optional(std::move(pyramid));
}

struct Tool {
  std::string column;
  std::filesystem::path program;
  const std::vector<PeerRun>& (*runs)(const ScoreCase& score);
  // The command for `run`; the input has been copied to `output` already.
  std::vector<std::string> (*arguments)(const PeerRun& run, const std::string& input, const std::string& output);
};

std::vector<Tool> installed_tools() {
  std::vector<Tool> tools;
  const auto add = [&](const char* column, const char* name, auto runs, auto arguments) {
    if (const auto program = find_program(name)) tools.push_back({column, *program, runs, arguments});
  };
  using CommandLine = std::vector<std::string>;
  const auto join = [](CommandLine first, const CommandLine& rest) {
    first.insert(first.end(), rest.begin(), rest.end());
    return first;
  };
  static const auto kJoin = join;
  add(
      "gdal", "gdaladdo", [](const ScoreCase& score) -> const std::vector<PeerRun>& { return score.gdal; },
      [](const PeerRun& run, const std::string&, const std::string& output) {
        return kJoin(kJoin({"-q"}, run.arguments), {output, "2", "4", "8", "16", "32"});
      });
  add(
      "vips", "vips", [](const ScoreCase& score) -> const std::vector<PeerRun>& { return score.vips; },
      [](const PeerRun& run, const std::string& input, const std::string& output) {
        return kJoin({"tiffsave", input, output, "--tile", "--pyramid", "--tile-width", "16", "--tile-height", "16"}, run.arguments);
      });
  add(
      "maketx", "maketx", [](const ScoreCase& score) -> const std::vector<PeerRun>& { return score.maketx; },
      [](const PeerRun& run, const std::string& input, const std::string& output) {
        return kJoin(kJoin({"--tile", "16", "16"}, run.arguments), {"-o", output, input});
      });
  return tools;
}

Result<std::string> judge_tool(const ScoreCase& score, const Tool& tool, const PeerRun& run, const std::filesystem::path& input,
                               const std::filesystem::path& gdal, const ScratchFolder& scratch) {
  const auto output = scratch / "peer.tif";
  std::filesystem::remove(output);
  if (tool.column == "gdal") std::filesystem::copy_file(input, output);
  ChildCommand command;
  command.arguments = tool.arguments(run, input.string(), output.string());
  command.arguments.insert(command.arguments.begin(), tool.program.string());
  command.output = command.errors = scratch / "messages.txt";
  VT_ASSIGN(const ChildRun child, run_child(command));
  if (child.exit_code != 0) return std::string("fails");
  VT_ASSIGN(const std::optional<Pyramid> pyramid, levels_of_file(output, score.overviews, gdal, scratch));
  if (!pyramid) return std::string("unreadable");
  const SampleType base = pyramid->front().type;
  if (std::ranges::all_of(*pyramid, [&](const LevelValues& level) { return level.type == base; })) return score.judge(*pyramid);
  // Floats under another name are no numbers.
  return base == SampleType::kFloat32 ? std::string("levels of another sample type") : "another sample type: " + score.judge(*pyramid);
}

// "average 128, cubic 128"; equal answers are given once.
class Answers {
 public:
  void add(const std::string& label, const std::string& answer) {
    for (auto& [labels, known] : answers_)
      if (known == answer) {
        if (!label.empty()) labels += (labels.empty() ? "" : ", ") + label;
        return;
      }
    answers_.emplace_back(label, answer);
  }
  [[nodiscard]] std::string text() const {
    std::string text;
    for (const auto& [labels, answer] : answers_)
      text += (text.empty() ? "" : "; ") + (labels.empty() || answers_.size() == 1 ? "" : labels + ": ") + answer;
    return text;
  }

 private:
  std::vector<std::pair<std::string, std::string>> answers_;
};

Result<int> run(const ScoreboardFlags& flags) {
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  VT_ASSIGN(const std::filesystem::path vtbuild, program_beside("vtbuild"));
  const auto gdal = find_program("gdal_translate");  // takes the levels out of the peers' files
  std::vector<Tool> tools;
  if (gdal && !flags.only_ours) tools = installed_tools();

  std::vector<Column> columns = {{"test", "test"}, {"truth", "truth"}, {"vtbuild", "vtbuild"}};
  for (const Tool& tool : tools) columns.push_back({tool.column, tool.column});
  Table table(columns);
  const auto input = scratch / "input.tif";
  for (const ScoreCase& score : score_cases()) {
    VT_CHECK(check_interrupt());
    VT_CHECK(write_case(score, input));
    Answers ours;
    for (const auto& [label, arguments] : score.ours) {
      VT_ASSIGN(const std::string answer, judge_ours(score, arguments, input, vtbuild, scratch));
      ours.add(label, answer);
    }
    std::vector<Cell> cells = {score.test, score.truth, ours.text()};
    for (const Tool& tool : tools) {
      Answers answers;
      for (const PeerRun& peer_run : tool.runs(score)) {
        VT_ASSIGN(const std::string answer, judge_tool(score, tool, peer_run, input, *gdal, scratch));
        answers.add(peer_run.label, answer);
      }
      cells.emplace_back(answers.text().empty() ? std::string("-") : answers.text());
    }
    table.add_row(std::move(cells));
  }
  VT_CHECK(flags.results.deliver("What pyramid builders make of hard cases", table, ""));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_scoreboard_command(CLI::App& app) {
  auto flags = std::make_shared<ScoreboardFlags>();
  CLI::App* command =
      app.add_subcommand("scoreboard", "the cases that pyramid builders get wrong: the answer by analysis, ours, and other tools'");
  command->add_option("--scratch", flags->scratch, "folder for intermediate files (default: the system's)");
  command->add_flag("--only-ours", flags->only_ours, "leave the other tools out");
  flags->results.add_to(*command, false);
  cli::add_help_footer(*command,
                       "  vtbench scoreboard\n"
                       "  vtbench scoreboard --markdown scoreboard.md\n");
  return [flags, command]() -> Result<int> {
    if (!command->parsed()) return -1;
    return run(*flags);
  };
}

}  // namespace vt::bench
