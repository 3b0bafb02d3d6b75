#include "runtime/virtual_texture.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <mutex>
#include <numeric>
#include <optional>

#include "runtime/gl12_backend.h"
#include "runtime/glsl_backend.h"
#include "runtime/residency.h"
#include "runtime/selection.h"
#include "runtime/sub_load.h"
#include "runtime/tile_loader.h"

namespace vt::runtime {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr int kMostUnits = 64;

std::uint64_t bytes_of(const VtLayout& layout, TexelFormat format) {
  std::uint64_t bytes = 0;
  for (const LevelLayout& level : layout.levels)
    bytes += std::uint64_t{2} * static_cast<unsigned>(level.tiles_per_side * level.tiles_per_side) *
             tile_bytes(format_info(format), level.tile_exponent, level.mips);
  return bytes;
}

TexelFormat format_in_memory(TexelFormat format, bool decoded) { return decoded ? format_info(format).decoded_to : format; }

}  // namespace

struct VirtualTexture::Impl {
  Impl(std::shared_ptr<TileSource> tile_source, const Area& dataset, LayerInfo layer_info, Options opts, VtLayout layout)
      : source(std::move(tile_source)),
        info(std::move(layer_info)),
        options(std::move(opts)),
        mapping(dataset, info),
        st_from_uv(mapping.st_from_uv()),
        residency(std::move(layout)),
        controller(options.upload_budget_bytes, options.upload_budget_seconds),
        level_centers(residency.layout().levels.size()) {
    requests.reserve(residency.slots().size());
    arrived.reserve(static_cast<std::size_t>(std::max(options.staging_tiles, 1)));
  }

  std::shared_ptr<TileSource> source;
  LayerInfo info;
  Options options;
  VtMapping mapping;
  VtMapping::Affine st_from_uv;
  Residency residency;
  SubLoadController controller;

  // Written from any thread.
  std::mutex center_mutex;
  Point2 center{0.5, 0.5};
  std::vector<std::optional<Point2>> level_centers;
  std::optional<std::pair<std::size_t, double>> new_budget;

  // GL thread only, from here on.
  bool attached = false;
  GlHost host;
  GlTextures textures;
  Gl12Backend gl12;
  GlslBackend glsl;
  Gl12Backend::Upload upload;
  std::vector<std::array<unsigned, 2>> names;  // the two textures of each slot
  std::unique_ptr<TileLoader> loader;
  LoaderCounters past_loaders;

  std::vector<TileRequest> requests;
  std::vector<TileImage*> arrived;  // in memory, waiting for their turn
  TileImage* current = nullptr;     // being sent, band by band
  BandCursor cursor;
  bool must_post = false;

  std::array<unsigned, kMostUnits> bound{};  // by bind(), on each unit; 0 unknown
  unsigned bound_fixed = 0;
  int binds = 0;
  std::uint64_t frame = 0;

  int move_levels();
  void post_requests();
  void take_arrivals();
  bool next_image();
  void send(FrameStats& stats);
  [[nodiscard]] bool is_stale(const TileImage& image) const {
    const Slot& slot = residency.slot(image.slot);
    return slot.ticket != image.ticket || !slot.wants_load();
  }
  void drop_loader();
};

Result<VirtualTexture> VirtualTexture::open(const std::filesystem::path& path, Options options) {
  VT_ASSIGN(store::StoreReader reader, store::StoreReader::open(path));
  return open(std::make_shared<const store::StoreReader>(std::move(reader)), std::move(options));
}

Result<VirtualTexture> VirtualTexture::open(std::shared_ptr<const store::StoreReader> reader, Options options) {
  const LayerInfo* layer = nullptr;
  std::string have;
  for (const LayerInfo& candidate : reader->layers()) {
    if (candidate.role != LayerRole::kTexture) continue;
    have += (have.empty() ? "" : ", ") + candidate.name;
    if (layer == nullptr &&
        (options.layer.empty() ? candidate.channel == ChannelType::kColor && !candidate.is_part && candidate.has_known_format()
                               : candidate.name == options.layer))
      layer = &candidate;
  }
  if (layer == nullptr)
    return fail(ErrorCode::kUsage, reader->path().string() + ": no " +
                                       (options.layer.empty() ? "colour layer" : "layer \"" + options.layer + "\"") +
                                       "; it has: " + (have.empty() ? "none" : have));
  VT_CHECK(reader->check_readable(layer->id));
  const Area area = reader->description().area;
  auto source = std::make_shared<StoreTileSource>(reader, layer->id);
  return open(std::move(source), area, *layer, std::move(options));
}

