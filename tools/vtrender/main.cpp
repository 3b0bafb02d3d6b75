// vtrender: draws a store as terrain in perspective, without a window, through the runtime library and
// nothing else. Pictures, and frame times of a flight.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <thread>

#include "builder/geo/crs.h"
#include "builder/text/json_text.h"
#include "runtime/virtual_texture.h"
#include "store/store_reader.h"
#include "tools/cli/cli_support.h"
#include "tools/cli/open_store.h"
#include "tools/pictures/picture_writer.h"
#include "tools/vtrender/egl_context.h"
#include "tools/vtrender/gl_table.h"
#include "tools/vtrender/terrain.h"

namespace vt::tools {
namespace {

using Clock = std::chrono::steady_clock;

struct Flags {
  std::string store;
  std::string output;
  std::string layer;
  std::string elevation;  // empty: the first elevation layer, if any
  std::string path = "gl12";
  std::string camera;
  std::string size = "1280x720";
  double exaggerate = 1.0;
  std::uint64_t texture_mib = 256;
  int tiles_per_side = 0;
  int tile_texels = 0;
  int stages = 4;
  std::uint64_t budget_kib = 4096;
  bool no_extensions = false;
  bool tint_levels = false;
  int frames = 0;
  bool fly = false;
  double speed_m_s = 0.0;
  double rate_hz = 0.0;
  bool json = false;
};

constexpr const char* kExamples =
    "  vtrender scene.vts -o picture.png\n"
    "  vtrender scene.vts -o shader.png --path glsl --exaggerate 2 --size 1920x1080\n"
    "  vtrender scene.vts -o levels.png --tint-levels --camera 0.5,0.3,1200,0,-20,45\n"
    "  vtrender scene.vts --frames 600 --fly --json";

Result<std::pair<int, int>> parse_size(const std::string& text) {
  constexpr const char* kForm = "WIDTHxHEIGHT, 1 to 8192 pixels each, such as 1280x720";
  std::array<std::int64_t, 2> size{};
  VT_CHECK(cli::parse_integers(text, "--size", kForm, size, 'x'));
  for (const std::int64_t pixels : size)
    if (pixels < 1 || pixels > 8192) return fail(ErrorCode::kUsage, fmt::format("--size: found \"{}\", wanted {}", text, kForm));
  return std::pair(static_cast<int>(size[0]), static_cast<int>(size[1]));
}

Result<Camera> parse_camera(const std::string& text) {
  std::array<double, 6> numbers{};
  VT_CHECK(cli::parse_numbers(text, "--camera", "U,V,HEIGHT,HEADING,PITCH,FOV, six numbers", numbers));
  const auto [u, v, height_m, heading_deg, pitch_deg, fov_deg] = numbers;
  const Camera c{.u = u, .v = v, .height_m = height_m, .heading_deg = heading_deg, .pitch_deg = pitch_deg, .fov_deg = fov_deg};
  if (c.fov_deg <= 0.0 || c.fov_deg >= 170.0 || c.pitch_deg < -90.0 || c.pitch_deg > 90.0 || c.height_m <= 0.0)
    return fail(ErrorCode::kUsage, "--camera: the height is above 0, the pitch -90 to 90 degrees, the field of view 0 to 170 degrees");
  return c;
}

// Ground metres along u and v, at the middle of the area. A store without a place on the Earth counts in
// metres.
Result<Point2> ground_metres(const store::StoreReader& reader) {
  const Area& area = reader.description().area;
  const Point2 units{area.east - area.west, area.north - area.south};
  const nlohmann::json metadata = text::json_or_null(reader.description().metadata_json);
  if (!metadata.is_object() || !metadata.contains("crs")) return units;
  VT_ASSIGN(const geo::Crs crs, geo::Crs::from_json(metadata["crs"]));
  if (crs.kind() == geo::CrsKind::kPixel) return units;
  VT_ASSIGN(const Point2 metres, crs.metres_per_unit_at({(area.west + area.east) / 2.0, (area.south + area.north) / 2.0}));
  return Point2{units.x * metres.x, units.y * metres.y};
}

Result<std::optional<runtime::HeightField>> read_heights(const store::StoreReader& reader, const std::string& name) {
  if (name == "none") return std::optional<runtime::HeightField>();
  const LayerInfo* chosen = nullptr;
  for (const LayerInfo& layer : reader.layers())
    if (layer.role == LayerRole::kTexture && chosen == nullptr &&
        (name.empty() ? layer.channel == ChannelType::kElevation && !layer.is_part && layer.has_known_format() : layer.name == name))
      chosen = &layer;
  if (chosen == nullptr) {
    if (name.empty()) return std::optional<runtime::HeightField>();
    return fail(ErrorCode::kUsage,
                reader.path().string() + ": no layer \"" + name + "\" for --elevation; `vtinspect info` lists the layers");
  }
  VT_ASSIGN(runtime::HeightField heights, runtime::HeightField::read(reader, chosen->id, 1024));
  return std::optional<runtime::HeightField>(std::move(heights));
}

// `rgba` as glReadPixels gives it: rows from the bottom. Alpha is dropped.
Result<void> write_png(const std::filesystem::path& path, int width, int height, std::span<const std::uint8_t> rgba) {
  VT_ASSIGN(const auto picture, cli::create_picture(path, {.width = width, .height = height, .channels = 3}));
  std::vector<std::byte> row(static_cast<std::size_t>(width) * 3);
  for (int y = height - 1; y >= 0; --y) {
    const auto pixels = std::as_bytes(rgba).subspan(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) * 4);
    for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) std::copy_n(&pixels[x * 4], 3, &row[x * 3]);
    VT_CHECK(picture->write_rows(row, 1));
  }
  return picture->finish();
}

