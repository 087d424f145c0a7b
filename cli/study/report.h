// What a study leaves in its folder: data, tables, plots and the page.
#pragma once

#include <filesystem>
#include <string>

#include "cli/study/results.h"

namespace evograsp::cli::study {

struct Report {
  std::filesystem::path out;
  std::string command;      // that made it, without the folder
  std::size_t planned = 0;  // runs; more than data has when the study was interrupted
};

// runs, tests and generations, and each table of the study, as .csv and .json; each plot as .svg and .png;
// README.md and report.html. notes.md of the folder, when it is there, is taken into the page. Files are
// replaced as a whole.
Status write_report(const LoadedStudy& study, const Data& data, const Report& report);

}  // namespace evograsp::cli::study
