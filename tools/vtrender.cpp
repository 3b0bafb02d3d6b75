// vtrender: draws a store as terrain in perspective, without a window, through the runtime library and nothing else. Pictures, and frame
// times of a flight.
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
#include "runtime/virtual_texture.h"
#include "store/store_reader.h"
#include "tools/cli_support.h"
#include "tools/egl_context.h"
#include "tools/open_store.h"
#include "tools/picture_writer.h"
#include "tools/vtrender_gl.h"
#include "tools/vtrender_scene.h"

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

// Ground metres along u and v, at the middle of the area. A store without a place on the Earth counts in metres.
Result<Point2> ground_metres(const store::StoreReader& reader) {
  const Area& area = reader.description().area;
  const Point2 units{area.east - area.west, area.north - area.south};
  const nlohmann::json metadata = nlohmann::json::parse(reader.description().metadata_json, nullptr, false);
  if (!metadata.is_object() || !metadata.contains("crs")) return units;
  VT_ASSIGN(const geo::Crs crs, geo::Crs::from_json(metadata["crs"]));
  if (crs.definition().projection == geo::Projection::kPixel) return units;
  VT_ASSIGN(const Point2 metres, crs.metres_per_unit_at({(area.west + area.east) / 2.0, (area.south + area.north) / 2.0}));
  return Point2{units.x * metres.x, units.y * metres.y};
}

Result<std::optional<runtime::HeightField>> read_heights(const store::StoreReader& reader, const std::string& name) {
  if (name == "none") return std::optional<runtime::HeightField>();
  const LayerInfo* chosen = nullptr;
  for (const LayerInfo& layer : reader.layers())
    if (layer.role == LayerRole::kTexture && chosen == nullptr &&
        (name.empty() ? layer.channel == ChannelType::kElevation && !layer.is_part : layer.name == name))
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

  void draw(const View& view, std::span<const Patch* const> patches) {
    gl_.Clear(gl::GL_COLOR_BUFFER_BIT | gl::GL_DEPTH_BUFFER_BIT);
    gl_.MatrixMode(gl::GL_PROJECTION);
    gl_.LoadMatrixd(view.clip_from_offset.data());
    gl_.MatrixMode(gl::GL_MODELVIEW);
    sets_.clear();
    for (const Patch* patch : patches) sets_.push_back(texture_->select(patch->uv));
    order_.resize(sets_.size());
    runtime::sort_by_tile(sets_, order_);
    for (const std::uint32_t i : order_) {
      const Patch& patch = *patches[i];
      if (shader_)
        texture_->bind(binding_, sets_[i], patch.uv_origin);
      else
        texture_->bind(sets_[i], patch.uv_origin);
      const double move[16] = {
          1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, patch.origin.x - view.eye.x, patch.origin.y - view.eye.y, patch.origin.z - view.eye.z, 1};
      gl_.LoadMatrixd(move);
      gl_.VertexPointer(3, gl::GL_FLOAT, 0, patch.positions.data());
      gl_.TexCoordPointer(2, gl::GL_FLOAT, 0, patch.texcoords.data());
      gl_.DrawElements(gl::GL_TRIANGLES, static_cast<gl::GLsizei>(patch_indices().size()), gl::GL_UNSIGNED_SHORT, patch_indices().data());
    }
    gl_.Finish();
  }

  [[nodiscard]] std::span<const runtime::StageSet> last_sets() const { return sets_; }

  std::vector<std::uint8_t> pixels() {
    std::vector<std::uint8_t> rgba(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 4);
    gl_.PixelStorei(gl::GL_PACK_ALIGNMENT, 1);
    gl_.ReadPixels(0, 0, width_, height_, gl::GL_RGBA, gl::GL_UNSIGNED_BYTE, rgba.data());
    return rgba;
  }

 private:
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
};

double percentile(std::vector<double> values, double part) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(part * static_cast<double>(values.size())))];
}

double milliseconds_since(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }

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
  Camera camera = terrain.default_camera(static_cast<double>(width) / height);
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

  std::vector<double> frame_ms;
  std::vector<double> update_ms;
  std::size_t most_bytes = 0;
  std::uint64_t pages = 0;
  std::uint64_t binds = 0;
  const Camera first = camera;
  const double step = flags.speed_m_s > 0.0 ? flags.speed_m_s / 60.0 : std::min(metres.x, metres.y) * 0.5 / std::max(flags.frames, 1);
  for (int frame = 0; frame < flags.frames; ++frame) {
    if (flags.fly) {
      const double heading = first.heading_deg * std::numbers::pi / 180.0;
      camera.u = first.u + std::sin(heading) * step * frame / metres.x;
      camera.v = first.v + std::cos(heading) * step * frame / metres.y;
    }
    const Clock::time_point frame_start = Clock::now();
    texture.set_center(terrain.look_at(camera));
    const runtime::FrameStats stats = texture.update();
    const View view = terrain.view(camera, width, height);
    terrain.visible(view, patches);
    renderer.draw(view, patches);
    frame_ms.push_back(milliseconds_since(frame_start));
    update_ms.push_back(stats.seconds * 1e3);
    most_bytes = std::max(most_bytes, stats.upload_bytes);
    pages += static_cast<std::uint64_t>(stats.pages_completed);
    binds += static_cast<std::uint64_t>(stats.binds);
    VT_CHECK(check_loader());
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
    if (!frame_ms.empty())
      report["frames"] = {{"count", frame_ms.size()},
                          {"median_ms", percentile(frame_ms, 0.5)},
                          {"p99_ms", percentile(frame_ms, 0.99)},
                          {"max_ms", percentile(frame_ms, 1.0)},
                          {"update_median_ms", percentile(update_ms, 0.5)},
                          {"update_p99_ms", percentile(update_ms, 0.99)},
                          {"upload_most_bytes", most_bytes},
                          {"upload_budget_bytes", options.upload_budget_bytes},
                          {"pages", pages},
                          {"mean_binds", static_cast<double>(binds) / static_cast<double>(frame_ms.size())}};
    cli::print_json(report);
    return 0;
  }
  if (!flags.output.empty())
    cli::print(fmt::format("{}: layer {}, {} x {}, {} patches, {} tiles read in {:.0f} ms, {} of textures\n", flags.output,
                           texture.layer().name, width, height, patches.size(), loaded.tiles_read, settle_ms,
                           cli::format_bytes(texture.texture_bytes())));
  if (!frame_ms.empty())
    cli::print(fmt::format(
        "{} frames: median {:.2f} ms, 99 % {:.2f} ms; update median {:.3f} ms, 99 % {:.3f} ms; upload at most {} of {} a frame; {} pages, "
        "{:.1f} binds a frame\n",
        frame_ms.size(), percentile(frame_ms, 0.5), percentile(frame_ms, 0.99), percentile(update_ms, 0.5), percentile(update_ms, 0.99),
        cli::format_bytes(most_bytes), cli::format_bytes(options.upload_budget_bytes), pages,
        static_cast<double>(binds) / static_cast<double>(frame_ms.size())));
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
  app.add_flag("--fly", flags.fly, "move the camera forward over the frames, half the area in all");
  app.add_option("--speed", flags.speed_m_s, "with --fly: metres a second at 60 frames a second, instead");
  app.add_flag("--json", flags.json, "print the report as JSON");
  vt::cli::add_help_footer(app, vt::tools::kExamples);
  return vt::cli::run_main(app, argc, argv, [&] { return vt::tools::run(flags); });
}