double percentile(std::vector<double> values, double part) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(part * static_cast<double>(values.size())))];
}

double milliseconds_since(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }

// Draws patches with the tiles that the virtual texture selects for them.
class Renderer {
 public:
  Result<void> start(runtime::VirtualTexture& texture, bool shader, int stages, int width, int height) {
    texture_ = &texture;
    shader_ = shader;
    width_ = width;
    height_ = height;
    if (const char* missing = gl_.load(EglContext::getproc, nullptr))
      return fail(ErrorCode::kUnsupported, std::string(missing) + " was not found");
    gl_.Viewport(0, 0, width, height);
    gl_.ClearColor(0.60F, 0.74F, 0.88F, 1.0F);
    gl_.Enable(gl::GL_DEPTH_TEST);
    gl_.DepthFunc(gl::GL_LEQUAL);
    gl_.EnableClientState(gl::GL_VERTEX_ARRAY);
    gl_.EnableClientState(gl::GL_TEXTURE_COORD_ARRAY);
    if (shader_) return make_program(stages);
    gl_.Enable(gl::GL_TEXTURE_2D);
    gl_.TexEnvi(gl::GL_TEXTURE_ENV, gl::GL_TEXTURE_ENV_MODE, static_cast<gl::GLint>(gl::GL_REPLACE));
    return {};
  }

  // What one picture was drawn with.
  struct Drawn {
    double select_bind_ms = 0.0;  // on the wall clock, apart from drawing
    std::size_t patches = 0;
    std::size_t bare = 0;         // patches for which no tile is loaded
    std::size_t tiles = 0;        // tile textures that some patch takes texels from
    std::vector<bool> at_levels;  // by level: some patch takes its finest texels from it
  };

