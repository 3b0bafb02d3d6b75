#include "tools/vtbench/measure/parts.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/encode/bc1/bc1_encoder.h"
#include "builder/pipeline/build/plan_cost.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "builder/pyramid/plane_cascade.h"
#include "store/io/content_hash.h"
#include "store/io/file.h"
#include "tools/vtbench/measure/machine.h"

namespace vt::bench {
namespace {

constexpr std::int64_t kWindow = 4096;
constexpr std::int64_t kChunkRows = 32;  // read at once, as in a build
constexpr std::int64_t kPartTile = 256;
constexpr std::size_t kTransfer = std::size_t{1} << 20;  // bytes a write call

using Tiles = std::vector<std::vector<std::byte>>;

// Whole tiles of one level; what is left over at its east and south edge is not kept. A level smaller than a
// tile fills the corner of one.
struct LevelTiles {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  Tiles tiles;
};

LevelTiles room_for(std::int64_t width, std::int64_t height, std::size_t texel_bytes) {
  LevelTiles level{std::max<std::int64_t>(width / kPartTile, 1), std::max<std::int64_t>(height / kPartTile, 1), {}};
  level.tiles.assign(static_cast<std::size_t>(level.columns * level.rows),
                     std::vector<std::byte>(static_cast<std::size_t>(kPartTile * kPartTile) * texel_bytes));
  return level;
}

void keep_row(LevelTiles& level, std::int64_t y, std::span<const std::byte> texels, std::size_t texel_bytes) {
  if (y >= level.rows * kPartTile) return;
  const std::size_t tile_row_bytes = static_cast<std::size_t>(kPartTile) * texel_bytes;
  for (std::int64_t column = 0; column < level.columns; ++column) {
    const std::size_t at = static_cast<std::size_t>(column) * tile_row_bytes;
    if (at >= texels.size()) return;
    const auto piece = texels.subspan(at, std::min(tile_row_bytes, texels.size() - at));
    std::vector<std::byte>& tile = level.tiles[static_cast<std::size_t>(y / kPartTile * level.columns + column)];
    std::copy(piece.begin(), piece.end(),
              tile.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y % kPartTile) * tile_row_bytes));
  }
}

// The rows that the filter finishes, quantised as a build does; kept when there is room for them.
class QuantisingSink final : public pyramid::RowSink {
 public:
  QuantisingSink(const channels::ChannelCodec& codec, std::int64_t width, bool base_passes, std::vector<LevelTiles>* kept)
      : codec_(codec), base_passes_(base_passes), kept_(kept), texel_bytes_(format_info(codec.parts().front().texel_format).block_bytes) {
    texels_.resize(static_cast<std::size_t>(width) * texel_bytes_);
  }
  void set_cascade(const pyramid::Cascade& cascade) { cascade_ = &cascade; }
  [[nodiscard]] const Result<void>& status() const { return status_; }
  void row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) override {
    if (k == 0 && base_passes_) return;
    const std::int64_t width = cascade_->level(k).core.width;
    if (status_) status_ = codec_.encode_row(0, rows, width, texels_.data());
    if (kept_ != nullptr)
      keep_row((*kept_)[static_cast<std::size_t>(k)], y, std::span(texels_).first(static_cast<std::size_t>(width) * texel_bytes_),
               texel_bytes_);
  }

 private:
  const channels::ChannelCodec& codec_;
  bool base_passes_;
  std::vector<LevelTiles>* kept_;
  std::size_t texel_bytes_;
  std::vector<std::byte> texels_;
  const pyramid::Cascade* cascade_ = nullptr;
  Result<void> status_;
};

