#include "store/format/file_beside.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <set>

#include "store/pack.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;

struct stat status_of(const std::filesystem::path& path) {
  struct stat info = {};
  if (lstat(path.c_str(), &info) != 0) throw std::runtime_error(path.string() + ": cannot stat");
  return info;
}

struct FileBeside : testing::Test {
  TempFolder folder;
  std::filesystem::path path = folder / "a.vts";

  void build(const std::filesystem::path& where, int version = 0) {
    StoreWriter writer = value_of(StoreWriter::create(where, {}, {.sync = false}));
    const LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 4, 3);
    const LayerId id = value_of(writer.add_layer(layer));
    for (int level = 0; level <= 3; ++level) {
      const TileId tile = tile_at(level, 0, 0);
      succeed(writer.put(id, tile, encoded(tile_bytes(layer, tile, version))));
    }
    succeed(writer.set_state(id, LayerState::kComplete));
    succeed(writer.finish());
  }
  // Packs in place and calls `look` before every write and sync, with the file on its way.
  Result<PackReport> pack_and(const std::function<void(const std::filesystem::path& beside)>& look) {
    return pack_in_place(path, {.writer = {.before_operation = [&](const FileOperation&) {
                                  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
                                    if (entry.path().string().find(".new-") != std::string::npos) look(entry.path());
                                  return 0;
                                }}});
  }
};

TEST_F(FileBeside, HasARandomNameAndTheLock) {
  std::set<std::string> names;
  for (int i = 0; i < 20; ++i) {
    const File file = value_of(create_beside(path));
    EXPECT_THAT(file.path().filename().string(), MatchesRegex("a\\.vts\\.new-[0-9a-f]{16}"));
    names.insert(file.path().string());
    File other = value_of(File::open(file.path(), File::Mode::kRead));
    EXPECT_FALSE(value_of(other.try_lock()));
  }
  EXPECT_EQ(names.size(), 20U);
}

TEST_F(FileBeside, TheUmaskRulesANewStoreAndTheOldFileOneInItsPlace) {
  const mode_t before = umask(027);
  build(path);
  umask(before);
  EXPECT_EQ(status_of(path).st_mode & 07777, 0640U);
  for (const mode_t mode : {0600U, 0644U, 0660U, 0400U}) {
    ASSERT_EQ(chmod(path.c_str(), mode), 0);
    int looks = 0;
    ASSERT_TRUE(pack_and([&](const std::filesystem::path& beside) {
      ++looks;
      EXPECT_EQ(status_of(beside).st_mode & 07777, mode);
    }));
    EXPECT_GT(looks, 3);
    EXPECT_EQ(status_of(path).st_mode & 07777, mode);
  }
}

TEST_F(FileBeside, TheOwnerStaysFromTheStart) {
  if (geteuid() != 0) GTEST_SKIP() << "only root may give files away";
  build(path);
  ASSERT_EQ(chown(path.c_str(), 12345, 23456), 0);
  ASSERT_EQ(chmod(path.c_str(), 0600), 0);
  int looks = 0;
  ASSERT_TRUE(pack_and([&](const std::filesystem::path& beside) {
    ++looks;
    EXPECT_EQ(status_of(beside).st_uid, 12345U);
    EXPECT_EQ(status_of(beside).st_gid, 23456U);
    EXPECT_EQ(status_of(beside).st_mode & 07777, 0600U);
  }));
  EXPECT_GT(looks, 3);
  EXPECT_EQ(status_of(path).st_uid, 12345U);
  EXPECT_EQ(status_of(path).st_gid, 23456U);
}

TEST_F(FileBeside, AnOwnerWhoCannotBeKeptIsARefusal) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can take another user's place";
  build(path);
  ASSERT_EQ(chmod(path.c_str(), 0644), 0);
  ASSERT_EQ(chmod(folder.path().c_str(), 0777), 0);
  const Bytes whole = read_file(path);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (setgid(23456) != 0 || setuid(12345) != 0) _exit(3);
    const auto packed = pack_in_place(path);
    const bool is_right = !packed && packed.error().code == ErrorCode::kIo && packed.error().message.find("user 0") != std::string::npos;
    _exit(is_right ? 0 : 4);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(read_file(path), whole);
  EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts"));
}

TEST_F(FileBeside, AStoreThatTookTheNameMeanwhileKeepsIt) {
  build(path);
  build(folder / "b.vts", 1);
  const Bytes other = read_file(folder / "b.vts");
  bool is_done = false;
  const auto packed = pack_and([&](const std::filesystem::path&) {
    if (!is_done) std::filesystem::rename(folder / "b.vts", path);
    is_done = true;
  });
  ASSERT_FALSE(packed);
  EXPECT_EQ(packed.error().code, ErrorCode::kExists);
  EXPECT_THAT(packed.error().message, HasSubstr("a.vts: was replaced or removed by another program"));
  EXPECT_EQ(read_file(path), other);
  EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts"));
}

TEST_F(FileBeside, AStoreThatWasRemovedMeanwhileStaysRemoved) {
  build(path);
  const auto packed = pack_and([&](const std::filesystem::path&) { std::filesystem::remove(path); });
  ASSERT_FALSE(packed);
  EXPECT_EQ(packed.error().code, ErrorCode::kExists);
  EXPECT_THAT(names_in(folder.path()), IsEmpty());
}