  Drawn draw(const View& view, std::span<const Patch* const> patches) {
    Drawn drawn{.patches = patches.size()};
    gl_.Clear(gl::GL_COLOR_BUFFER_BIT | gl::GL_DEPTH_BUFFER_BIT);
    gl_.MatrixMode(gl::GL_PROJECTION);
    gl_.LoadMatrixd(view.clip_from_offset.data());
    gl_.MatrixMode(gl::GL_MODELVIEW);
    Clock::time_point start = Clock::now();
    sets_.clear();
    for (const Patch* patch : patches) sets_.push_back(texture_->select(patch->uv));
    order_.resize(sets_.size());
    runtime::sort_by_tile(sets_, order_);
    drawn.select_bind_ms += milliseconds_since(start);
    for (const std::uint32_t i : order_) {
      const Patch& patch = *patches[i];
      start = Clock::now();
      if (shader_)
        texture_->bind(binding_, sets_[i], patch.uv_origin);
      else
        texture_->bind(sets_[i], patch.uv_origin);
      drawn.select_bind_ms += milliseconds_since(start);
      const double move[16] = {
          1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, patch.origin.x - view.eye.x, patch.origin.y - view.eye.y, patch.origin.z - view.eye.z, 1};
      gl_.LoadMatrixd(move);
      gl_.VertexPointer(3, gl::GL_FLOAT, 0, patch.positions.data());
      gl_.TexCoordPointer(2, gl::GL_FLOAT, 0, patch.texcoords.data());
      gl_.DrawElements(gl::GL_TRIANGLES, static_cast<gl::GLsizei>(patch_indices().size()), gl::GL_UNSIGNED_SHORT, patch_indices().data());
    }
    gl_.Finish();
    count_tiles(drawn);
    return drawn;
  }

  [[nodiscard]] std::span<const runtime::StageSet> last_sets() const { return sets_; }

  std::vector<std::uint8_t> pixels() {
    std::vector<std::uint8_t> rgba(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 4);
    gl_.PixelStorei(gl::GL_PACK_ALIGNMENT, 1);
    gl_.ReadPixels(0, 0, width_, height_, gl::GL_RGBA, gl::GL_UNSIGNED_BYTE, rgba.data());
    return rgba;
  }

 private:
  void count_tiles(Drawn& drawn) {
    if (level_of_slot_.empty())
      for (const runtime::VirtualTexture::TileState& tile : texture_->tiles()) level_of_slot_.push_back(tile.level.value);
    std::vector<bool> is_drawn(level_of_slot_.size(), false);
    drawn.at_levels.assign(std::size_t{texture_->layer().finest.value} + 1, false);
    for (const runtime::StageSet& set : sets_) {
      const auto slots = std::span(set.slots).first(static_cast<std::size_t>(set.count));
      for (const int slot : slots) is_drawn[static_cast<std::size_t>(slot)] = true;
      if (slots.empty()) {
        ++drawn.bare;
      } else {
        drawn.at_levels[level_of_slot_[static_cast<std::size_t>(slots.front())]] = true;
      }
    }
    drawn.tiles = static_cast<std::size_t>(std::count(is_drawn.begin(), is_drawn.end(), true));
  }

  Result<void> make_program(int stages) {
    if (const char* missing = shaders_.load(EglContext::getproc, nullptr))
      return fail(ErrorCode::kUnsupported, std::string(missing) + " was not found");
    const std::string vertex = "#version 120\nvarying vec2 uv;\nvoid main() { uv = gl_MultiTexCoord0.xy; gl_Position = ftransform(); }\n";
    const std::string fragment = "#version 120\nvarying vec2 uv;\n" + runtime::VirtualTexture::glsl_function("vt_sample", stages) +
                                 "void main() { gl_FragColor = vt_sample(uv); }\n";
    const gl::GLuint program = shaders_.CreateProgram();
    for (const auto& [type, text] : {std::pair(gl::GL_VERTEX_SHADER, &vertex), std::pair(gl::GL_FRAGMENT_SHADER, &fragment)}) {
      const gl::GLuint shader = shaders_.CreateShader(type);
      const char* source = text->c_str();
      shaders_.ShaderSource(shader, 1, &source, nullptr);
      shaders_.CompileShader(shader);
      shaders_.AttachShader(program, shader);
    }
    shaders_.LinkProgram(program);
    gl::GLint linked = 0;
    shaders_.GetProgramiv(program, gl::GL_LINK_STATUS, &linked);
    if (linked == 0) {
      char log[1024] = {};
      shaders_.GetProgramInfoLog(program, sizeof log, nullptr, log);
      return fail(ErrorCode::kInternal, std::string("the shader does not link: ") + log);
    }
    shaders_.UseProgram(program);
    VT_ASSIGN(binding_, texture_->shader_binding(program, "vt_sample", 0, stages));
    return {};
  }

