// What a run leaves in its folder beside run.db: champion.pb, fitness.png, report.html.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/plot.h"
#include "common/result.h"
#include "proto/genome.pb.h"
#include "server/store_records.h"

namespace evograsp::cli {

// A run as its run.db tells it.
struct RunFolder {
  std::filesystem::path path;
  server::RunInfo info;
  std::string state;  // running, paused, finished, stopped, failed
  std::vector<server::GenerationRecord> generations;
  std::optional<proto::Champion> champion;

  FitnessPlot plot() const;
};
Result<RunFolder> read_run_folder(const std::filesystem::path& path);

// A page of its own: no other file, no network. `picture`: a PNG of the champion's grasp; may not exist.
Result<std::string> report_html(const RunFolder& run, const std::filesystem::path& picture);

// champion.pb (deterministic bytes), fitness.png, report.html.
Status write_results(const RunFolder& run);

// `wanted` when it holds no run yet, else the first free one of wanted-2, wanted-3, ...
std::filesystem::path fresh_folder(const std::filesystem::path& wanted);

}  // namespace evograsp::cli
