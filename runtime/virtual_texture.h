// The runtime's whole public face: a texture of practically unlimited size, streamed from a store, that
// behaves like an ordinary one.
//
// A host (image generator) opens a VirtualTexture for one layer, gives it the OpenGL context with attach(),
// and then, every frame:
//
//     texture.set_center(where_the_observer_is);            // any thread, any time
//     texture.update();                                      // GL thread: a bounded amount of uploading, never disk
//     for (each geometry) {
//       const StageSet tiles = texture.select(its_uv_box);   // which tiles texture it
//       texture.bind(tiles, its_uv_origin);                  // glBindTexture and a texture matrix
//       draw_with_texture_coordinates_minus(its_uv_origin);
//     }
//
// On the shader path bind() takes a ShaderBinding and the fragment shader calls the function that
// glsl_function() wrote. Any number of virtual textures may be drawn in one pass, each on its own units.
// Dataset coordinates (u, v) run 0..1 over the dataset's area from its south-west corner.
//
// OpenGL is reached only through the host's `getproc`: the library links no GL and makes no context. GL state
// that update() touches is put back. Threads: set_center() and its kin from anywhere; attach, detach,
// context_lost, update, select and bind from the GL thread; open and close from anywhere.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "store/layer.h"
#include "store/result.h"
#include "store/vt_mapping.h"

namespace vt::store {
class StoreReader;
}

namespace vt::runtime {

// --- Where to find OpenGL -----------------------------------------------------------------------------------------------------------

using GetProc = void* (*)(const char* name, void* user);

enum class Path : std::uint8_t {
  kFixedFunction,  // OpenGL 1.2 and nothing newer: one tile and one texture matrix for each geometry
  kShader,         // OpenGL 2.1 or later, compatibility or core: several tiles for each geometry, combined in the fragment shader
};

struct GlHost {
  GetProc getproc = nullptr;
  void* user = nullptr;
  Path path = Path::kFixedFunction;
  // false: no extension is used, and no compressed texture either; block-compressed layers are then decoded
  // on the loader thread.
  bool allow_extensions = true;
};

// --- What to keep in memory ---------------------------------------------------------------------------------------------------------

// Wishes; make_layout() in runtime/paging.h turns them into a legal layout. The runtime's tiles need not be
// the store's.
struct LayoutOptions {
  int tile_exponent = 9;   // tile textures of 2^9 = 512 texels a side; 3..13
  int tiles_per_side = 1;  // n x n tiles a level, 1..8
  int mips = 0;            // 0: as many as the hop allows
  // The paging grid. 0: half a tile where a level is one tile, else a whole tile, so that tiles are kept when
  // the center moves.
  std::int64_t hop_texels = 0;
  int levels = 0;  // how many of the finest levels to page, beside the one over everything; 0: all
  // A level that differs; fields below 1 keep the value above.
  struct Override {
    Level level;
    int tile_exponent = 0;
    int tiles_per_side = 0;
    int mips = 0;
    std::int64_t hop_texels = 0;
  };
  std::vector<Override> overrides;
};

struct Options {
  std::string layer;  // empty: the first colour texture layer
  LayoutOptions layout;
  std::size_t upload_budget_bytes = std::size_t{1} << 20;  // for one update(); never exceeded
  double upload_budget_seconds = 0.0;                      // and this long at the rate learned so far; 0: bytes alone count
  int staging_tiles = 4;                                   // tiles in memory between disk and GL
  int max_stages = 4;                                      // shader path: most tiles for one geometry, 1..kMaxStages
  bool tint_levels = false;                                // colours each level, to see where it lies; 8-bit and BC1 layers
};

// Texture memory that a layer takes with these options, double buffering and mips included, when `decoded`
// for block formats that GL does not take.
[[nodiscard]] Result<std::uint64_t> texture_bytes(const LayerInfo& layer, const LayoutOptions& options, bool decoded = false);
// The options of most texels a level whose texture_bytes() stay within `budget_bytes`. kUsage when not even
// the smallest do.
[[nodiscard]] Result<LayoutOptions> layout_for_budget(const LayerInfo& layer, std::uint64_t budget_bytes, bool decoded = false);

// --- What to draw with --------------------------------------------------------------------------------------------------------------

struct UvBox {
  double u_min = 0.0;
  double v_min = 0.0;
  double u_max = 1.0;
  double v_max = 1.0;
};

inline constexpr int kMaxStages = 16;

// The tiles for one geometry, finest first. Good until the next update().
struct StageSet {
  std::array<int, kMaxStages> slots{};
  int count = 0;        // 0: nothing is loaded yet
  bool covers = false;  // together they cover the whole box; false only before the first tile is there, or outside the virtual texture
};

// Where a program's uniforms are. From shader_binding(); holds no GL object.
struct ShaderBinding {
  unsigned program = 0;
  int first_unit = 0;
  int stages = 0;
  std::array<int, kMaxStages> map_locations{};
};

// --- What happened ------------------------------------------------------------------------------------------------------------------

struct LoaderCounters {
  std::uint64_t tiles_read = 0;
  std::uint64_t tiles_cancelled = 0;  // given up half-way, because the center had moved on
  std::uint64_t tiles_failed = 0;
  std::uint64_t bytes_read = 0;  // from the store, as texels
};

struct FrameStats {
  std::uint64_t frame = 0;
  std::size_t upload_bytes = 0;   // sent by this update()
  std::size_t upload_budget = 0;  // what it was allowed
  int upload_calls = 0;
  int pages_completed = 0;         // tiles that became visible
  int levels_moved = 0;            // levels whose box hopped
  int tiles_waiting = 0;           // tiles whose texture does not show yet what it should
  std::size_t loader_pending = 0;  // of these: queued, being read, or in memory
  int binds = 0;                   // glBindTexture calls of bind() since the update() before
  double seconds = 0.0;            // of this update() on the wall clock
};

// --- The texture --------------------------------------------------------------------------------------------------------------------

class TileSource;

class VirtualTexture {
 public:
  [[nodiscard]] static Result<VirtualTexture> open(const std::filesystem::path& store, Options options = {});
  // Virtual textures of one store share its reader.
  [[nodiscard]] static Result<VirtualTexture> open(std::shared_ptr<const store::StoreReader> reader, Options options = {});
  // Texels from somewhere else than a store. `area` and `layer` describe them.
  [[nodiscard]] static Result<VirtualTexture> open(std::shared_ptr<TileSource> source, const Area& area, const LayerInfo& layer,
                                                   Options options = {});
  VirtualTexture(VirtualTexture&&) noexcept;
  VirtualTexture& operator=(VirtualTexture&&) noexcept;
  ~VirtualTexture();  // stops the loader; deletes no GL object, as no context may be current: call detach() for that