  runtime::VirtualTexture* texture_ = nullptr;
  bool shader_ = false;
  int width_ = 0;
  int height_ = 0;
  gl::FixedFunctions gl_;
  gl::ShaderFunctions shaders_;
  runtime::ShaderBinding binding_;
  std::vector<runtime::StageSet> sets_;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint8_t> level_of_slot_;
};

// What is printed of the frames of --frames.
class FrameReport {
 public:
  // `update` of this frame, `own_ms` of update, selection and binding together.
  void add(double frame_ms, const runtime::FrameStats& update, const Renderer::Drawn& drawn) {
    frame_ms_.push_back(frame_ms);
    update_ms_.push_back(update.seconds * 1e3);
    select_bind_ms_.push_back(drawn.select_bind_ms);
    own_ms_.push_back(update_ms_.back() + drawn.select_bind_ms);
    loaded_ += update.tiles_waiting == 0 && drawn.patches > 0 && drawn.bare == 0 ? 1 : 0;
    patches_ += drawn.patches;
    tiles_ += drawn.tiles;
    most_upload_ = std::max(most_upload_, update.upload_bytes);
    uploaded_ += update.upload_bytes;
    uploading_ += update.upload_bytes > 0 ? 1 : 0;
    pages_ += static_cast<std::uint64_t>(update.pages_completed);
    binds_ += static_cast<std::uint64_t>(update.binds);
    at_levels_.resize(std::max(at_levels_.size(), drawn.at_levels.size()));
    for (std::size_t level = 0; level < drawn.at_levels.size(); ++level) at_levels_[level] += drawn.at_levels[level] ? 1 : 0;
  }
  [[nodiscard]] bool empty() const { return frame_ms_.empty(); }

  [[nodiscard]] nlohmann::ordered_json json(std::size_t upload_budget) const {
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    for (std::size_t level = 0; level < at_levels_.size(); ++level)
      if (at_levels_[level] > 0) levels.push_back({{"level", level}, {"frames", at_levels_[level]}});
    return {{"count", frame_ms_.size()},
            {"loaded", loaded_},
            {"median_ms", percentile(frame_ms_, 0.5)},
            {"p99_ms", percentile(frame_ms_, 0.99)},
            {"max_ms", percentile(frame_ms_, 1.0)},
            {"own_median_ms", percentile(own_ms_, 0.5)},
            {"own_p99_ms", percentile(own_ms_, 0.99)},
            {"own_max_ms", percentile(own_ms_, 1.0)},
            {"update_median_ms", percentile(update_ms_, 0.5)},
            {"update_p99_ms", percentile(update_ms_, 0.99)},
            {"select_bind_median_ms", percentile(select_bind_ms_, 0.5)},
            {"select_bind_p99_ms", percentile(select_bind_ms_, 0.99)},
            {"mean_patches", mean(patches_)},
            {"mean_tiles", mean(tiles_)},
            {"mean_binds", mean(binds_)},
            {"levels", levels},
            {"uploading", uploading_},
            {"pages", pages_},
            {"upload_bytes", uploaded_},
            {"upload_most_bytes", most_upload_},
            {"upload_budget_bytes", upload_budget}};
  }