// Adds up the time between start() and stop().
class StopWatch {
 public:
  void start() { since_ = Clock::now(); }
  void stop() { seconds_ += std::chrono::duration<double>(Clock::now() - since_).count(); }
  [[nodiscard]] double seconds() const { return seconds_; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point since_;
  double seconds_ = 0.0;
};

// `work` starts and stops the watch itself.
template <class Work>
Result<double> median_seconds(int runs, const Work& work) {
  std::vector<double> seconds;
  for (int i = 0; i <= runs; ++i) {  // the first is a warm-up
    VT_CHECK(check_interrupt());
    StopWatch watch;
    VT_CHECK(work(watch));
    if (i > 0) seconds.push_back(watch.seconds());
  }
  return spread_of(std::move(seconds)).median;
}

template <class Use>
Result<void> for_each_chunk(const TexelRect& rect, const Use& use) {
  for (std::int64_t y = rect.y; y < rect.bottom(); y += kChunkRows)
    VT_CHECK(use(TexelRect{rect.x, y, rect.width, std::min(kChunkRows, rect.bottom() - y)}));
  return {};
}

// All samples in the order of a build: blocks of the window's width, each by chunks of rows.
Result<double> read_seconds(const pipeline::LayerPlan& plan, int runs) {
  const std::int64_t width = plan.info.data.width;
  const std::int64_t height = plan.info.data.height;
  return median_seconds(runs, [&](StopWatch& watch) -> Result<void> {
    resample::BaseChunk chunk;
    watch.start();
    for (std::int64_t y = 0; y < height; y += kWindow)
      for (std::int64_t x = 0; x < width; x += kWindow)
        VT_CHECK(for_each_chunk({x, y, std::min(kWindow, width - x), std::min(kWindow, height - y)},
                                [&](const TexelRect& rect) { return plan.sampler->load(rect, chunk); }));
    watch.stop();
    return {};
  });
}

// `bytes` bytes through the hash of contents or records; they are the same function.
Result<double> hash_seconds(double bytes, int runs) {
  const std::vector<std::byte> buffer(kTransfer, std::byte{0x5A});
  const auto rounds = static_cast<std::uint64_t>(bytes / static_cast<double>(kTransfer)) + 1;
  store::ContentHasher hasher;
  return median_seconds(runs, [&](StopWatch& watch) -> Result<void> {
    watch.start();
    for (std::uint64_t i = 0; i < rounds; ++i) hasher.add(buffer);
    watch.stop();
    return {};
  });
}

struct WriteSeconds {
  double write = 0.0;
  double sync = 0.0;
};

Result<WriteSeconds> write_seconds(const std::filesystem::path& path, std::uint64_t bytes, int runs) {
  const std::vector<std::byte> buffer(kTransfer, std::byte{0x5A});
  std::vector<double> syncs;
  WriteSeconds seconds;
  VT_ASSIGN(
      seconds.write, median_seconds(runs, [&](StopWatch& watch) -> Result<void> {
        std::filesystem::remove(path);
        VT_ASSIGN(store::File file, store::File::open(path, store::File::Mode::kCreate));
        watch.start();
        for (std::uint64_t at = 0; at < bytes; at += kTransfer)
          VT_CHECK(file.write_at(at, std::span(buffer).first(static_cast<std::size_t>(std::min<std::uint64_t>(kTransfer, bytes - at)))));
        watch.stop();
        StopWatch sync;
        sync.start();
        VT_CHECK(file.sync());
        sync.stop();
        syncs.push_back(sync.seconds());
        return file.close();
      }));
  std::filesystem::remove(path);
  seconds.sync = spread_of(std::move(syncs)).median;
  return seconds;
}

Result<pipeline::LayerPlan> plan_for(const std::filesystem::path& input, const JobKind& job) {
  const auto channel = channels::find_channel(job.channel);
  if (!channel) return fail(ErrorCode::kInternal, "no channel is called " + job.channel);
  pipeline::LayerRequest request;
  request.name = job.channel;
  request.channel = channel->type;
  request.sources.push_back({.path = input, .fallback_crs = geo::Crs::from_text("pixel").value()});
  request.kernel = job.kernel;
  request.format = format_from_name(job.format);
  request.compression = job.compression;
  request.tile_texels = kPartTile;
  return pipeline::plan_layer(request, std::nullopt, std::size_t{64} << 20);
}

// The window of a plan and what the filter makes of it.
class Window {
 public:
  explicit Window(const pipeline::LayerPlan& plan) : plan_(plan) {
    const TexelRect& data = plan.info.data;
    place_ = {(data.width - std::min(data.width, kWindow)) / 2, (data.height - std::min(data.height, kWindow)) / 2,
              std::min(data.width, kWindow), std::min(data.height, kWindow)};
    while ((std::min(place_.width, place_.height) >> outputs_) >= 1 &&
           (std::max(place_.width, place_.height) >> (outputs_ - 1)) > kPartTile)
      ++outputs_;
  }
  [[nodiscard]] double texels() const { return static_cast<double>(place_.width) * static_cast<double>(place_.height); }

  [[nodiscard]] Result<double> filter_seconds(int runs) const {
    return median_seconds(runs, [&](StopWatch& watch) { return filter(watch, nullptr); });
  }
  // Texels of all levels in whole tiles.
  [[nodiscard]] Result<Tiles> tiles() const {
    const std::size_t texel_bytes = format_info(plan_.sampler->codec().parts().front().texel_format).block_bytes;
    std::vector<LevelTiles> levels;
    for (int k = 0; k < outputs_; ++k) levels.push_back(room_for(place_.width >> k, place_.height >> k, texel_bytes));
    StopWatch ignored;
    VT_CHECK(filter(ignored, &levels));
    Tiles all;
    for (LevelTiles& level : levels)
      for (std::vector<std::byte>& tile : level.tiles) all.push_back(std::move(tile));
    return all;
  }

