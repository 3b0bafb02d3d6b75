#include "store/index/new_store.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "store/format/file_beside.h"

namespace vt::store {
namespace {

// Small tiles go to the file many at a time, in pieces that begin and end at multiples of this: the system
// then keeps the file in large pages of memory, where it can, and a look-up somewhere in a large index misses
// the processor's address cache less.
constexpr std::size_t kChunkBytes = std::size_t{4} << 20;

}  // namespace

Result<std::unique_ptr<NewStore>> NewStore::begin(const std::filesystem::path& path, WriterOptions options, const File* replaced) {
  std::unique_ptr<NewStore> store(new NewStore);
  store->path_ = path;
  store->options_ = std::move(options);
  store->replaced_ = replaced;
  VT_ASSIGN(store->file_, create_beside(path, replaced));
  store->file_.set_hook(&store->options_.before_operation);
  return store;
}

NewStore::~NewStore() {
  if (!is_published_ && file_.descriptor() >= 0) file_.remove_own_name();
}

Result<std::uint64_t> NewStore::reserve(std::uint64_t bytes) {
  assert(bytes % kRecordAlignment == 0);
  if (bytes > kMaxFileBytes - end_) return fail(ErrorCode::kIo, path_.string() + ": would pass 256 TiB, the limit of its format");
  VT_CHECK(write_buffer(buffered_));
  const std::uint64_t offset = std::exchange(end_, end_ + bytes);
  buffer_at_ = end_;
  return offset;
}

Result<Reference> NewStore::write_page(std::uint64_t offset, std::uint64_t key, std::span<const std::byte> payload) {
  const auto bytes = static_cast<std::uint32_t>(payload.size());
  RecordHeader header{.type = RecordType::kPage, .raw_bytes = bytes, .stored_bytes = bytes, .key = key};
  const auto sealed = seal_record(header, payload);
  VT_CHECK(file_.write_at(offset, sealed, payload, kRecordAlignment));
  return Reference{.offset = offset, .stored_bytes = bytes, .check = static_cast<std::uint32_t>(header.hash), .kind = ReferenceKind::kPage};
}

Result<Reference> NewStore::append(RecordType type, std::uint64_t key, std::span<const std::byte> payload) {
  const auto bytes = static_cast<std::uint32_t>(payload.size());
  RecordHeader header{.type = type, .raw_bytes = bytes, .stored_bytes = bytes, .key = key};
  const auto sealed = seal_record(header, payload);
  VT_ASSIGN(const std::span<std::byte> record, next_record(sealed.size() + payload.size()));
  std::copy(payload.begin(), payload.end(), std::copy(sealed.begin(), sealed.end(), record.begin()));
  return Reference{.offset = keep_record(record.size()),
                   .stored_bytes = bytes,
                   .check = static_cast<std::uint32_t>(header.hash),
                   .kind = static_cast<ReferenceKind>(type)};
}

Result<std::span<std::byte>> NewStore::next_record(std::uint64_t bytes) {
  const std::uint64_t room = aligned(bytes);
  if (room > kMaxFileBytes - end_) return fail(ErrorCode::kIo, path_.string() + ": would pass 256 TiB, the limit of its format");
  if (const std::uint64_t whole_end = (buffer_at_ + buffered_) / kChunkBytes * kChunkBytes; whole_end > buffer_at_)
    VT_CHECK(write_buffer(whole_end - buffer_at_));
  if (room > buffer_.size() - buffered_) buffer_.resize(buffered_ + room);
  return std::span(buffer_).subspan(buffered_, bytes);
}

std::uint64_t NewStore::keep_record(std::uint64_t bytes) {
  const std::uint64_t room = aligned(bytes);
  const auto padding = std::span(buffer_).subspan(buffered_ + bytes, room - bytes);
  std::fill(padding.begin(), padding.end(), std::byte{0});
  buffered_ += room;
  return std::exchange(end_, end_ + room);
}

Result<void> NewStore::write_buffer(std::size_t bytes) {
  if (bytes == 0) return {};
  VT_CHECK(file_.write_at(buffer_at_, std::span(buffer_).first(bytes)));
  // Otherwise the sync at the end would wait for the whole store.
  if (options_.sync) file_.start_writeback(buffer_at_, bytes);
  const auto used = buffer_.begin() + static_cast<std::ptrdiff_t>(buffered_);
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(bytes), used, buffer_.begin());
  buffered_ -= bytes;
  buffer_at_ += bytes;
  return {};
}

Result<std::uint64_t> NewStore::catalog_room(const Catalog& catalog) {
  VT_ASSIGN(const std::vector<std::byte> payload, encode_catalog(catalog));
  return aligned(kRecordHeaderBytes + payload.size());
}

Result<void> NewStore::publish(const Catalog& catalog, const Seal& seal) {
  VT_CHECK(write_buffer(buffered_));
  VT_ASSIGN(const std::vector<std::byte> payload, encode_catalog(catalog));
  const auto bytes = static_cast<std::uint32_t>(payload.size());
  RecordHeader header{.type = RecordType::kCatalog, .raw_bytes = bytes, .stored_bytes = bytes};
  const auto sealed = seal_record(header, payload);
  VT_CHECK(file_.write_at(seal.catalog_at, sealed, payload, kRecordAlignment));

  Superblock superblock{.uuid = seal.uuid,
                        .file_end = end_,
                        .catalog = {.offset = seal.catalog_at,
                                    .stored_bytes = bytes,
                                    .check = static_cast<std::uint32_t>(header.hash),
                                    .kind = ReferenceKind::kCatalog},
                        .cold_start = seal.cold_start};
  for (superblock.generation = seal.generation; superblock.generation <= seal.generation + 1; ++superblock.generation)
    VT_CHECK(file_.write_at(superblock_offset(superblock.generation), encode_superblock(superblock)));
  if (options_.sync) VT_CHECK(file_.sync());
  VT_CHECK(replaced_ != nullptr ? take_place(file_, path_, *replaced_, options_.sync) : take_name(file_, path_, options_.sync));
  is_published_ = true;
  return file_.close();
}

}  // namespace vt::store
