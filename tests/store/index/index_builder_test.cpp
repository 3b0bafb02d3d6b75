#include "store/index/index_builder.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "store/index/page_cache.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;

using PageName = std::pair<std::uint64_t, int>;  // key and height

// Where a page lies follows from its name alone, so that two indexes with the same entries have the same
// bytes whatever the order in which their pages were written.
Reference reference_to(const PageName& name, std::span<const std::byte> payload) {
  return {.offset = kLogStart + kRecordAlignment * (name.first * 8 + static_cast<std::uint64_t>(name.second)) % (kMaxFileBytes / 2),
          .stored_bytes = static_cast<std::uint32_t>(payload.size()),
          .check = static_cast<std::uint32_t>(hash_bytes(payload)),
          .kind = ReferenceKind::kPage};
}

struct PagesOfBuilder final : IndexBuilder::Sink {
  std::map<PageName, Bytes> pages;
  std::vector<PageName> order;

  Result<Reference> place_page(std::uint64_t key, int height, std::span<const std::byte> payload) override {
    EXPECT_TRUE(pages.emplace(PageName{key, height}, Bytes(payload.begin(), payload.end())).second) << "a page is finished once";
    order.emplace_back(key, height);
    return reference_to({key, height}, payload);
  }
};

struct PagesOfCache final : PageCache::Log {
  std::map<PageName, Bytes> pages;
  std::map<std::uint64_t, Bytes> by_offset;
  std::map<Level, Reference> roots;

  Result<Reference> append_page(std::uint64_t key, std::span<const std::byte> payload) override {
    const PageName name{key, std::to_integer<int>(payload[2])};
    pages[name] = Bytes(payload.begin(), payload.end());
    const Reference reference = reference_to(name, payload);
    by_offset[reference.offset] = pages[name];
    return reference;
  }
  Result<std::vector<std::byte>> read_page(const Reference& reference, std::uint64_t, Level, int) override {
    return by_offset.at(reference.offset);
  }
  Reference& root(LayerId, Level level) override { return roots[level]; }
};

Reference entry_for(std::uint64_t morton) {
  return {.offset = kLogStart + kRecordAlignment * (morton % 100000),
          .stored_bytes = static_cast<std::uint32_t>(48 + morton % 7),
          .check = static_cast<std::uint32_t>(morton * 2654435761),
          .kind = morton % 3 == 0 ? ReferenceKind::kConstant : ReferenceKind::kTile};
}

struct Case {
  const char* name;
  int level;
  std::set<std::uint64_t> mortons;
};

std::vector<Case> cases() {
  std::vector<Case> cases;
  for (const int level : {0, 1, 5, 6, 7}) {
    std::set<std::uint64_t> all;
    for (std::uint64_t morton = 0; morton < std::uint64_t{1} << (2 * level); ++morton) all.insert(morton);
    cases.push_back({"dense", level, all});
  }
  std::mt19937_64 random(5);
  for (const int level : {4, 9, 11, 16, 23}) {
    const std::uint64_t end = std::uint64_t{1} << (2 * level);
    cases.push_back({"first only", level, {0}});
    cases.push_back({"last only", level, {end - 1}});
    std::set<std::uint64_t> scattered{0, end - 1};
    for (int i = 0; i < 300; ++i) scattered.insert(random() % end);
    cases.push_back({"scattered", level, scattered});
    std::set<std::uint64_t> across_pages;  // a run over the border of pages of every height
    for (std::uint64_t i = 0; i < 40; ++i) across_pages.insert(end / 2 - 20 + i);
    cases.push_back({"across the borders of pages", level, across_pages});
  }
  return cases;
}

TEST(IndexBuilder, WritesThePagesThatTheWritersCacheWrites) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(std::string(c.name) + ", level " + std::to_string(c.level));
    const Level level{static_cast<std::uint8_t>(c.level)};
    const LayerId layer{7};
    PagesOfBuilder built;
    IndexBuilder builder(built, layer, level);
    for (const std::uint64_t morton : c.mortons) succeed(builder.add(morton, entry_for(morton)));
    const Reference root = value_of(builder.finish());

    PagesOfCache cached;
    PageCache cache(cached);
    for (const std::uint64_t morton : c.mortons)
      ASSERT_FALSE(value_of(cache.exchange(layer, tile_from_morton(level, morton), entry_for(morton))).present());
    succeed(cache.flush());

    ASSERT_EQ(built.pages, cached.pages);
    EXPECT_EQ(root, cached.roots[level]);
  }
}

TEST(IndexBuilder, GivesPagesOfAHeightInTheOrderOfTheirKeysAndChildrenBeforeParents) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(std::string(c.name) + ", level " + std::to_string(c.level));
    const Level level{static_cast<std::uint8_t>(c.level)};
    PagesOfBuilder built;
    IndexBuilder builder(built, {0}, level);
    for (const std::uint64_t morton : c.mortons) succeed(builder.add(morton, entry_for(morton)));
    static_cast<void>(value_of(builder.finish()));
    std::map<int, std::uint64_t> last;
    std::set<PageName> seen;
    for (const auto& [key, height] : built.order) {
      if (last.contains(height)) {
        EXPECT_GT(key, last[height]);
      }
      last[height] = key;
      for (const auto& [child_key, child_height] : built.order)
        if (child_height == height - 1 && (child_key >> (kPageBits * (height + 1))) == (key >> (kPageBits * (height + 1)))) {
          EXPECT_TRUE(seen.contains({child_key, child_height}));
        }
      seen.emplace(key, height);
    }
  }
}

TEST(IndexBuilder, ALevelWithoutEntriesHasNoRoot) {
  PagesOfBuilder built;
  IndexBuilder builder(built, {0}, Level{12});
  EXPECT_FALSE(value_of(builder.finish()).present());
  EXPECT_TRUE(built.pages.empty());
}

TEST(IndexBuilder, PassesOnWhatTheSinkCannotDo) {
  struct FullDisk final : IndexBuilder::Sink {
    Result<Reference> place_page(std::uint64_t, int, std::span<const std::byte>) override { return fail(ErrorCode::kIo, "full"); }
  } full;
  IndexBuilder builder(full, {0}, Level{6});
  succeed(builder.add(0, entry_for(0)));
  const auto second_page = builder.add(1024, entry_for(1024));
  ASSERT_FALSE(second_page);
  EXPECT_EQ(second_page.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace vt::store
