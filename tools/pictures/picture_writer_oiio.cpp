// PNG and EXR, row by row. Part of the library that holds all of OpenImageIO.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <cassert>
#include <utility>

#include "store/io/output_file.h"
#include "tools/pictures/picture_writer_module.h"

namespace vt::cli {

namespace {

// Where OpenImageIO's writers put their bytes. Some of them look at no return value: what fails is kept by
// the file.
class FileProxy final : public OIIO::Filesystem::IOProxy {
 public:
  explicit FileProxy(store::OutputFile file) : IOProxy("", Mode::Write), file_(std::move(file)) {}
  const char* proxytype() const override { return "vt::store::OutputFile"; }
  std::size_t write(const void* bytes, std::size_t count) override {
    const std::size_t written = pwrite(bytes, count, m_pos);
    m_pos += static_cast<std::int64_t>(written);
    return written;
  }
  std::size_t pwrite(const void* bytes, std::size_t count, std::int64_t offset) override {
    const bool done = file_.write_at(static_cast<std::uint64_t>(offset), {static_cast<const std::byte*>(bytes), count}).has_value();
    return done ? count : 0;
  }
  std::size_t size() const override { return file_.size(); }
  [[nodiscard]] store::OutputFile& file() { return file_; }

 private:
  store::OutputFile file_;
};

class OiioPicture : public PictureWriter {
 public:
  OiioPicture(store::OutputFile file, const PictureSpec& spec) : proxy_(std::move(file)), spec_(spec) {}

  ~OiioPicture() override {
    if (output_) output_->close();  // the file goes with proxy_
  }

  Result<void> open() {
    output_ = OIIO::ImageOutput::create(path().string(), &proxy_);
    if (!output_)
      return fail(ErrorCode::kInternal, fmt::format("{}: OpenImageIO cannot write this kind: {}", path().string(), OIIO::geterror()));
    OIIO::ImageSpec picture(static_cast<int>(spec_.width), static_cast<int>(spec_.height), spec_.channels,
                            spec_.is_float ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
    if (spec_.last_is_alpha) picture.alpha_channel = spec_.channels - 1;
    if (spec_.channels == 2 && spec_.last_is_alpha) picture.channelnames = {"Y", "A"};
    if (spec_.channels == 1) picture.channelnames = {"Y"};
    picture.attribute("oiio:UnassociatedAlpha", 1);
    if (spec_.is_srgb) picture.attribute("oiio:ColorSpace", "sRGB");
    if (spec_.is_float) picture.attribute("compression", "zip");
    // The name says which format is meant; nothing is opened under it.
    if (!output_->open(path().string(), picture)) return failed("create");
    return {};
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
    const bool closed = output_->close();
    if (!closed) return failed("finish");
    output_.reset();
    return proxy_.file().finish();
  }

 private:
  [[nodiscard]] const std::filesystem::path& path() { return proxy_.file().path(); }
  [[nodiscard]] tl::unexpected<Error> failed(const char* act) {
    std::string reason = output_->geterror();
    if (const std::optional<Error>& failure = proxy_.file().failure()) return tl::unexpected(*failure);
    return fail(ErrorCode::kIo, fmt::format("{}: cannot {}: {}", path().string(), act, reason));
  }

  FileProxy proxy_;
  std::unique_ptr<OIIO::ImageOutput> output_;
  PictureSpec spec_;
  std::int64_t next_row_ = 0;
};

Result<std::unique_ptr<PictureWriter>> create_oiio(const std::filesystem::path& path, const PictureSpec& spec) {
  constexpr std::int64_t kMaxEdge = 0x7fffffff;
  if (spec.width > kMaxEdge || spec.height > kMaxEdge) {
    return fail(ErrorCode::kUnsupported, fmt::format("{}: {} x {} texels are more than the format holds; write .tif or choose a --window",
                                                     path.string(), spec.width, spec.height));
  }
  VT_ASSIGN(store::OutputFile file, store::OutputFile::create(path));
  auto picture = std::make_unique<OiioPicture>(std::move(file), spec);
  VT_CHECK(picture->open());
  return picture;
}

}  // namespace

}  // namespace vt::cli

extern "C" const vt::cli::PictureWriterModule vt_picture_writer_module = {.create = vt::cli::create_oiio};
