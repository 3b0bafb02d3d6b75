#include "runtime/tile_loader.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <exception>

#include "store/texel/texel_decoder.h"

namespace vt::runtime {
namespace {

bool same(const TileRequest& a, int slot, Ticket ticket) { return a.slot == slot && a.ticket == ticket; }

}  // namespace

std::array<std::uint8_t, 3> tint_colour(int levels_from_finest) {
  static constexpr std::array<std::array<std::uint8_t, 3>, 8> kColours = {
      {{230, 30, 30}, {240, 150, 20}, {240, 230, 30}, {50, 200, 50}, {30, 190, 220}, {40, 70, 230}, {150, 50, 210}, {150, 150, 150}}};
  return kColours[static_cast<std::size_t>(levels_from_finest) % kColours.size()];
}

std::size_t mip_offset(const FormatInfo& format, int tile_exponent, int mip) {
  std::size_t offset = 0;
  for (int k = 0; k < mip; ++k) {
    const std::size_t edge = std::size_t{1} << (tile_exponent - k);
    offset += payload_bytes(format, edge, edge);
  }
  return offset;
}

std::size_t tile_bytes(const FormatInfo& format, int tile_exponent, int mips) { return mip_offset(format, tile_exponent, mips); }

TileLoader::TileLoader(std::shared_ptr<TileSource> source, TexelConversion conversion, int largest_exponent, int most_mips,
                       int staging_tiles, std::size_t most_requests)
    : source_(std::move(source)), conversion_(conversion) {
  assert(conversion_.source == conversion_.target || conversion_.target == format_info(conversion_.source).decoded_to);
  const int count = std::max(staging_tiles, 1);
  for (int i = 0; i < count; ++i) {
    images_.push_back(std::make_unique<TileImage>());
    images_.back()->bytes.resize(tile_bytes(format_info(conversion_.target), largest_exponent, most_mips));
    free_.push_back(images_.back().get());
  }
  done_.reserve(images_.size());
  queue_.reserve(most_requests);
  if (conversion_.source != conversion_.target)
    scratch_.resize(payload_bytes(format_info(conversion_.source), std::size_t{1} << largest_exponent, std::size_t{1} << largest_exponent));
  thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
}

TileLoader::~TileLoader() = default;

void TileLoader::post(std::span<const TileRequest> requests) {
  {
    const std::lock_guard lock(mutex_);
    assert(requests.size() <= queue_.capacity());
    queue_.clear();
    next_ = 0;
    give_up_ = in_work_.slot >= 0;
    for (const TileRequest& request : requests) {
      if (same(in_work_, request.slot, request.ticket)) {
        give_up_ = false;
        continue;
      }
      const bool waits =
          std::any_of(done_.begin(), done_.end(), [&](const TileImage* image) { return same(request, image->slot, image->ticket); });
      if (!waits) queue_.push_back(request);
    }
  }
  wake_.notify_one();
}

TileImage* TileLoader::take() {
  const std::lock_guard lock(mutex_);
  if (done_.empty()) return nullptr;
  TileImage* image = done_.front();
  done_.erase(done_.begin());
  return image;
}

void TileLoader::release(TileImage* image) {
  {
    const std::lock_guard lock(mutex_);
    free_.push_back(image);
  }
  wake_.notify_one();
}

LoaderCounters TileLoader::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

std::size_t TileLoader::pending() const {
  const std::lock_guard lock(mutex_);
  return queue_.size() - next_ + (in_work_.slot >= 0 ? 1 : 0) + done_.size();
}

std::string TileLoader::last_error() const {
  const std::lock_guard lock(mutex_);
  return last_error_;
}

void TileLoader::run(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return next_ < queue_.size() && !free_.empty(); })) {
    const TileRequest request = queue_[next_++];
    TileImage* image = free_.back();
    free_.pop_back();
    in_work_ = request;
    give_up_ = false;
    lock.unlock();

    Result<bool> loaded = false;
    try {
      loaded = load(request, *image);
    } catch (const std::exception& problem) {
      loaded = fail(ErrorCode::kInternal, problem.what());
    }

    lock.lock();
    in_work_.slot = -1;
    if (loaded && !*loaded) {
      ++counters_.tiles_cancelled;
      free_.push_back(image);
      continue;
    }
    image->ok = loaded.has_value();
    if (loaded) {
      ++counters_.tiles_read;
      counters_.bytes_read += tile_bytes(format_info(conversion_.source), request.level.tile_exponent, request.level.mips);
    } else {
      ++counters_.tiles_failed;
      last_error_ = loaded.error().message;
    }
    done_.push_back(image);
  }
}

// False when the tile was given up on the way.
Result<bool> TileLoader::load(const TileRequest& request, TileImage& image) {
  const FormatInfo& source = format_info(conversion_.source);
  const FormatInfo& target = format_info(conversion_.target);
  image.slot = request.slot;
  image.ticket = request.ticket;
  image.tile_exponent = request.level.tile_exponent;
  image.mips = request.level.mips;
  image.format = conversion_.target;

  for (int mip = 0; mip < request.level.mips; ++mip) {
    {
      const std::lock_guard lock(mutex_);
      if (give_up_) return false;
    }
    const std::int64_t edge = request.level.tile_texels() >> mip;
    const Level level{static_cast<std::uint8_t>(request.level.level.value - mip)};
    const TexelRect rect{request.origin.x >> mip, request.origin.y >> mip, edge, edge};
    const std::span<std::byte> out = std::span(image.bytes)
                                         .subspan(mip_offset(target, image.tile_exponent, mip),
                                                  payload_bytes(target, static_cast<std::size_t>(edge), static_cast<std::size_t>(edge)));
    if (conversion_.source == conversion_.target) {
      VT_CHECK(source_->read(level, rect, out));
    } else {
      const std::span<std::byte> blocks =
          std::span(scratch_).first(payload_bytes(source, static_cast<std::size_t>(edge), static_cast<std::size_t>(edge)));
      VT_CHECK(source_->read(level, rect, blocks));
      store::decode_blocks(conversion_.source, blocks, static_cast<std::size_t>(edge), static_cast<std::size_t>(edge), out);
    }
    if (conversion_.tint_levels) tint(request, out);
  }
  return true;
}

void TileLoader::tint(const TileRequest& request, std::span<std::byte> texels) const {
  const FormatInfo& target = format_info(conversion_.target);
  const std::size_t channels = target.channels;
  if (target.samples != SampleKind::kUnorm8 || channels < 3) return;
  const std::array<std::uint8_t, 3> colour = tint_colour(request.levels_from_finest);
  for (std::size_t i = 0; i + channels <= texels.size(); i += channels)
    for (std::size_t c = 0; c < 3; ++c) texels[i + c] = static_cast<std::byte>((std::to_integer<unsigned>(texels[i + c]) + colour[c]) / 2);
}

}  // namespace vt::runtime