TEST_F(FileBeside, ANewNameThatIsTakenMeanwhileIsNotOverwritten) {
  build(path);
  const StoreReader reader = value_of(StoreReader::open(path));
  const auto packed = pack(reader, folder / "b.vts", {.writer = {.before_operation = [&](const FileOperation&) {
                                                        write_file(folder / "b.vts", Bytes(3));
                                                        return 0;
                                                      }}});
  ASSERT_FALSE(packed);
  EXPECT_EQ(packed.error().code, ErrorCode::kExists);
  EXPECT_EQ(read_file(folder / "b.vts"), Bytes(3));
  EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts", "b.vts"));
}

TEST_F(FileBeside, NobodyWritesToAStoreWhileItIsPacked) {
  build(path);
  int refused = 0;
  ASSERT_TRUE(pack_and([&](const std::filesystem::path&) {
    const auto writer = StoreWriter::open(path);
    ASSERT_FALSE(writer);
    EXPECT_EQ(writer.error().code, ErrorCode::kExists);
    ++refused;
  }));
  EXPECT_GT(refused, 3);
}

TEST_F(FileBeside, AWriterWhoseStoreWasReplacedSaysSo) {
  build(path);
  for (const bool is_replaced : {true, false}) {
    build(folder / "b.vts", 1);
    StoreWriter writer = value_of(StoreWriter::open(path));
    succeed(writer.set_metadata(LayerId{0}, is_replaced ? "1" : "2"));
    if (is_replaced) {
      std::filesystem::rename(folder / "b.vts", path);
    } else {
      std::filesystem::remove(path);
    }
    const auto finished = writer.finish();
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().code, ErrorCode::kIo);
    EXPECT_THAT(finished.error().message, HasSubstr("a.vts: was moved, removed or replaced by another program"));
  }
}

// ---- Leftovers ----

struct Leftovers : FileBeside {
  // A child that packs, or creates, and dies at its operation number `die_at`. False when it came to its end
  // before.
  bool kill_at(std::size_t die_at, bool in_place) {
    const pid_t child = fork();
    if (child == 0) {
      std::size_t count = 0;
      const WriterOptions dying{.before_operation = [&](const FileOperation&) {
        if (count++ == die_at) kill(getpid(), SIGKILL);
        return 0;
      }};
      if (in_place) _exit(pack_in_place(path, {.writer = dying}) ? 0 : 3);
      _exit(StoreWriter::create(folder / "b.vts", {}, dying) ? 0 : 3);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
    return WIFSIGNALED(status);
  }
};

TEST_F(Leftovers, OfAKilledPackGoWithTheNextPackOrWriterAndAreNamed) {
  build(path);
  const Contents truth = read_all(value_of(StoreReader::open(path)));
  for (std::size_t die_at = 0; kill_at(die_at, true); ++die_at) {
    const auto names = names_in(folder.path());
    ASSERT_EQ(names.size(), 2U) << die_at;
    EXPECT_EQ(read_all(value_of(StoreReader::open(path))), truth);
    if (die_at % 2 == 0) {
      EXPECT_THAT(value_of(pack_in_place(path)).removed_leftovers, ElementsAre(folder / names[1]));
    } else {
      EXPECT_THAT(value_of(StoreWriter::open(path)).removed_leftovers(), ElementsAre(folder / names[1]));
    }
    EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts"));
    EXPECT_EQ(read_all(value_of(StoreReader::open(path))), truth);
  }
}

TEST_F(Leftovers, OfAStoreThatWasNeverBornGoWhenItIs) {
  for (std::size_t die_at = 0; kill_at(die_at, false); ++die_at) {
    ASSERT_EQ(names_in(folder.path()).size(), 1U);
    EXPECT_EQ(value_of(StoreWriter::create(folder / "b.vts", {})).removed_leftovers().size(), 1U);
    EXPECT_THAT(names_in(folder.path()), ElementsAre("b.vts"));
    std::filesystem::remove(folder / "b.vts");
  }
}

TEST_F(Leftovers, OfLiveWritersAndOtherPeoplesFilesStay) {
  build(path);
  const File live = value_of(create_beside(path));
  build(folder / "a.vts.new-2024");                              // somebody's copy
  write_file(folder / "a.vts.new-notes", Bytes(3));              // and notes
  write_file(folder / "a.vts.new-0123456789ABCDEF", Bytes(3));   // not how we write digits
  write_file(folder / "ba.vts.new-0123456789abcdef", Bytes(3));  // of another store
  std::filesystem::create_directory(folder / "a.vts.new-00000000000000aa");
  std::filesystem::create_symlink(path, folder / "a.vts.new-00000000000000bb");
  const auto before = names_in(folder.path());
  EXPECT_THAT(remove_leftovers(path), IsEmpty());
  EXPECT_EQ(names_in(folder.path()), before);

  write_file(folder / "a.vts.new-00000000000000cc", Bytes(9000));  // ours, of a killed writer
  write_file(folder / "a.vts.new-3141592653", Bytes(9000));        // an older program's
  EXPECT_THAT(remove_leftovers(path), ElementsAre(folder / "a.vts.new-00000000000000cc", folder / "a.vts.new-3141592653"));
  EXPECT_EQ(names_in(folder.path()), before);
}

}  // namespace
}  // namespace vt::store