Result<VirtualTexture> VirtualTexture::open(std::shared_ptr<TileSource> source, const Area& area, const LayerInfo& layer, Options options) {
  if (options.max_stages < 1 || options.max_stages > kMaxStages)
    return fail(ErrorCode::kUsage, "max_stages is 1 to 16; " + std::to_string(options.max_stages) + " was given");
  VT_ASSIGN(VtLayout layout, make_layout(layer, options.layout));
  return VirtualTexture(std::make_unique<Impl>(std::move(source), area, layer, std::move(options), std::move(layout)));
}

VirtualTexture::VirtualTexture(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VirtualTexture::VirtualTexture(VirtualTexture&&) noexcept = default;
VirtualTexture& VirtualTexture::operator=(VirtualTexture&&) noexcept = default;
VirtualTexture::~VirtualTexture() = default;

const LayerInfo& VirtualTexture::layer() const { return impl_->info; }
const VtMapping& VirtualTexture::mapping() const { return impl_->mapping; }

void VirtualTexture::set_center(Point2 uv) {
  if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return;
  const std::lock_guard lock(impl_->center_mutex);
  impl_->center = uv;
}

void VirtualTexture::set_level_center(Level level, Point2 uv) {
  if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return;
  const std::lock_guard lock(impl_->center_mutex);
  const std::vector<LevelLayout>& levels = impl_->residency.layout().levels;
  for (std::size_t i = 0; i < levels.size(); ++i)
    if (levels[i].level == level) impl_->level_centers[i] = uv;
}

void VirtualTexture::follow_center(Level level) {
  const std::lock_guard lock(impl_->center_mutex);
  const std::vector<LevelLayout>& levels = impl_->residency.layout().levels;
  for (std::size_t i = 0; i < levels.size(); ++i)
    if (levels[i].level == level) impl_->level_centers[i].reset();
}

void VirtualTexture::set_upload_budget(std::size_t bytes, double seconds) {
  const std::lock_guard lock(impl_->center_mutex);
  impl_->new_budget = {bytes, seconds};
}

Result<void> VirtualTexture::attach(const GlHost& host) {
  Impl& impl = *impl_;
  if (impl.attached) return fail(ErrorCode::kUsage, "already attached to a context; call detach() or context_lost() first");
  impl.host = host;
  impl.textures = {};
  const bool fixed = host.path == Path::kFixedFunction;
  VT_CHECK(fixed ? impl.gl12.load(host, impl.textures) : impl.glsl.load(host, impl.textures));
  const bool must_be_plain = impl.options.tint_levels;
  VT_ASSIGN(impl.upload,
            fixed ? impl.gl12.upload_for(impl.info.format, must_be_plain) : impl.glsl.upload_for(impl.info.format, must_be_plain));

  for (const Slot& slot : impl.residency.slots()) {
    const LevelLayout& level = impl.residency.layout().levels[static_cast<std::size_t>(slot.level)];
    std::array<unsigned, 2> pair{};
    for (unsigned& name : pair) {
      auto texture = impl.textures.create(impl.upload.pixel, format_info(impl.upload.format), level.tile_exponent, level.mips);
      if (!texture) {
        if (pair[0] != 0) impl.textures.destroy(pair[0]);
        for (const auto& both : impl.names)
          for (const unsigned made : both) impl.textures.destroy(made);
        impl.names.clear();
        return tl::unexpected(texture.error());
      }
      name = *texture;
    }
    impl.names.push_back(pair);
  }

  int largest_exponent = 0;
  int most_mips = 1;
  for (const LevelLayout& level : impl.residency.layout().levels) {
    largest_exponent = std::max(largest_exponent, level.tile_exponent);
    most_mips = std::max(most_mips, level.mips);
  }
  most_mips = std::min(most_mips, largest_exponent + 1);
  impl.loader = std::make_unique<TileLoader>(
      impl.source, TexelConversion{.source = impl.info.format, .target = impl.upload.format, .tint_levels = impl.options.tint_levels},
      largest_exponent, most_mips, impl.options.staging_tiles, impl.residency.slots().size());
  impl.residency.forget_content();
  impl.must_post = true;
  impl.attached = true;
  forget_bindings();
  return {};
}

void VirtualTexture::detach() {
  if (!impl_->attached) return;
  for (const auto& pair : impl_->names)
    for (const unsigned name : pair) impl_->textures.destroy(name);
  context_lost();
}

void VirtualTexture::context_lost() {
  if (!impl_->attached) return;
  impl_->attached = false;
  impl_->names.clear();
  impl_->drop_loader();
  impl_->residency.forget_content();
}

void VirtualTexture::Impl::drop_loader() {
  const LoaderCounters last = loader->counters();
  past_loaders.tiles_read += last.tiles_read;
  past_loaders.tiles_cancelled += last.tiles_cancelled;
  past_loaders.tiles_failed += last.tiles_failed;
  past_loaders.bytes_read += last.bytes_read;
  arrived.clear();
  current = nullptr;
  loader.reset();
}

// --- One update -----------------------------------------------------------------------------------------------------------------------

int VirtualTexture::Impl::move_levels() {
  const std::lock_guard lock(center_mutex);
  if (new_budget) controller.set_budget(new_budget->first, new_budget->second);
  new_budget.reset();
  int moved = 0;
  for (std::size_t i = 0; i < level_centers.size(); ++i) {
    const Point2 uv = level_centers[i].value_or(center);
    moved += residency.center_level(static_cast<int>(i), st_from_uv.scale_x * uv.x + st_from_uv.offset_x,
                                    st_from_uv.scale_y * uv.y + st_from_uv.offset_y)
                 ? 1
                 : 0;
  }
  return moved;
}

// Coarse levels first, so that something is there soon; on a level, what is near the center first.
void VirtualTexture::Impl::post_requests() {
  requests.clear();
  const VtLayout& layout = residency.layout();
  for (std::size_t i = 0; i < residency.slots().size(); ++i) {
    const Slot& slot = residency.slots()[i];
    const auto has_it = [&](const TileImage* image) {
      return image != nullptr && image->slot == static_cast<int>(i) && image->ticket == slot.ticket;
    };
    if (!slot.wants_load() || has_it(current) || std::any_of(arrived.begin(), arrived.end(), has_it)) continue;
    const LevelLayout& level = layout.levels[static_cast<std::size_t>(slot.level)];
    requests.push_back({.slot = static_cast<int>(i),
                        .ticket = slot.ticket,
                        .level = level,
                        .levels_from_finest = paper_level(level.level, layout.finest),
                        .origin = slot.target});
  }
  const auto distance = [&](const TileRequest& r) {
    const TexelOrigin box = residency.level_origin(residency.slot(r.slot).level);
    const std::int64_t half = (r.level.box_texels() - r.level.tile_texels()) / 2;
    return std::max(std::abs(r.origin.x - box.x - half), std::abs(r.origin.y - box.y - half));
  };
  std::sort(requests.begin(), requests.end(), [&](const TileRequest& a, const TileRequest& b) {
    if (a.level.level != b.level.level) return a.level.level < b.level.level;
    const std::int64_t da = distance(a);
    const std::int64_t db = distance(b);
    return da != db ? da < db : a.slot < b.slot;
  });
  loader->post(requests);
}

void VirtualTexture::Impl::take_arrivals() {
  while (TileImage* image = loader->take()) {
    if (!image->ok) residency.mark_failed(image->slot, image->ticket);
    if (!image->ok || is_stale(*image))
      loader->release(image);
    else
      arrived.push_back(image);
  }
}

// Makes `current` an image that is still wanted, the coarsest of those in memory. False when there is none.
bool VirtualTexture::Impl::next_image() {
  if (current != nullptr && is_stale(*current)) {
    loader->release(current);
    current = nullptr;
  }
  while (current == nullptr && !arrived.empty()) {
    const auto coarsest = std::max_element(arrived.begin(), arrived.end(), [&](const TileImage* a, const TileImage* b) {
      return residency.slot(a->slot).level < residency.slot(b->slot).level;
    });
    TileImage* image = *coarsest;
    arrived.erase(coarsest);
    if (is_stale(*image)) {
      loader->release(image);
      continue;
    }
    current = image;
    cursor = BandCursor(image->format, image->tile_exponent, image->mips);
  }
  return current != nullptr;
}

void VirtualTexture::Impl::send(FrameStats& stats) {
  stats.upload_budget = controller.bytes_per_update();
  bool begun = false;
  while (next_image()) {
    const std::size_t left = stats.upload_budget - stats.upload_bytes;
    const std::optional<Band> band = cursor.next(left);
    if (!band) break;
    if (!begun) textures.begin_uploads();
    begun = true;

    const Clock::time_point start = Clock::now();
    const auto slot = static_cast<std::size_t>(current->slot);
    const unsigned hidden = names[slot][static_cast<std::size_t>(1 - residency.slots()[slot].front)];
    textures.upload(hidden, upload.pixel, *band, current->bytes.data() + band->offset);
    controller.record(band->bytes, seconds_since(start));
    stats.upload_bytes += band->bytes;
    ++stats.upload_calls;

    if (cursor.done()) {
      residency.swap(current->slot, current->ticket);
      ++stats.pages_completed;
      loader->release(current);
      current = nullptr;
    }
  }
  if (begun) textures.end_uploads();
}

FrameStats VirtualTexture::update() {
  Impl& impl = *impl_;
  const Clock::time_point start = Clock::now();
  FrameStats stats{.frame = impl.frame++};
  if (!impl.attached) return stats;

  stats.levels_moved = impl.move_levels();
  impl.take_arrivals();
  if (stats.levels_moved > 0 || impl.must_post) impl.post_requests();
  impl.must_post = false;
  impl.send(stats);

  stats.tiles_waiting = impl.residency.waiting();
  stats.loader_pending = impl.loader->pending() + impl.arrived.size() + (impl.current != nullptr ? 1 : 0);
  stats.binds = impl.binds;
  impl.binds = 0;
  forget_bindings();
  stats.seconds = seconds_since(start);
  return stats;
}

bool VirtualTexture::settled() const {
  const std::span<const Slot> slots = impl_->residency.slots();
  return impl_->attached && std::all_of(slots.begin(), slots.end(), [](const Slot& slot) { return slot.has_target && !slot.wants_load(); });
}

LoaderCounters VirtualTexture::loader_counters() const {
  LoaderCounters sum = impl_->past_loaders;
  if (!impl_->loader) return sum;
  const LoaderCounters now = impl_->loader->counters();
  sum.tiles_read += now.tiles_read;
  sum.tiles_cancelled += now.tiles_cancelled;
  sum.tiles_failed += now.tiles_failed;
  sum.bytes_read += now.bytes_read;
  return sum;
}

std::string VirtualTexture::last_error() const { return impl_->loader ? impl_->loader->last_error() : std::string(); }

// --- Drawing --------------------------------------------------------------------------------------------------------------------------

StageSet VirtualTexture::select(const UvBox& box, int most_stages) const {
  const VtMapping::Affine& a = impl_->st_from_uv;
  const Box st{.s_min = a.scale_x * box.u_min + a.offset_x,
               .t_min = a.scale_y * box.v_min + a.offset_y,
               .s_max = a.scale_x * box.u_max + a.offset_x,
               .t_max = a.scale_y * box.v_max + a.offset_y};
  const int cap = most_stages > 0 ? std::min(most_stages, kMaxStages) : impl_->options.max_stages;
  return impl_->host.path == Path::kFixedFunction ? select_one(impl_->residency.selectable(), st)
                                                  : select_stages(impl_->residency.selectable(), st, cap);
}

void VirtualTexture::bind(const StageSet& tiles, Point2 uv_origin) {
  Impl& impl = *impl_;
  if (!impl.attached || tiles.count == 0) return;
  assert(impl.host.path == Path::kFixedFunction);
  const auto index = static_cast<std::size_t>(tiles.slots[0]);
  const Slot& slot = impl.residency.slots()[index];
  const unsigned texture = impl.names[index][static_cast<std::size_t>(slot.front)];
  const TileMatrix matrix =
      tile_matrix(impl.residency.layout(), impl.residency.level_of(tiles.slots[0]), slot.shown, impl.st_from_uv, uv_origin);
  const bool already_bound = impl.bound_fixed == texture;
  impl.gl12.bind(impl.textures, texture, already_bound, matrix);
  impl.binds += already_bound ? 0 : 1;
  impl.bound_fixed = texture;
}

std::string VirtualTexture::glsl_function(std::string_view name, int stages) { return glsl_function_text(name, stages); }

Result<ShaderBinding> VirtualTexture::shader_binding(unsigned program, std::string_view name, int first_unit, int stages) {
  if (!impl_->attached || impl_->host.path != Path::kShader)
    return fail(ErrorCode::kUsage, "shader_binding() needs a virtual texture that is attached with Path::kShader");
  if (first_unit + stages > kMostUnits) return fail(ErrorCode::kUsage, "texture units beyond 64 are not supported");
  return impl_->glsl.binding(program, name, first_unit, stages);
}

void VirtualTexture::bind(const ShaderBinding& binding, const StageSet& tiles, Point2 uv_origin) {
  Impl& impl = *impl_;
  if (!impl.attached) return;
  assert(impl.host.path == Path::kShader && tiles.count <= binding.stages);
  for (int stage = 0; stage < binding.stages; ++stage) {
    if (stage >= tiles.count) {
      impl.glsl.mask(binding, stage);
      continue;
    }
    const int slot_index = tiles.slots[static_cast<std::size_t>(stage)];
    const Slot& slot = impl.residency.slot(slot_index);
    const unsigned texture = impl.names[static_cast<std::size_t>(slot_index)][static_cast<std::size_t>(slot.front)];
    const int unit = binding.first_unit + stage;
    unsigned& bound = impl.bound[static_cast<std::size_t>(unit)];
    if (bound != texture) {
      impl.glsl.bind_unit(impl.textures, unit, texture);
      ++impl.binds;
      bound = texture;
    }
    impl.glsl.set_map(binding, stage,
                      tile_matrix(impl.residency.layout(), impl.residency.level_of(slot_index), slot.shown, impl.st_from_uv, uv_origin));
  }
  impl.glsl.leave_unit_zero_active();
}

void VirtualTexture::forget_bindings() {
  impl_->bound.fill(0);
  impl_->bound_fixed = 0;
}

std::vector<VirtualTexture::TileState> VirtualTexture::tiles() const {
  std::vector<TileState> states;
  for (std::size_t i = 0; i < impl_->residency.slots().size(); ++i) {
    const Slot& slot = impl_->residency.slots()[i];
    const LevelLayout& level = impl_->residency.layout().levels[static_cast<std::size_t>(slot.level)];
    states.push_back({.level = level.level,
                      .x = slot.shown.x,
                      .y = slot.shown.y,
                      .texels = level.tile_texels(),
                      .mips = level.mips,
                      .shown = slot.is_shown,
                      .gl_texture = impl_->names.empty() ? 0 : impl_->names[i][static_cast<std::size_t>(slot.front)]});
  }
  return states;
}

std::uint64_t VirtualTexture::texture_bytes() const {
  return impl_->attached ? bytes_of(impl_->residency.layout(), impl_->upload.format) : 0;
}

void sort_by_tile(std::span<const StageSet> draws, std::span<std::uint32_t> order) {
  assert(draws.size() == order.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const auto tiles_of = [&](std::uint32_t i) { return std::span(draws[i].slots).first(static_cast<std::size_t>(draws[i].count)); };
    const auto ta = tiles_of(a);
    const auto tb = tiles_of(b);
    const auto [ia, ib] = std::mismatch(ta.begin(), ta.end(), tb.begin(), tb.end());
    if (ia != ta.end() && ib != tb.end()) return *ia < *ib;
    if (ta.size() != tb.size()) return ta.size() < tb.size();
    return a < b;
  });
}

