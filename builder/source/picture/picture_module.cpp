#include "builder/source/picture/picture_module.h"

#include <dlfcn.h>

#include <filesystem>

#include "builder/source/picture/picture_source.h"

namespace vt::source {
namespace {

// Beside the program's folder, as the build and the installation lay it out (bin/, lib/vt/), or in it.
Result<void*> load_library() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return fail(ErrorCode::kInternal, "cannot find this program's own folder: " + error.message());
  const std::filesystem::path folder = program.parent_path();
  std::string reasons;
  for (const std::filesystem::path& place : {folder / "../lib/vt/vt_pictures.so", folder / "vt_pictures.so"}) {
    void* const library = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);  // stays open until the program ends
    if (library != nullptr) return library;
    reasons += std::string("; ") + dlerror();
  }
  return fail(ErrorCode::kInternal,
              "pictures other than TIFF need vt_pictures.so, which belongs to this program but cannot be loaded" + reasons);
}

}  // namespace

Result<const void*> picture_library_symbol(const char* name) {
  static const Result<void*> library = load_library();
  if (!library) return tl::unexpected(library.error());
  const void* const symbol = dlsym(*library, name);
  if (symbol == nullptr)
    return fail(ErrorCode::kInternal, std::string("vt_pictures.so has no ") + name + ": it is from another build than this program");
  return symbol;
}

Result<std::unique_ptr<RasterSource>> open_picture(std::shared_ptr<const FileBytes> file, const PictureFormat& format,
                                                   const OpenOptions& options) {
  VT_ASSIGN(const void* const module, picture_library_symbol(kPictureModuleSymbol));
  return static_cast<const PictureModule*>(module)->open_picture(std::move(file), format, options);
}

}  // namespace vt::source
