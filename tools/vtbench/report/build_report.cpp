#include "tools/vtbench/report/build_report.h"

#include <fmt/format.h>

namespace vt::bench {
namespace {

Table empty_build_table() {
  return Table({{"job", "job"},
                {"kind", ""},
                {"name", "program or part"},
                {"mpx_per_s", "Mpx/s", 1},
                {"median_s", "median s", 3},
                {"min_s", "min", 3},
                {"max_s", "max", 3},
                {"ours_over_this", "vtbuild is x times", 2},
                {"build_over_parts", "build / parts", 2},
                {"peak_rss_bytes", ""},
                {"peak_mib", "peak MiB", 0},
                {"output_bytes", ""},
                {"output_mib", "output MiB", 1},
                {"cpu_s", "cpu s", 2},
                {"sync_s", "sync s", 3},
                {"version", ""},
                {"command", ""},
                {"runs", ""},
                {"threads", ""},
                {"input_width", ""},
                {"input_height", ""},
                {"input_bands", ""},
                {"input_bytes", ""},
                {"input_compression", ""},
                {"cpu", ""},
                {"cores", ""}});
}

}  // namespace

BuildReport::BuildReport(const Input& input, int threads) : input_(input), threads_(threads), table_(empty_build_table()) {}

void BuildReport::add(const Contender& contender, const Measured& measured) {
  const Spread seconds = measured.spread();
  if (contender.is_ours) {
    job_ = contender.job;
    ours_ = seconds;
    groups_.push_back({contender.job, {}});
  }
  const double peak = static_cast<double>(measured.peak_bytes);
  const double output = static_cast<double>(measured.output_bytes);
  table_.add_named_row({{"job", contender.job},
                        {"kind", std::string(contender.is_ours ? "ours" : "peer")},
                        {"name", contender.name},
                        {"mpx_per_s", input_.megapixels() / seconds.median},
                        {"median_s", seconds.median},
                        {"min_s", seconds.min},
                        {"max_s", seconds.max},
                        {"ours_over_this", contender.is_ours ? Cell() : Cell(seconds.median / ours_.median)},
                        {"peak_rss_bytes", peak},
                        {"peak_mib", peak / kMib},
                        {"output_bytes", output},
                        {"output_mib", output / kMib},
                        {"cpu_s", measured.processor_seconds},
                        {"sync_s", measured.sync_median()},
                        {"version", contender.version},
                        {"command", public_command(contender, input_.path.string())},
                        {"runs", double(measured.seconds.size())},
                        {"threads", double(threads_)},
                        {"input_width", double(input_.info.width)},
                        {"input_height", double(input_.info.height)},
                        {"input_bands", double(input_.info.bands)},
                        {"input_bytes", double(input_.file_bytes)},
                        {"input_compression", input_.info.compression},
                        {"cpu", machine_.cpu},
                        {"cores", double(machine_.cores)}});
  groups_.back().bars.push_back({contender.name, input_.megapixels() / seconds.median, input_.megapixels() / seconds.max,
                                 input_.megapixels() / seconds.min, contender.is_ours});
}

void BuildReport::add_part(const char* name, double seconds) {
  if (seconds <= 0.0) return;
  table_.add_named_row({{"job", job_},
                        {"kind", std::string("part")},
                        {"name", "  " + std::string(name)},
                        {"mpx_per_s", input_.megapixels() / seconds},
                        {"median_s", seconds},
                        {"threads", 1.0},
                        {"input_width", double(input_.info.width)},
                        {"input_height", double(input_.info.height)}});
}

void BuildReport::add_parts(const PartSeconds& parts) {
  add_part("reading, 1 thread", parts.read);
  add_part("filter, 1 thread", parts.filter);
  add_part("BC1 encoder, 1 thread", parts.encode);
  add_part("compression, 1 thread", parts.compress);
  add_part("writing into the page cache, 1 thread", parts.write);
  add_part("sync to the disk", parts.sync);
  add_part("hashing, 1 thread (not in the sum)", parts.hash);
  add_sum("parts", fmt::format("  parts / {} threads", threads_), parts.least_seconds(threads_));
  add_sum("parts and sync", fmt::format("  parts / {} threads + sync", threads_), parts.least_seconds(threads_) + parts.sync);
}

void BuildReport::add_sum(const char* kind, const std::string& name, double seconds) {
  table_.add_named_row({{"job", job_},
                        {"kind", std::string(kind)},
                        {"name", name},
                        {"mpx_per_s", input_.megapixels() / seconds},
                        {"median_s", seconds},
                        {"build_over_parts", ours_.median / seconds},
                        {"threads", double(threads_)},
                        {"input_width", double(input_.info.width)},
                        {"input_height", double(input_.info.height)}});
}

BarChart BuildReport::chart(const std::string& subject) const {
  BarChart chart;
  chart.title = "Building a pyramid: vtbuild beside other tools";
  chart.axis = "Mpx/s of the finest level, median; longer is better";
  chart.groups = groups_;
  chart.notes = {subject, machine_.text(),
                 "vtbuild syncs its store to the disk before it ends, the other tools do not. It averages colour in linear light, the "
                 "others average codes.",
                 "gdaladdo adds overviews only, to a finest level that is there already."};
  return chart;
}

}  // namespace vt::bench