// --- Memory ---------------------------------------------------------------------------------------------------------------------------

Result<std::uint64_t> texture_bytes(const LayerInfo& layer, const LayoutOptions& options, bool decoded) {
  VT_ASSIGN(const VtLayout layout, make_layout(layer, options));
  return bytes_of(layout, format_in_memory(layer.format, decoded));
}

Result<LayoutOptions> layout_for_budget(const LayerInfo& layer, std::uint64_t budget_bytes, bool decoded) {
  std::optional<LayoutOptions> best;
  std::int64_t best_texels = 0;
  // Large tiles first: of two layouts with as many texels the one of fewer tiles needs fewer binds.
  for (int exponent = 11; exponent >= 5; --exponent) {
    for (int side = 1; side <= 8; ++side) {
      const LayoutOptions options{.tile_exponent = exponent, .tiles_per_side = side, .overrides = {}};
      VT_ASSIGN(const std::uint64_t bytes, texture_bytes(layer, options, decoded));
      const std::int64_t texels = std::int64_t{side} << exponent;
      if (bytes > budget_bytes || texels <= best_texels) continue;
      best = options;
      best_texels = texels;
    }
  }
  if (!best)
    return fail(ErrorCode::kUsage, "no layout of this layer fits into " + std::to_string(budget_bytes) + " bytes of texture memory");
  return *best;
}

}  // namespace vt::runtime
