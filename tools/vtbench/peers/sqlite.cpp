// SQLite as a peer of our index: a table WITHOUT ROWID by integer key, filled in order in one transaction,
// read through a prepared statement.
#include <array>
#include <cstring>

#include "tools/vtbench/peers/key_value.h"

#ifdef VT_HAS_SQLITE
#include <sqlite3.h>

namespace vt::bench {
namespace {

class Sqlite final : public KeyValueStore {
 public:
  ~Sqlite() override {
    sqlite3_finalize(select_);
    sqlite3_close(database_);
  }
  std::string name() const override { return std::string("SQLite ") + sqlite3_libversion(); }

  Result<void> load(const std::filesystem::path& folder, std::uint64_t bytes, const KeySource& keys) override {
    VT_CHECK(check(sqlite3_open((folder / "sqlite").c_str(), &database_)));
    // No durability: the database lives as long as the measurement. All of it in its cache or mapped, so that
    // gets find it warm.
    VT_CHECK(run("PRAGMA journal_mode=OFF"));
    VT_CHECK(run("PRAGMA synchronous=OFF"));
    VT_CHECK(run("PRAGMA locking_mode=EXCLUSIVE"));
    VT_CHECK(run("PRAGMA mmap_size=" + std::to_string(4 * bytes)));
    VT_CHECK(run("PRAGMA cache_size=-" + std::to_string(1 << 20)));  // KiB
    VT_CHECK(run("CREATE TABLE tile (key INTEGER PRIMARY KEY, value BLOB) WITHOUT ROWID"));
    VT_CHECK(run("BEGIN"));
    sqlite3_stmt* insert = nullptr;
    VT_CHECK(check(sqlite3_prepare_v2(database_, "INSERT INTO tile VALUES (?, ?)", -1, &insert, nullptr)));
    const auto loaded = keys([&](std::uint64_t key) -> Result<void> {
      const std::array<std::uint64_t, 2> value = {key, ~key};
      sqlite3_bind_int64(insert, 1, static_cast<sqlite3_int64>(key));
      sqlite3_bind_blob(insert, 2, value.data(), sizeof value, SQLITE_STATIC);
      const int code = sqlite3_step(insert);
      sqlite3_reset(insert);
      return check(code == SQLITE_DONE ? SQLITE_OK : code);
    });
    sqlite3_finalize(insert);
    VT_CHECK(loaded);
    VT_CHECK(run("COMMIT"));
    return check(sqlite3_prepare_v3(database_, "SELECT value FROM tile WHERE key = ?", -1, SQLITE_PREPARE_PERSISTENT, &select_, nullptr));
  }

  Result<bool> get(std::uint64_t key) override {
    sqlite3_bind_int64(select_, 1, static_cast<sqlite3_int64>(key));
    const int code = sqlite3_step(select_);
    std::array<std::uint64_t, 2> value = {0, 0};
    if (code == SQLITE_ROW && sqlite3_column_bytes(select_, 0) == sizeof value)
      std::memcpy(value.data(), sqlite3_column_blob(select_, 0), sizeof value);
    sqlite3_reset(select_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) VT_CHECK(check(code));
    return value[0] == key && value[1] == ~key;
  }

 private:
  [[nodiscard]] Result<void> check(int code) const {
    if (code != SQLITE_OK) return fail(ErrorCode::kIo, std::string("SQLite: ") + sqlite3_errmsg(database_));
    return {};
  }
  [[nodiscard]] Result<void> run(const std::string& sql) const {
    return check(sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr));
  }

  sqlite3* database_ = nullptr;
  sqlite3_stmt* select_ = nullptr;
};

}  // namespace

std::unique_ptr<KeyValueStore> make_sqlite() { return std::make_unique<Sqlite>(); }

}  // namespace vt::bench

#else

std::unique_ptr<vt::bench::KeyValueStore> vt::bench::make_sqlite() { return nullptr; }

#endif
