// PNG and EXR, row by row. Part of the library that holds all of OpenImageIO.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cassert>
#include <system_error>
#include <utility>

#include "tools/picture_writer_module.h"

namespace vt::cli {

namespace {

class OiioPicture : public PictureWriter {
 public:
  OiioPicture(std::unique_ptr<OIIO::ImageOutput> output, std::filesystem::path path, std::filesystem::path temporary,
              const PictureSpec& spec)
      : output_(std::move(output)), path_(std::move(path)), temporary_(std::move(temporary)), spec_(spec) {}

  ~OiioPicture() override {
    if (is_finished_) return;
    output_->close();
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
  }

  Result<void> write_rows(std::span<const std::byte> texels, std::int64_t rows) override {
    const std::size_t row_bytes =
        static_cast<std::size_t>(spec_.width) * static_cast<std::size_t>(spec_.channels) * (spec_.is_float ? 4 : 1);
    assert(texels.size() == row_bytes * static_cast<std::size_t>(rows));
    static_cast<void>(row_bytes);
    const auto type = spec_.is_float ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8;
    const int first = static_cast<int>(next_row_);
    if (!output_->write_scanlines(first, first + static_cast<int>(rows), 0, type, texels.data())) return failed("write");
    next_row_ += rows;
    return {};
  }

  Result<void> finish() override {
    if (!output_->close()) return failed("finish");
    std::error_code error;
    std::filesystem::rename(temporary_, path_, error);
    if (error)
      return fail(ErrorCode::kIo, fmt::format("{}: cannot rename {} to it: {}", path_.string(), temporary_.string(), error.message()));
    is_finished_ = true;
    return {};
  }

 private:
  [[nodiscard]] tl::unexpected<Error> failed(const char* act) const {
    return fail(ErrorCode::kIo, fmt::format("{}: cannot {}: {}", path_.string(), act, output_->geterror()));
  }

  std::unique_ptr<OIIO::ImageOutput> output_;
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  PictureSpec spec_;
  std::int64_t next_row_ = 0;
  bool is_finished_ = false;
};

Result<std::unique_ptr<PictureWriter>> create_oiio(const std::filesystem::path& path, const PictureSpec& spec) {
  constexpr std::int64_t kMaxEdge = 0x7fffffff;
  if (spec.width > kMaxEdge || spec.height > kMaxEdge) {
    return fail(ErrorCode::kUnsupported, fmt::format("{}: {} x {} texels are more than the format holds; write .tif or choose a --window",
                                                     path.string(), spec.width, spec.height));
  }
  auto output = OIIO::ImageOutput::create(path.string());
  if (!output)
    return fail(ErrorCode::kInternal, fmt::format("{}: OpenImageIO cannot write this kind: {}", path.string(), OIIO::geterror()));

  OIIO::ImageSpec picture(static_cast<int>(spec.width), static_cast<int>(spec.height), spec.channels,
                          spec.is_float ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  if (spec.last_is_alpha) picture.alpha_channel = spec.channels - 1;
  if (spec.channels == 2 && spec.last_is_alpha) picture.channelnames = {"Y", "A"};
  if (spec.channels == 1) picture.channelnames = {"Y"};
  picture.attribute("oiio:UnassociatedAlpha", 1);
  if (spec.is_srgb) picture.attribute("oiio:ColorSpace", "sRGB");
  if (spec.is_float) picture.attribute("compression", "zip");

  // The name keeps its suffix at the end, because the plug-in looks at it.
  const std::filesystem::path temporary =
      path.parent_path() / fmt::format(".{}.{}.partial{}", path.stem().string(), ::getpid(), path.extension().string());
  if (!output->open(temporary.string(), picture)) {
    return fail(ErrorCode::kIo, fmt::format("{}: cannot create: {}", path.string(), output->geterror()));
  }
  return std::make_unique<OiioPicture>(std::move(output), path, temporary, spec);
}

}  // namespace

}  // namespace vt::cli

extern "C" const vt::cli::PictureWriterModule vt_picture_writer_module = {.create = vt::cli::create_oiio};