 private:
  // Time runs while rows are decoded and filtered, not while they are read.
  Result<void> filter(StopWatch& watch, std::vector<LevelTiles>* kept) const {
    const channels::ChannelCodec& codec = plan_.sampler->codec();
    const std::size_t texel_bytes = format_info(codec.parts().front().texel_format).block_bytes;
    const bool base_passes = plan_.sampler->passes_texels();
    // The window is an image of its own: its place would only add a misaligned first row and column.
    const TexelRect whole{0, 0, place_.width, place_.height};
    pyramid::PlaneCascade cascade(pyramid::plan_block(whole, whole, outputs_, false, plan_.kernel), {.data = whole}, outputs_,
                                  {codec.rules(), codec.weight_plane()}, plan_.kernel, plan_.info.tile_exponent);
    QuantisingSink sink(codec, place_.width, base_passes, kept);
    sink.set_cascade(cascade);
    resample::BaseChunk chunk;
    return for_each_chunk(place_, [&](const TexelRect& rect) -> Result<void> {
      VT_CHECK(plan_.sampler->load(rect, chunk));
      watch.start();
      for (std::int64_t row = 0; row < rect.height; ++row) {
        const channels::PlaneRow planes = cascade.begin_row();
        const bool opaque = chunk.decode_row(row, planes);
        cascade.end_row(opaque, sink);
        if (kept != nullptr && base_passes)
          keep_row(kept->front(), rect.y - place_.y + row,
                   std::span(chunk.texel_row(row), static_cast<std::size_t>(place_.width) * texel_bytes), texel_bytes);
      }
      watch.stop();
      return sink.status();
    });
  }

  const pipeline::LayerPlan& plan_;
  TexelRect place_;
  int outputs_ = 1;
};

Result<double> bc1_seconds(const Tiles& tiles, Tiles& blocks, int runs) {
  return median_seconds(runs, [&](StopWatch& watch) -> Result<void> {
    watch.start();
    for (std::size_t i = 0; i < blocks.size(); ++i) encode::encode_bc1_image(tiles[i], kPartTile, kPartTile, kPartTile * 3, 3, blocks[i]);
    watch.stop();
    return {};
  });
}

Result<double> compress_seconds(const Tiles& payloads, const pipeline::LayerPlan& plan, int runs) {
  const store::TileShape shape = store::tile_shape(plan.info.format, plan.info.tile_texels());
  std::vector<std::byte> scratch;
  return median_seconds(runs, [&](StopWatch& watch) -> Result<void> {
    watch.start();
    for (const std::vector<std::byte>& payload : payloads) VT_CHECK(store::encode_payload(payload, shape, plan.compression, scratch));
    watch.stop();
    return {};
  });
}

}  // namespace

struct PartsBench::Impl {
  std::filesystem::path input;
  std::filesystem::path scratch;
  int runs = 1;
  std::optional<double> read;  // the same for every job of a channel, and an input has one channel
};

PartsBench::PartsBench(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PartsBench::PartsBench(PartsBench&&) noexcept = default;
PartsBench& PartsBench::operator=(PartsBench&&) noexcept = default;
PartsBench::~PartsBench() = default;

Result<PartsBench> PartsBench::prepare(const std::filesystem::path& input, const std::filesystem::path& scratch, int runs) {
  auto impl = std::make_unique<Impl>();
  impl->input = input;
  impl->scratch = scratch;
  impl->runs = runs;
  return PartsBench(std::move(impl));
}

Result<PartSeconds> PartsBench::measure(const JobKind& job, std::uint64_t output_bytes) {
  Impl& impl = *impl_;
  VT_ASSIGN(const pipeline::LayerPlan plan, plan_for(impl.input, job));
  if (!impl.read) {
    VT_ASSIGN(impl.read, read_seconds(plan, impl.runs));
  }
  PartSeconds parts;
  parts.read = *impl.read;
  const double base_texels = static_cast<double>(plan.info.data.width) * static_cast<double>(plan.info.data.height);
  const double sample_bytes_in_all =
      base_texels * static_cast<double>(format_info(plan.sampler->codec().parts().front().texel_format).block_bytes);

  const Window window(plan);
  VT_ASSIGN(const double filter, window.filter_seconds(impl.runs));
  parts.filter = filter * base_texels / window.texels();

  const bool is_bc1 = plan.info.format == TexelFormat::kBc1;
  const bool is_compressed = plan.compression.codec != store::Codec::kRaw;
  if (is_bc1 || is_compressed) {
    VT_ASSIGN(Tiles payloads, window.tiles());
    const double per_pyramid =
        static_cast<double>(pipeline::plan_cost(plan.info).texels) / (static_cast<double>(payloads.size()) * kPartTile * kPartTile);
    if (is_bc1) {
      Tiles blocks(payloads.size(), std::vector<std::byte>(plan.info.tile_payload_bytes()));
      VT_ASSIGN(const double encode, bc1_seconds(payloads, blocks, impl.runs));
      parts.encode = encode * per_pyramid;
      payloads = std::move(blocks);
    }
    if (is_compressed) {
      VT_ASSIGN(const double compress, compress_seconds(payloads, plan, impl.runs));
      parts.compress = compress * per_pyramid;
    }
  }
  VT_ASSIGN(const WriteSeconds written, write_seconds(impl.scratch / "bytes", output_bytes, impl.runs));
  parts.write = written.write;
  parts.sync = written.sync;
  VT_ASSIGN(parts.hash, hash_seconds(sample_bytes_in_all + static_cast<double>(output_bytes), impl.runs));
  return parts;
}

}  // namespace vt::bench
