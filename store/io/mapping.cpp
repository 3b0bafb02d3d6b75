#include "store/io/mapping.h"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>

namespace vt::store {

struct MappingWatch {
  std::atomic<std::uintptr_t> first = 0;
  std::atomic<std::size_t> bytes = 0;  // 0: of no mapping now
  std::atomic<bool> is_lost = false;
  std::atomic<bool> is_taken = true;
  MappingWatch* next = nullptr;
};

namespace {

// A signal handler can be told nothing but by what is global. The list only grows, and what is in it is used
// again, so that the handler may walk it whatever the other threads do.
std::atomic<MappingWatch*> g_watches = nullptr;
struct sigaction g_other_handler = {};

MappingWatch* take_watch() {
  for (MappingWatch* watch = g_watches.load(std::memory_order_acquire); watch != nullptr; watch = watch->next)
    if (!watch->is_taken.exchange(true)) return watch;
  MappingWatch* watch = std::make_unique<MappingWatch>().release();  // never freed, see above
  watch->next = g_watches.load(std::memory_order_relaxed);
  while (!g_watches.compare_exchange_weak(watch->next, watch, std::memory_order_release, std::memory_order_relaxed)) {
  }
  return watch;
}

std::size_t whole_pages(std::size_t bytes) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  return (bytes + page - 1) / page * page;
}

// Puts zeros in the place of the mapping that `address` lies in. False when it lies in none. Only calls that
// a signal handler may make.
bool put_zeros(std::uintptr_t address) {
  for (MappingWatch* watch = g_watches.load(std::memory_order_acquire); watch != nullptr; watch = watch->next) {
    const std::size_t bytes = watch->bytes.load(std::memory_order_acquire);
    const std::uintptr_t first = watch->first.load(std::memory_order_acquire);
    if (address < first || address - first >= bytes) continue;
    watch->is_lost.store(true, std::memory_order_release);
    return ::mmap(reinterpret_cast<void*>(first), bytes, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED, -1, 0) !=
           MAP_FAILED;
  }
  return false;
}

void on_bus_error(int signal, siginfo_t* info, void* context) {
  const int error_number = errno;
  const bool is_ours = put_zeros(reinterpret_cast<std::uintptr_t>(info->si_addr));
  errno = error_number;
  if (is_ours) return;  // and the access is made again
  if ((g_other_handler.sa_flags & SA_SIGINFO) != 0) {
    g_other_handler.sa_sigaction(signal, info, context);
  } else if (g_other_handler.sa_handler != SIG_DFL && g_other_handler.sa_handler != SIG_IGN) {
    g_other_handler.sa_handler(signal);
  } else {
    ::sigaction(signal, &g_other_handler, nullptr);  // the access is made again, and ends the process as it would have
  }
}

}  // namespace

void guard_mappings() {
  [[maybe_unused]] static const bool is_installed = [] {
    struct sigaction action = {};
    action.sa_sigaction = on_bus_error;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK;
    sigemptyset(&action.sa_mask);
    return ::sigaction(SIGBUS, nullptr, &g_other_handler) == 0 && ::sigaction(SIGBUS, &action, nullptr) == 0;
  }();
}

Result<Mapping> Mapping::map(const File& file, std::uint64_t bytes) {
  Mapping mapping;
  if (bytes == 0) return mapping;
  const auto refuse = [&](int error_number) {
    return fail(ErrorCode::kIo, file.path().string() + ": cannot map: " + std::generic_category().message(error_number));
  };
  // Zeros for all of it and the slack, and then the file over them.
  const std::size_t in_pages = whole_pages(bytes);
  void* address = ::mmap(nullptr, in_pages + kSlack, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (address == MAP_FAILED) return refuse(errno);
  if (::mmap(address, bytes, PROT_READ, MAP_SHARED | MAP_FIXED, file.descriptor(), 0) == MAP_FAILED) {
    const int error_number = errno;
    ::munmap(address, in_pages + kSlack);
    return refuse(error_number);
  }
  mapping.bytes_ = {static_cast<const std::byte*>(address), bytes};
  mapping.watch_ = take_watch();
  mapping.watch_->is_lost.store(false, std::memory_order_relaxed);
  mapping.watch_->first.store(reinterpret_cast<std::uintptr_t>(address), std::memory_order_release);
  mapping.watch_->bytes.store(in_pages, std::memory_order_release);
  return mapping;
}

void Mapping::read_ahead(std::uint64_t offset, std::uint64_t bytes) const {
  assert(offset <= bytes_.size() && bytes <= bytes_.size() - offset);
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const std::uint64_t first = offset / page * page;
  // Only a wish: what the system does with it changes no byte.
  if (bytes > 0) static_cast<void>(::madvise(const_cast<std::byte*>(bytes_.data()) + first, offset - first + bytes, MADV_WILLNEED));
}

bool Mapping::is_lost() const { return watch_ != nullptr && watch_->is_lost.load(std::memory_order_acquire); }

Mapping::Mapping(Mapping&& other) noexcept : bytes_(std::exchange(other.bytes_, {})), watch_(std::exchange(other.watch_, nullptr)) {}

Mapping& Mapping::operator=(Mapping&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  std::swap(watch_, other.watch_);
  return *this;
}

Mapping::~Mapping() {
  if (watch_ == nullptr) return;
  watch_->bytes.store(0, std::memory_order_release);
  ::munmap(const_cast<std::byte*>(bytes_.data()), whole_pages(bytes_.size()) + kSlack);
  watch_->is_taken.store(false, std::memory_order_release);
}

}  // namespace vt::store
