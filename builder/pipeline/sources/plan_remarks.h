// What a plan tells a person about many sources without saying it ten thousand times.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/pipeline/request/layer_request.h"
#include "builder/pipeline/sources/open_sources.h"
#include "builder/pipeline/sources/place_source.h"
#include "builder/resample/grid/placed_source.h"

namespace vt::pipeline {

// A remark of one kind about many files, cut short. `what` completes "and 12 more files that are ...".
class Remarks {
 public:
  explicit Remarks(std::string what) : what_(std::move(what)) {}
  void add(std::string text);
  void append_to(std::vector<std::string>& warnings) const;

 private:
  std::string what_;
  std::size_t count_ = 0;
  std::vector<std::string> texts_;
};

// A remark that is the same for every file that it is about: said once, with the first file's name and how
// many more there are.
class SharedRemarks {
 public:
  // `text` goes on after the names: "holds ...".
  void add(const std::string& text, const std::string& path);
  void append_to(std::vector<std::string>& warnings) const;

 private:
  struct Files {
    std::string text;
    std::string first;
    std::size_t count = 0;
  };
  std::vector<Files> remarks_;  // in the order of their first files
};

// What should be known about sources before a long build: which are left out, moved, resampled, or may come
// out dark; what the files declare of their numbers and how that is taken, and what they hold that is not
// used.
void remark_on(const LayerRequest& request, const geo::Crs& crs, const std::vector<OpenSource>& sources,
               const std::vector<SourcePlaces>& places, std::vector<std::string>& warnings);

// Which sources of a request are not there, in words; "" when all are.
[[nodiscard]] std::string missing_text(const LayerRequest& request);

}  // namespace vt::pipeline
