// The writing half of the border that builder/source/picture/picture_module.h describes: what the programs
// ask of the library with OpenImageIO in it.
#pragma once

#include "tools/pictures/picture_writer.h"

namespace vt::cli {

struct PictureWriterModule {
  Result<std::unique_ptr<PictureWriter>> (*create)(const std::filesystem::path& path, const PictureSpec& spec);
};
inline constexpr char kPictureWriterModuleSymbol[] = "vt_picture_writer_module";

}  // namespace vt::cli

extern "C" __attribute__((visibility("default"))) const vt::cli::PictureWriterModule vt_picture_writer_module;