  [[nodiscard]] std::string text(std::size_t upload_budget) const {
    std::string levels;
    for (std::size_t level = at_levels_.size(); level-- > 0;)
      if (at_levels_[level] > 0) levels += fmt::format("{}{}", levels.empty() ? "" : ", ", level);
    return fmt::format(
        "{} frames, {} with every tile loaded: median {:.2f} ms, 99 % {:.2f} ms; of that update, selection and binding median {:.3f} ms, "
        "99 % "
        "{:.3f} ms\n{:.1f} patches from {:.1f} tiles and {:.1f} binds a frame, of levels {}; {} tiles uploaded in {} frames, {} in all, at "
        "most {} of {} a frame\n",
        frame_ms_.size(), loaded_, percentile(frame_ms_, 0.5), percentile(frame_ms_, 0.99), percentile(own_ms_, 0.5),
        percentile(own_ms_, 0.99), mean(patches_), mean(tiles_), mean(binds_), levels, pages_, uploading_, cli::format_bytes(uploaded_),
        cli::format_bytes(most_upload_), cli::format_bytes(upload_budget));
  }

 private:
  [[nodiscard]] double mean(std::uint64_t sum) const { return static_cast<double>(sum) / static_cast<double>(frame_ms_.size()); }

  std::vector<double> frame_ms_;
  std::vector<double> update_ms_;
  std::vector<double> select_bind_ms_;
  std::vector<double> own_ms_;
  std::uint64_t loaded_ = 0;
  std::uint64_t patches_ = 0;
  std::uint64_t tiles_ = 0;
  std::uint64_t binds_ = 0;
  std::uint64_t pages_ = 0;
  std::uint64_t uploading_ = 0;
  std::uint64_t uploaded_ = 0;
  std::size_t most_upload_ = 0;
  std::vector<std::uint64_t> at_levels_;
};

