#include "builder/source/picture_module.h"

#include <dlfcn.h>

#include "builder/source/picture_source.h"

namespace vt::source {
namespace {

// Beside the program's folder, as the build lays it out (bin/, lib/), or in it.
Result<const PictureModule*> load_module() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return fail(ErrorCode::kInternal, "cannot find this program's own folder: " + error.message());
  const std::filesystem::path folder = program.parent_path();
  std::string reasons;
  for (const std::filesystem::path& place : {folder / "../lib/vt_pictures.so", folder / "vt_pictures.so"}) {
    void* const library = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);  // stays open until the program ends
    if (library == nullptr) {
      reasons += std::string("; ") + dlerror();
      continue;
    }
    if (void* const symbol = dlsym(library, kPictureModuleSymbol); symbol != nullptr) return static_cast<const PictureModule*>(symbol);
    reasons += "; " + place.string() + " is another version";
  }
  return fail(ErrorCode::kInternal,
              "pictures other than TIFF need vt_pictures.so, which belongs to this program but cannot be loaded" + reasons);
}

}  // namespace

Result<std::unique_ptr<RasterSource>> open_picture(const std::filesystem::path& path, const OpenOptions& options) {
  static const Result<const PictureModule*> module = load_module();
  if (!module) return tl::unexpected(module.error());
  return (*module)->open_picture(path, options);
}

}  // namespace vt::source