  [[nodiscard]] const LayerInfo& layer() const;
  [[nodiscard]] const VtMapping& mapping() const;

  // Where to be sharp. Outside the data it is clamped; not-a-number is ignored.
  void set_center(Point2 uv);
  void set_level_center(Level level, Point2 uv);  // this level apart from the others, until follow_center()
  void follow_center(Level level);
  void set_upload_budget(std::size_t bytes, double seconds = 0.0);

  // Creates the tile textures in the current context. kUnsupported when the context cannot do the path or the
  // layer's format; the message says what is missing.
  [[nodiscard]] Result<void> attach(const GlHost& host);
  void detach();        // deletes them; the context is current
  void context_lost();  // forgets them; attach() again

  // The frame's share of paging. In steady state it allocates nothing.
  FrameStats update();
  [[nodiscard]] bool settled() const;  // every tile texture shows what it should (or could not be read)
  [[nodiscard]] LoaderCounters loader_counters() const;
  [[nodiscard]] std::string last_error() const;  // of the loader; empty when all is well

  // `most_stages` (shader path): at most this many tiles, not more than the ShaderBinding that will draw them
  // has; 0: Options::max_stages.
  [[nodiscard]] StageSet select(const UvBox& box, int most_stages = 0) const;

  // Fixed-function path, on the active texture unit: binds the tile and loads the texture matrix. Texture
  // coordinates are (u, v) - uv_origin: with an origin inside the geometry they are small numbers, and float
  // is exact enough for any virtual texture. The host enables GL_TEXTURE_2D.
  void bind(const StageSet& tiles, Point2 uv_origin = {});
  // GLSL text of `vec4 NAME(vec2 uv)` with the uniforms it needs, for GLSL 1.20 and later, to be put before
  // the user's main().
  [[nodiscard]] static std::string glsl_function(std::string_view name, int stages);
  // Looks the uniforms of `name` up and sets its samplers to `first_unit` and following. The program is
  // linked and in use.
  [[nodiscard]] Result<ShaderBinding> shader_binding(unsigned program, std::string_view name, int first_unit, int stages);
  // Shader path: binds the tiles and sets the uniforms. The program is in use; unit 0 is left active.
  void bind(const ShaderBinding& binding, const StageSet& tiles, Point2 uv_origin = {});
  // bind() does not bind again what it bound last on a unit. Call this when something else was bound there
  // since; update() does.
  void forget_bindings();

  // Residency, for tools and tests.
  struct TileState {
    Level level;
    std::int64_t x = 0;  // north-west texel that the front texture shows, on `level`
    std::int64_t y = 0;
    std::int64_t texels = 0;
    int mips = 0;
    bool shown = false;
    unsigned gl_texture = 0;
  };
  [[nodiscard]] std::vector<TileState> tiles() const;
  [[nodiscard]] std::uint64_t texture_bytes() const;  // allocated by attach()

 private:
  struct Impl;
  explicit VirtualTexture(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Fills `order` with the draws' indices such that those that share tiles follow one another: then binds =
// distinct tile sets. No allocation.
void sort_by_tile(std::span<const StageSet> draws, std::span<std::uint32_t> order);

// --- Heights on the CPU -------------------------------------------------------------------------------------------------------------

// A layer of heights (r32f, r16f or r16) as a grid in memory, in the layer's unit, to displace geometry with.
class HeightField {
 public:
  // The finest level whose data rectangle is at most `most_texels` wide and high.
  [[nodiscard]] static Result<HeightField> read(const store::StoreReader& reader, LayerId layer, int most_texels);
  // Bilinear between the places of the texels' values, clamped at the data's edge; not-a-number texels take
  // no part. `fallback` where none is near.
  [[nodiscard]] double at(Point2 uv, double fallback = 0.0) const;
  [[nodiscard]] double min_height() const { return min_; }  // both 0 when there is no data at all
  [[nodiscard]] double max_height() const { return max_; }

 private:
  HeightField(const VtMapping& mapping, Level level, TexelRect rect, double value_offset)
      : mapping_(mapping), level_(level), rect_(rect), value_offset_(value_offset) {}
  VtMapping mapping_;
  Level level_;
  TexelRect rect_;
  double value_offset_;  // LayerInfo::value_offset
  std::vector<float> heights_;
  double min_ = 0.0;
  double max_ = 0.0;
};

}  // namespace vt::runtime