Result<int> run(const Flags& flags) {
  VT_ASSIGN(const auto size, parse_size(flags.size));
  const auto [width, height] = size;
  if (flags.output.empty() && flags.frames == 0) return fail(ErrorCode::kUsage, "nothing to do: give -o PICTURE, or --frames N");
  if (!flags.output.empty() && cli::picture_kind(flags.output) != cli::PictureKind::kPng)
    return fail(ErrorCode::kUsage, flags.output + ": vtrender writes .png only");
  const bool shader = flags.path == "glsl";

  VT_ASSIGN(store::StoreReader opened, cli::open_store("vtrender", flags.store));
  const auto reader = std::make_shared<const store::StoreReader>(std::move(opened));
  VT_ASSIGN(std::optional<runtime::HeightField> heights, read_heights(*reader, flags.elevation));

  // A first look at the layer, to fit the layout into the texture memory.
  runtime::Options options{.layer = flags.layer,
                           .layout = {},
                           .upload_budget_bytes = flags.budget_kib * 1024,
                           .max_stages = flags.stages,
                           .tint_levels = flags.tint_levels};
  {
    VT_ASSIGN(const runtime::VirtualTexture probe, runtime::VirtualTexture::open(reader, options));
    VT_ASSIGN(options.layout, runtime::layout_for_budget(probe.layer(), flags.texture_mib << 20, flags.tint_levels || flags.no_extensions));
  }
  if (flags.tiles_per_side > 0) options.layout.tiles_per_side = flags.tiles_per_side;
  if (flags.tile_texels > 0) options.layout.tile_exponent = static_cast<int>(std::log2(flags.tile_texels));
  VT_ASSIGN(runtime::VirtualTexture texture, runtime::VirtualTexture::open(reader, options));

  if (texture.layer().state != LayerState::kComplete)
    cli::print_note("vtrender", "layer " + texture.layer().name + " is not complete; what its build has not come to yet is black");

  const int patch_texels = options.layout.tiles_per_side > 1 ? 1 << options.layout.tile_exponent : 1 << (options.layout.tile_exponent - 1);
  VT_ASSIGN(const Point2 metres, ground_metres(*reader));
  Terrain terrain(texture.layer(), texture.mapping(), metres, std::move(heights), flags.exaggerate, std::min(patch_texels, 256));
  Camera camera = flags.fly ? terrain.flight_camera() : terrain.default_camera(static_cast<double>(width) / height);
  if (!flags.camera.empty()) {
    VT_ASSIGN(camera, parse_camera(flags.camera));
  }

  VT_ASSIGN(const EglContext context, EglContext::create(width, height));
  VT_CHECK(texture.attach({.getproc = EglContext::getproc,
                           .user = nullptr,
                           .path = shader ? runtime::Path::kShader : runtime::Path::kFixedFunction,
                           .allow_extensions = !flags.no_extensions}));
  Renderer renderer;
  VT_CHECK(renderer.start(texture, shader, flags.stages, width, height));
  std::vector<const Patch*> patches;

  const auto check_loader = [&]() -> Result<void> {
    const std::string problem = texture.last_error();
    if (problem.empty()) return {};
    VT_CHECK(reader->check_intact());
    return fail(ErrorCode::kCorrupt, problem);
  };
  const auto settle = [&]() -> Result<void> {
    texture.set_center(terrain.look_at(camera));
    texture.update();
    while (!texture.settled()) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      texture.update();
    }
    return check_loader();
  };
  const Clock::time_point start = Clock::now();
  VT_CHECK(settle());
  const double settle_ms = milliseconds_since(start);

  // The first draws make the driver compile; they are not what --frames is about.
  for (int warm = 0; warm < 3; ++warm) {
    const View view = terrain.view(camera, width, height);
    terrain.visible(view, patches);
    renderer.draw(view, patches);
  }

  FrameReport frames;
  const Camera first = camera;
  const double step = flags.speed_m_s > 0.0 ? flags.speed_m_s / 60.0 : std::min(metres.x, metres.y) * 0.5 / std::max(flags.frames, 1);
  for (int frame = 0; frame < flags.frames; ++frame) {
    if (flags.fly) {
      const double heading = first.heading_deg * std::numbers::pi / 180.0;
      camera.u = first.u + std::sin(heading) * step * frame / metres.x;
      camera.v = first.v + std::cos(heading) * step * frame / metres.y;
    }
    const Clock::time_point frame_start = Clock::now();
    const Clock::time_point next_frame = frame_start + std::chrono::duration_cast<Clock::duration>(
                                                           std::chrono::duration<double>(flags.rate_hz > 0.0 ? 1.0 / flags.rate_hz : 0.0));
    texture.set_center(terrain.look_at(camera));
    const runtime::FrameStats stats = texture.update();
    const View view = terrain.view(camera, width, height);
    terrain.visible(view, patches);
    const Renderer::Drawn drawn = renderer.draw(view, patches);
    frames.add(milliseconds_since(frame_start), stats, drawn);
    VT_CHECK(check_loader());
    std::this_thread::sleep_until(next_frame);
  }
  if (flags.fly) VT_CHECK(settle());

  const View view = terrain.view(camera, width, height);
  terrain.visible(view, patches);
  renderer.draw(view, patches);
  if (!flags.output.empty()) VT_CHECK(write_png(flags.output, width, height, renderer.pixels()));

  double stages = 0.0;
  for (const runtime::StageSet& set : renderer.last_sets()) stages += set.count;
  if (!renderer.last_sets().empty()) stages /= static_cast<double>(renderer.last_sets().size());
  const runtime::LoaderCounters loaded = texture.loader_counters();
  if (flags.json) {
    nlohmann::ordered_json report = {
        {"store", flags.store},
        {"layer", texture.layer().name},
        {"path", flags.path},
        {"width", width},
        {"height", height},
        {"camera", {camera.u, camera.v, camera.height_m, camera.heading_deg, camera.pitch_deg, camera.fov_deg}},
        {"texture_bytes", texture.texture_bytes()},
        {"tile_texels", 1 << options.layout.tile_exponent},
        {"tiles_per_side", options.layout.tiles_per_side},
        {"settle_ms", settle_ms},
        {"tiles_read", loaded.tiles_read},
        {"bytes_read", loaded.bytes_read},
        {"patches", patches.size()},
        {"mean_stages", stages}};
    if (!frames.empty()) report["frames"] = frames.json(options.upload_budget_bytes);
    cli::print_json(report);
    return 0;
  }
  if (!flags.output.empty())
    cli::print(fmt::format("{}: layer {}, {} x {}, {} patches, {} tiles read in {:.0f} ms, {} of textures\n", flags.output,
                           texture.layer().name, width, height, patches.size(), loaded.tiles_read, settle_ms,
                           cli::format_bytes(texture.texture_bytes())));
  if (!frames.empty()) cli::print(frames.text(options.upload_budget_bytes));
  return 0;
}

}  // namespace
}  // namespace vt::tools

