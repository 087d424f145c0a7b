// A study as its file tells it, and the runs that it consists of.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/config.h"
#include "common/result.h"
#include "proto/study.pb.h"

namespace evograsp::cli::study {

using Diagnostics = std::vector<Diagnostic>;

// Names of the studies inside the program, sorted.
std::vector<std::string> builtin_studies();

struct LoadedStudy {
  std::string name;            // the file's, without its extension
  std::string file;            // as diagnostics name it
  std::filesystem::path base;  // configs that it names by file are relative to this
  proto::Study study;          // every default written out
};
// A file, or the name of a built-in study. All mistakes at once: of the text, and names that no axis, column
// or value has.
tl::expected<LoadedStudy, Diagnostics> load_study(const std::string& name_or_file);

// One choice of a value an axis, and a seed.
struct PlannedRun {
  std::string id;                            // the folder's name: "cube-true-3"
  std::map<std::string, std::string> place;  // axis to value's name, tags among them
  std::uint64_t seed = 1;
  std::string config;
  std::vector<std::string> overrides;  // of config, the seed included; in the order in which they count
  int slots = 0;                       // 0: as the command says
  std::vector<std::string> test_objects;
};

struct Selection {
  std::uint32_t seeds = 0;             // 0: as many as the study says
  std::vector<std::string> only;       // "AXIS=VALUE,VALUE": no other values of this axis
  std::vector<std::string> overrides;  // after the study's own
  int cores = 1;                       // for slots_to_cores
};
// Every run, seeds outermost: a study that is interrupted has a little of everything. An error names what
// `only` allows, or a matrix of more than 100,000 runs.
Result<std::vector<PlannedRun>> plan(const LoadedStudy& study, const Selection& selection);

// Columns of the three tables of data besides the axes' and "seed".
const std::vector<std::string>& columns_of(proto::StudySource source);

// Axes, then tags: the columns that say which run it is, in the order of the study.
std::vector<std::string> place_columns(const proto::Study& study);

// How a value is called on the page.
std::string label_of(const proto::Study& study, const std::string& axis, const std::string& value);

}  // namespace evograsp::cli::study
