// From finished runs to tables: the three of data, and those that the study asks for.
#pragma once

#include "cli/study/dataset.h"
#include "cli/study/runner.h"

namespace evograsp::cli::study {

// docs/EXPERIMENTS.md says what each column is.
struct Data {
  DataTable runs, tests, generations;
  const DataTable& of(proto::StudySource source) const {
    return source == proto::RUNS ? runs : source == proto::TESTS ? tests : generations;
  }
};
Data collect(const proto::Study& study, const std::vector<DoneRun>& done);

// A table that the study asks for.
struct SummedTable {
  const proto::StudyTable* spec = nullptr;
  DataTable data;  // columns: by, the columns' names, "seeds", and the reference's label when there are any
  std::vector<std::vector<Cell>> means;  // rows for the page below the others, when mean_row asks for them
};
SummedTable sum_up(const proto::StudyTable& spec, const Data& data);

}  // namespace evograsp::cli::study
