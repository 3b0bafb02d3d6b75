#include "tools/bench_parts.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "builder/encode/bc1_encoder.h"
#include "builder/pipeline/layer_plan.h"
#include "builder/pipeline/plan_cost.h"
#include "builder/pyramid/block_cascade.h"
#include "store/file.h"
#include "tools/bench_support.h"

namespace vt::bench {
namespace {

constexpr std::int64_t kWindow = 4096;
constexpr std::int64_t kTile = 256;
constexpr std::size_t kTransfer = std::size_t{1} << 20;  // bytes a read or write call

// The rows that the filter finishes, quantised as a build does, and forgotten.
class QuantisingSink final : public pyramid::RowSink {
 public:
  QuantisingSink(const channels::ChannelCodec& codec, std::int64_t width, bool base_passes)
      : codec_(codec),
        base_passes_(base_passes),
        texels_(static_cast<std::size_t>(width) * format_info(codec.texel_format()).block_bytes) {}
  void set_cascade(const pyramid::BlockCascade& cascade) { cascade_ = &cascade; }
  void row(int k, std::int64_t /*y*/, const channels::RowNeighbourhood& rows) override {
    if (k > 0 || !base_passes_) codec_.encode_row(rows, cascade_->level(k).core.width, texels_.data());
  }

 private:
  const channels::ChannelCodec& codec_;
  bool base_passes_;
  std::vector<std::byte> texels_;
  const pyramid::BlockCascade* cascade_ = nullptr;
};

template <class Work>
Result<double> median_seconds(int runs, const Work& work) {
  std::vector<double> seconds;
  for (int i = 0; i <= runs; ++i) {  // the first is a warm-up
    VT_CHECK(check_interrupt());
    Result<void> status;
    const double taken = seconds_of([&] { status = work(); });
    VT_CHECK(status);
    if (i > 0) seconds.push_back(taken);
  }
  return spread_of(std::move(seconds)).median;
}

Result<void> read_all(const std::filesystem::path& path) {
  VT_ASSIGN(const store::File file, store::File::open(path, store::File::Mode::kRead));
  VT_ASSIGN(const std::uint64_t bytes, file.size());
  std::vector<std::byte> buffer(kTransfer);
  for (std::uint64_t at = 0; at < bytes; at += kTransfer)
    VT_CHECK(file.read_at(at, std::span(buffer).first(static_cast<std::size_t>(std::min<std::uint64_t>(kTransfer, bytes - at)))));
  return {};
}

Result<void> write_all(const std::filesystem::path& path, std::uint64_t bytes) {
  std::filesystem::remove(path);
  VT_ASSIGN(store::File file, store::File::open(path, store::File::Mode::kCreate));
  const std::vector<std::byte> buffer(kTransfer, std::byte{0x5A});
  for (std::uint64_t at = 0; at < bytes; at += kTransfer)
    VT_CHECK(file.write_at(at, std::span(buffer).first(static_cast<std::size_t>(std::min<std::uint64_t>(kTransfer, bytes - at)))));
  VT_CHECK(file.sync());
  return file.close();
}

Result<pipeline::LayerPlan> plan_for(const std::filesystem::path& input, const JobKind& job) {
  pipeline::LayerRequest request;
  request.name = "color";
  request.sources.push_back({.path = input, .fallback_crs = geo::Crs::from_text("pixel").value()});
  request.kernel = job.kernel;
  request.format = format_from_name(job.format);
  request.compression = job.compression;
  request.tile_texels = kTile;
  return pipeline::plan_layer(request, std::nullopt, std::size_t{16} << 20);
}

}  // namespace

struct PartsBench::Impl {
  std::filesystem::path input;
  std::filesystem::path scratch;
  int runs = 1;
  double read_seconds = 0.0;

  // The window: its place in the data, its samples (which lean on the codec of the plan that loaded them), and its tiles as RGB texels.
  std::optional<pipeline::LayerPlan> loaded_by;
  TexelRect window;
  resample::BaseChunk chunk;
  std::vector<std::vector<std::byte>> rgb_tiles;
  double base_texels = 0.0;
  double pyramid_texels = 0.0;

