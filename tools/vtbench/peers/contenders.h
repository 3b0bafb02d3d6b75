// Who builds what: the jobs that suit an input, and the command of every program that is measured at them.
// Runs nothing but look-ups of installed programs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "builder/source/raster_source.h"
#include "tools/vtbench/measure/parts.h"
#include "tools/vtbench/peers/child_process.h"

namespace vt::bench {

struct Input {
  std::filesystem::path path;
  source::RasterInfo info;
  std::uint64_t file_bytes = 0;
  double raw_bytes = 0.0;  // of all samples
  [[nodiscard]] double megapixels() const { return static_cast<double>(info.width) * static_cast<double>(info.height) / 1e6; }
  // "16384 x 16384, 3 bands of 8 bits, tiled, uncompressed"
  [[nodiscard]] std::string text() const;
};
[[nodiscard]] Result<Input> open_input(const std::filesystem::path& path);

// One program and what it makes of an input.
struct Contender {
  std::string job;      // what is compared: contenders of one job stand side by side
  std::string name;     // for tables and charts
  std::string version;  // as the program says it
  bool is_ours = false;
  JobKind kind;  // of ours
  ChildCommand command;
  std::filesystem::path result;
  std::optional<std::filesystem::path> starts_from;  // works on a copy of this, made beforehand and not counted
};

// Heights for a single band of floats or 16 bit integers, colour for everything else.
[[nodiscard]] std::vector<JobKind> jobs_for(const source::RasterInfo& info);
[[nodiscard]] std::string job_title(const JobKind& job);
// Colour as small as it is drawn: what sizes, mosaics and kinds of sources are compared by, so that stores
// leave room on the disk.
[[nodiscard]] const JobKind& compact_job();

// How every program of one comparison is run.
struct Setting {
  std::filesystem::path vtbuild;
  std::filesystem::path scratch;  // results and messages go here
  int threads = 2;
  bool with_peers = true;
};

// `input` is what vtbuild accepts as INPUT. `is_placed`: it says itself where on earth it lies.
[[nodiscard]] Contender our_build(const JobKind& job, const std::string& input, bool is_placed, const Setting& setting);
// Other tools that write a pyramid of all levels of a colour image; each is nullopt when it is not installed.
[[nodiscard]] std::optional<Contender> vips_pyramid(const Input& input, const Setting& setting);
[[nodiscard]] std::optional<Contender> gdaladdo(const std::string& resampling, const JobKind& job, const Input& input,
                                                const Setting& setting);

// All jobs for the input; our own build first in each job, its peers after it.
[[nodiscard]] std::vector<Contender> contenders_for(const Input& input, const Setting& setting);

// The command as anybody would repeat it: IN and OUT for the files, no folders of this machine.
[[nodiscard]] std::string public_command(const Contender& contender, const std::string& input);
// The command as it is run.
[[nodiscard]] std::string full_command(const Contender& contender);

}  // namespace vt::bench
