#include "cli/run_folder.h"

#include "cli/inputs.h"
#include "common/digest.h"
#include "server/store_reader.h"

namespace evograsp::cli {

namespace fs = std::filesystem;

FitnessPlot RunFolder::plot() const {
  FitnessPlot plot;
  plot.title = info.name + ": fitness over " + std::to_string(generations.size()) + " generations";
  for (const server::GenerationRecord& g : generations)
    plot.points.push_back({g.generation, g.best, g.mean, g.species});
  return plot;
}

Result<RunFolder> read_run_folder(const fs::path& path) {
  auto reader = server::StoreReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  RunFolder run;
  run.path = path;
  auto info = (*reader)->run();
  if (!info) return tl::unexpected(info.error());
  run.info = std::move(*info);
  auto progress = (*reader)->progress();
  if (!progress) return tl::unexpected(progress.error());
  run.state = progress->state;
  auto generations = (*reader)->generations(0, run.info.config.run().generations());
  if (!generations) return tl::unexpected(generations.error());
  run.generations = std::move(*generations);
  const auto champion = (*reader)->champion();
  if (!champion) return tl::unexpected(champion.error());
  if (!champion->empty() && !run.champion.emplace().ParseFromString(*champion)) {
    return fail(ErrorCode::kInvalid, path.string() + ": its champion is damaged");
  }
  return run;
}

Status write_results(const RunFolder& run) {
  if (run.champion) {
    if (auto status = write_file(run.path / "champion.pb", deterministic_bytes(*run.champion)); !status)
      return status;
  }
  if (auto status = write_png(figure_of(run.plot()), run.path / "fitness.png"); !status) return status;
  const auto html = report_html(run, run.path / "grasp.png");
  if (!html) return tl::unexpected(html.error());
  return write_file(run.path / "report.html", *html);
}

fs::path fresh_folder(const fs::path& wanted) {
  std::error_code error;
  fs::path folder = wanted;
  for (int i = 2; fs::exists(folder / "run.db", error); ++i)
    folder = wanted.string() + "-" + std::to_string(i);
  return folder;
}

}  // namespace evograsp::cli
