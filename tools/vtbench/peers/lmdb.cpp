// LMDB as a peer of our index: integer keys, appended in order, read in one transaction through its memory
// map.
#include <array>
#include <cstring>

#include "tools/vtbench/peers/key_value.h"

#ifdef VT_HAS_LMDB
#include <lmdb.h>

namespace vt::bench {
namespace {

class Lmdb final : public KeyValueStore {
 public:
  ~Lmdb() override {
    if (transaction_ != nullptr) mdb_txn_abort(transaction_);
    if (environment_ != nullptr) mdb_env_close(environment_);
  }
  std::string name() const override {
    int major = 0;
    int minor = 0;
    int patch = 0;
    mdb_version(&major, &minor, &patch);
    return "LMDB " + std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
  }

  Result<void> load(const std::filesystem::path& folder, std::uint64_t bytes, const KeySource& keys) override {
    VT_CHECK(check(mdb_env_create(&environment_)));
    VT_CHECK(check(mdb_env_set_mapsize(environment_, 2 * bytes + (std::size_t{64} << 20))));
    // No durability: the database lives as long as the measurement. No read-ahead: gets are random.
    VT_CHECK(check(mdb_env_open(environment_, (folder / "lmdb").c_str(), MDB_NOSUBDIR | MDB_NOSYNC | MDB_NORDAHEAD | MDB_WRITEMAP, 0666)));
    VT_CHECK(check(mdb_txn_begin(environment_, nullptr, 0, &transaction_)));
    VT_CHECK(check(mdb_dbi_open(transaction_, nullptr, MDB_INTEGERKEY, &database_)));
    VT_CHECK(keys([&](std::uint64_t key) -> Result<void> {
      std::array<std::uint64_t, 2> value = {key, ~key};
      MDB_val k{sizeof key, &key};
      MDB_val v{sizeof value, value.data()};
      return check(mdb_put(transaction_, database_, &k, &v, MDB_APPEND));
    }));
    VT_CHECK(check(mdb_txn_commit(std::exchange(transaction_, nullptr))));
    return check(mdb_txn_begin(environment_, nullptr, MDB_RDONLY, &transaction_));
  }

  Result<bool> get(std::uint64_t key) override {
    MDB_val k{sizeof key, &key};
    MDB_val v;
    const int code = mdb_get(transaction_, database_, &k, &v);
    if (code == MDB_NOTFOUND) return false;
    VT_CHECK(check(code));
    std::array<std::uint64_t, 2> value;
    std::memcpy(value.data(), v.mv_data, sizeof value);
    return value[0] == key && value[1] == ~key;
  }

 private:
  [[nodiscard]] static Result<void> check(int code) {
    if (code != 0) return fail(ErrorCode::kIo, std::string("LMDB: ") + mdb_strerror(code));
    return {};
  }
  MDB_env* environment_ = nullptr;
  MDB_txn* transaction_ = nullptr;
  MDB_dbi database_ = 0;
};

}  // namespace

std::unique_ptr<KeyValueStore> make_lmdb() { return std::make_unique<Lmdb>(); }

}  // namespace vt::bench

#else

std::unique_ptr<vt::bench::KeyValueStore> vt::bench::make_lmdb() { return nullptr; }

#endif
