#include "cli/study/progress.h"

#include <algorithm>
#include <cmath>

namespace evograsp::cli::study {

void StudyProgress::begin(std::vector<PlannedWork> work) {
  work_ = std::move(work);
  done_.assign(work_.size(), false);
}

void StudyProgress::start(std::size_t index) {
  current_ = index;
  worked_ = false;
  part_ = 0;
  started_ = Clock::now();
}

void StudyProgress::generation(const server::GenerationReport& report) {
  worked_ = true;
  const PlannedWork& work = work_[current_];
  part_ = (report.generation + 1.0) / std::max(1u, work.generations);
  if (style_ != ProgressStyle::kBar || Clock::now() - shown_ < std::chrono::milliseconds(100)) return;
  char text[100];
  std::snprintf(text, sizeof text, "generation %u/%u  best %.3f", report.generation + 1, work.generations,
                report.best);
  show(text);
}

void StudyProgress::measuring(const std::string& what) {
  worked_ = true;
  if (style_ == ProgressStyle::kBar) show(what);
}

void StudyProgress::done(std::size_t index, const RunFolder& run) {
  done_[index] = true;
  ++count_;
  if (!worked_) return;
  const double seconds = std::chrono::duration<double>(Clock::now() - started_).count();
  for (Spent* spent : {&kinds_[work_[index].kind], &all_}) {
    spent->seconds += seconds;
    spent->trials += work_[index].trials;
    ++spent->runs;
  }
  part_ = 0;
  if (style_ == ProgressStyle::kSilent) return;
  const double best = run.generations.empty() ? 0 : run.generations.back().best;
  char text[160];
  std::snprintf(text, sizeof text, "%s in %s, best %.3f", run.state.c_str(), duration(seconds).c_str(), best);
  show(text);
}

double StudyProgress::seconds_left() const {
  if (all_.runs == 0) return std::nan("");
  double left = 0;
  for (std::size_t i = 0; i < work_.size(); ++i) {
    if (done_[i]) continue;
    const auto like = kinds_.find(work_[i].kind);
    const double whole = like != kinds_.end() && like->second.runs > 0
                             ? like->second.seconds / like->second.runs
                             : all_.seconds / std::max(1.0, all_.trials) * work_[i].trials;
    left += whole * (i == current_ ? 1 - part_ : 1);
  }
  return left;
}

void StudyProgress::show(const std::string& what) {
  shown_ = Clock::now();
  const double left = seconds_left();
  const std::string line =
      "run " + std::to_string(current_ + 1) + "/" + std::to_string(work_.size()) + "  " + work_[current_].id +
      "  " + what + (std::isfinite(left) && count_ < work_.size() ? "  " + duration(left) + " left" : "");
  std::fprintf(out_, style_ == ProgressStyle::kBar ? "\r\033[K%s" : "%s\n", line.c_str());
  std::fflush(out_);
  open_line_ = style_ == ProgressStyle::kBar;
}

void StudyProgress::finish() {
  if (open_line_) std::fputc('\n', out_);
  open_line_ = false;
}

}  // namespace evograsp::cli::study