  Result<void> cut_tiles(const channels::ChannelCodec& codec);
  Result<double> filter_seconds(const pipeline::LayerPlan& plan);
};

PartsBench::PartsBench(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PartsBench::PartsBench(PartsBench&&) noexcept = default;
PartsBench& PartsBench::operator=(PartsBench&&) noexcept = default;
PartsBench::~PartsBench() = default;

// Whole tiles of the window, RGB; a window smaller than a tile gives one tile, its texels repeated.
Result<void> PartsBench::Impl::cut_tiles(const channels::ChannelCodec& codec) {
  const std::size_t texel_bytes = format_info(codec.texel_format()).block_bytes;
  const std::int64_t columns = std::max<std::int64_t>(window.width / kTile, 1);
  const std::int64_t rows = std::max<std::int64_t>(window.height / kTile, 1);
  rgb_tiles.assign(static_cast<std::size_t>(columns * rows), std::vector<std::byte>(static_cast<std::size_t>(kTile * kTile * 3)));

  // Rows through the codec, so that any source (16 bits, grey, resampled) becomes texels in the way a build makes them.
  std::vector<std::vector<float>> planes(static_cast<std::size_t>(codec.planes()),
                                         std::vector<float>(static_cast<std::size_t>(window.width + 2)));
  channels::PlaneRow into{};
  channels::ConstPlaneRow from{};
  for (std::size_t p = 0; p < planes.size(); ++p) from[p] = into[p] = planes[p].data() + 1;
  std::vector<std::byte> texels(static_cast<std::size_t>(window.width) * texel_bytes);
  for (std::int64_t y = 0; y < rows * kTile; ++y) {
    const bool opaque = chunk.decode_row(y % window.height, into);
    codec.encode_row({from, from, from, opaque}, window.width, texels.data());
    for (std::int64_t x = 0; x < columns * kTile; ++x) {
      std::byte* out = rgb_tiles[static_cast<std::size_t>(y / kTile * columns + x / kTile)].data() + (y % kTile * kTile + x % kTile) * 3;
      std::copy_n(texels.data() + static_cast<std::size_t>(x % window.width) * texel_bytes, 3, out);
    }
  }
  return {};
}

Result<double> PartsBench::Impl::filter_seconds(const pipeline::LayerPlan& plan) {
  const channels::ChannelCodec& codec = plan.sampler->codec();
  int outputs = 1;
  while ((std::min(window.width, window.height) >> outputs) >= 1 && (std::max(window.width, window.height) >> (outputs - 1)) > kTile)
    ++outputs;
  return median_seconds(runs, [&]() -> Result<void> {
    pyramid::BlockCascade cascade(pyramid::plan_block(window, window, outputs, false, plan.kernel), codec.planes(), plan.kernel);
    QuantisingSink sink(codec, window.width, plan.sampler->passes_texels());
    sink.set_cascade(cascade);
    for (std::int64_t y = 0; y < window.height; ++y) {
      const channels::PlaneRow row = cascade.begin_row();
      const bool opaque = chunk.decode_row(y, row);
      cascade.end_row(opaque, sink);
    }
    return {};
  });
}

Result<PartsBench> PartsBench::prepare(const std::filesystem::path& input, const std::filesystem::path& scratch, int runs) {
  auto impl = std::make_unique<Impl>();
  impl->input = input;
  impl->scratch = scratch;
  impl->runs = runs;
  VT_ASSIGN(impl->read_seconds, median_seconds(runs, [&] { return read_all(input); }));

  VT_ASSIGN(impl->loaded_by, plan_for(input, {"box", "rgb8", "none"}));
  const pipeline::LayerPlan& plan = *impl->loaded_by;
  const TexelRect& data = plan.info.data;
  const std::int64_t width = std::min(data.width, kWindow);
  const std::int64_t height = std::min(data.height, kWindow);
  impl->window = {(data.width - width) / 2, (data.height - height) / 2, width, height};
  VT_CHECK(plan.sampler->load(impl->window, impl->chunk));
  VT_CHECK(impl->cut_tiles(plan.sampler->codec()));
  // From here on the window is an image of its own: its place would only add a misaligned first row and column.
  impl->window.x = impl->window.y = 0;
  impl->base_texels = static_cast<double>(data.width) * static_cast<double>(data.height);
  impl->pyramid_texels = static_cast<double>(pipeline::plan_cost(plan.info).texels);
  return PartsBench(std::move(impl));
}

Result<PartSeconds> PartsBench::measure(const JobKind& job, std::uint64_t output_bytes) {
  Impl& impl = *impl_;
  PartSeconds parts;
  parts.read = impl.read_seconds;

  VT_ASSIGN(const pipeline::LayerPlan plan, plan_for(impl.input, job));
  VT_ASSIGN(const double filter, impl.filter_seconds(plan));
  parts.filter = filter * impl.base_texels / (static_cast<double>(impl.window.width) * static_cast<double>(impl.window.height));

  const double per_pyramid = impl.pyramid_texels / (static_cast<double>(impl.rgb_tiles.size()) * kTile * kTile);
  const std::vector<std::vector<std::byte>>* payloads = &impl.rgb_tiles;
  std::vector<std::vector<std::byte>> blocks;
  if (plan.info.format == TexelFormat::kBc1) {
    blocks.assign(impl.rgb_tiles.size(), std::vector<std::byte>(plan.info.tile_payload_bytes()));
    VT_ASSIGN(const double encode, median_seconds(impl.runs, [&]() -> Result<void> {
                for (std::size_t i = 0; i < blocks.size(); ++i)
                  encode::encode_bc1_image(impl.rgb_tiles[i], kTile, kTile, kTile * 3, 3, blocks[i]);
                return {};
              }));
    parts.encode = encode * per_pyramid;
    payloads = &blocks;
  }
  if (plan.compression.codec != store::Codec::kRaw) {
    const store::TileShape shape = store::tile_shape(plan.info.format, plan.info.tile_texels());
    VT_ASSIGN(const double compress, median_seconds(impl.runs, [&]() -> Result<void> {
                for (const std::vector<std::byte>& payload : *payloads) VT_CHECK(store::encode_payload(payload, shape, plan.compression));
                return {};
              }));
    parts.compress = compress * per_pyramid;
  }
  const auto target = impl.scratch / "bytes";
  VT_ASSIGN(parts.write, median_seconds(impl.runs, [&] { return write_all(target, output_bytes); }));
  std::filesystem::remove(target);
  return parts;
}

}  // namespace vt::bench
