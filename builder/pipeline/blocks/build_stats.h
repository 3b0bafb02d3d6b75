// Where the time of a build went: every worker charges its time to one stage after another. A StageClock
// belongs to one thread.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace vt::pipeline {

enum class Stage : std::uint8_t {
  kRead,      // samples out of the sources, decompression included
  kDecode,    // samples to filter space
  kFilter,    // halving from level to level
  kQuantise,  // filter space to texels
  kEncode,    // block encoding and compression of whole tiles
  kStore,     // tiles into the store
  kCarry,     // carry tiles read back for the next tier
  kCheck,     // hashing of sources, to find what changed
  kWait,      // nothing left to do in this tier while other workers still have a block
  kCount,
};
inline constexpr std::size_t kStageCount = static_cast<std::size_t>(Stage::kCount);
[[nodiscard]] constexpr std::string_view stage_name(Stage stage) {
  constexpr std::array<std::string_view, kStageCount> kNames = {"read",  "decode", "filter", "quantise", "encode",
                                                                "store", "carry",  "check",  "wait"};
  return kNames[static_cast<std::size_t>(stage)];
}

// Seconds of all workers together, by Stage.
struct StageTimes {
  std::array<double, kStageCount> seconds = {};

  [[nodiscard]] double of(Stage stage) const { return seconds[static_cast<std::size_t>(stage)]; }
  StageTimes& operator+=(const StageTimes& other) {
    for (std::size_t i = 0; i < kStageCount; ++i) seconds[i] += other.seconds[i];
    return *this;
  }
};

class StageClock {
 public:
  using Clock = std::chrono::steady_clock;

  // A clock that is not running costs one comparison a switch.
  explicit StageClock(bool running) : running_(running), since_(running ? Clock::now() : Clock::time_point{}) {}

  // From here on the time goes to `stage`; gives the stage that had it.
  Stage enter(Stage stage) {
    const Stage before = stage_;
    if (running_) {
      const auto now = Clock::now();
      times_.seconds[static_cast<std::size_t>(before)] += std::chrono::duration<double>(now - since_).count();
      since_ = now;
      stage_ = stage;
    }
    return before;
  }
  // Up to now.
  [[nodiscard]] StageTimes times() {
    enter(stage_);
    return times_;
  }

 private:
  bool running_;
  Clock::time_point since_;
  Stage stage_ = Stage::kWait;
  StageTimes times_;
};

// For the length of a scope.
class InStage {
 public:
  InStage(StageClock& clock, Stage stage) : clock_(clock), before_(clock.enter(stage)) {}
  InStage(const InStage&) = delete;
  InStage& operator=(const InStage&) = delete;
  ~InStage() { clock_.enter(before_); }

 private:
  StageClock& clock_;
  Stage before_;
};

}  // namespace vt::pipeline