int main(int argc, char** argv) {
  vt::tools::Flags flags;
  CLI::App app(
      "Draws a store as terrain in perspective, without a window, by the runtime library. Waits until every tile is there, then saves the "
      "picture.",
      "vtrender");
  app.add_option("STORE", flags.store, "the tile store (.vts)")->required();
  app.add_option("-o,--output", flags.output, "picture to write; .png");
  app.add_option("--layer", flags.layer, "colour layer to drape; default: the first");
  app.add_option("--elevation", flags.elevation,
                 "layer of heights to displace the ground with, or none; default: the first elevation layer");
  app.add_option("--exaggerate", flags.exaggerate, "multiplies heights")->capture_default_str();
  app.add_option("--path", flags.path, "gl12: OpenGL 1.2 alone, one tile for each patch; glsl: shaders, several tiles")
      ->check(CLI::IsMember({"gl12", "glsl"}))
      ->capture_default_str();
  app.add_option("--camera", flags.camera,
                 "U,V,HEIGHT,HEADING,PITCH,FOV: place over the area (0..1 from the south-west corner), metres above the ground there, "
                 "degrees clockwise "
                 "from north, degrees above the horizon, vertical field of view in degrees; default: the whole area from the south");
  app.add_option("--size", flags.size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  app.add_option("--texture-memory", flags.texture_mib, "MiB of textures that the layout may take")
      ->check(CLI::Range(1, 16384))
      ->capture_default_str();
  app.add_option("--tiles-per-side", flags.tiles_per_side, "n x n tiles a level, instead of what the memory allows")
      ->check(CLI::Range(1, 8));
  app.add_option("--tile-texels", flags.tile_texels, "width of a tile texture, a power of two, instead of what the memory allows")
      ->check(CLI::IsMember({32, 64, 128, 256, 512, 1024, 2048}));
  app.add_option("--stages", flags.stages, "glsl: most tiles for one patch")->check(CLI::Range(1, 16))->capture_default_str();
  app.add_option("--budget", flags.budget_kib, "KiB to upload in one frame at most")->check(CLI::Range(1, 1 << 20))->capture_default_str();
  app.add_flag("--no-extensions", flags.no_extensions, "use no OpenGL extension, as on a plain 1.2 driver");
  app.add_flag("--tint-levels", flags.tint_levels, "colour every level, to see where the paging squares lie");
  app.add_option("--frames", flags.frames, "draw this many frames and print their times (wall clock around glFinish)")
      ->check(CLI::Range(1, 1000000));
  app.add_flag(
      "--fly", flags.fly,
      "move the camera forward over the frames, half the area in all; without --camera it flies low, where the finest texels are seen");
  app.add_option("--rate", flags.rate_hz, "with --frames: frames a second at most, as a display would ask for them (default: no limit)")
      ->check(CLI::Range(0.1, 1000.0));
  app.add_option("--speed", flags.speed_m_s, "with --fly: metres a second at 60 frames a second, instead");
  app.add_flag("--json", flags.json, "print the report as JSON");
  vt::cli::add_help_footer(app, vt::tools::kExamples);
  return vt::cli::run_main(app, argc, argv, [&] { return vt::tools::run(flags); });
}
