// The table and the chart of whole builds: contenders side by side, and the parts that no builder can do
// without.
#pragma once

#include <vector>

#include "tools/vtbench/measure/parts.h"
#include "tools/vtbench/measure/whole_builds.h"
#include "tools/vtbench/peers/contenders.h"
#include "tools/vtbench/report/svg.h"
#include "tools/vtbench/report/table.h"

namespace vt::bench {

class BuildReport {
 public:
  // Refers to `input`.
  BuildReport(const Input& input, int threads);

  // Our own build of a job comes before its peers.
  void add(const Contender& contender, const Measured& measured);
  // Adds the seconds of its parts to the job of our build that was added last.
  void add_parts(const PartSeconds& parts);

  [[nodiscard]] const Table& table() const { return table_; }
  [[nodiscard]] BarChart chart(const std::string& subject) const;

 private:
  void add_part(const char* name, double seconds);
  void add_sum(const char* kind, const std::string& name, double seconds);

  const Input& input_;
  int threads_;
  Machine machine_ = this_machine();
  Table table_;
  std::vector<BarGroup> groups_;
  std::string job_;
  Spread ours_;
};

}  // namespace vt::bench
