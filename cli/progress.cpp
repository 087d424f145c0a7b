#include "cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "cli/output.h"

namespace evograsp::cli {
namespace {

constexpr std::size_t kRecent = 12;  // generations that rate and time left are taken from
constexpr int kBarWidth = 24, kLeastBar = 4;
constexpr double kSecondsBetweenLines = 2;

std::string bar(double done, int width) {
  static const char* kEighths[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const int eighths = static_cast<int>(std::lround(std::clamp(done, 0.0, 1.0) * width * 8));
  std::string out;
  for (int i = 0; i < eighths / 8; ++i) out += "█";
  out += kEighths[eighths % 8];
  for (int i = (eighths + 7) / 8; i < width; ++i) out += "░";
  return out;
}

}  // namespace

ProgressStyle progress_style(std::FILE* out) {
  const char* terminal = std::getenv("TERM");
  const bool dumb = terminal == nullptr || std::strcmp(terminal, "dumb") == 0;
  return ::isatty(::fileno(out)) != 0 && !dumb ? ProgressStyle::kBar : ProgressStyle::kLines;
}

std::string duration(double seconds) {
  const auto whole = std::llround(std::max(0.0, seconds));
  char text[48];
  if (seconds < 9.95) {
    std::snprintf(text, sizeof text, "%.1f s", std::max(0.0, seconds));
  } else if (whole < 60) {
    std::snprintf(text, sizeof text, "%lld s", whole);
  } else if (whole < 3600) {
    std::snprintf(text, sizeof text, "%lld:%02lld min", whole / 60, whole % 60);
  } else {
    std::snprintf(text, sizeof text, "%lld:%02lld h", whole / 3600, whole / 60 % 60);
  }
  return text;
}

std::string with_commas(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3)
    digits.insert(static_cast<std::size_t>(at), ",");
  return digits;
}

Progress::Progress(ProgressStyle style, std::uint32_t generations, std::FILE* out)
    : style_(style), generations_(generations), out_(out), last_line_(Clock::now()) {}

std::string Progress::line(const server::GenerationReport& report, std::uint32_t generations,
                           double trials_a_second, double seconds_left, int bar_width, bool mean) {
  const std::uint32_t done = report.generation + 1;
  char average[40] = "";
  if (mean) std::snprintf(average, sizeof average, "  mean %.3f", report.mean);
  char text[200];
  std::snprintf(text, sizeof text, "  best %.3f%s  species %u  %s trials/s  %s left", report.best, average,
                report.species, with_commas(static_cast<std::uint64_t>(trials_a_second)).c_str(),
                duration(seconds_left).c_str());
  const std::string count = std::to_string(done) + "/" + std::to_string(generations);
  const std::string shown =
      bar_width > 0 ? " " + bar(static_cast<double>(done) / std::max(1u, generations), bar_width) : "";
  return "generation " + count + shown + text;
}

void Progress::show(const server::GenerationReport& report) {
  if (style_ == ProgressStyle::kSilent) return;
  const auto now = Clock::now();
  recent_.push_back({report.seconds, report.trials, report.generation});
  if (recent_.size() > kRecent) recent_.pop_front();
  const Mark& from = recent_.front();
  const double seconds = report.seconds - from.seconds;
  // The first report knows only the run's own total.
  const bool first = recent_.size() == 1 || seconds <= 0;
  const double span = first ? std::max(report.seconds, 1e-9) : seconds;
  const double trials =
      first ? static_cast<double>(report.trials) : static_cast<double>(report.trials - from.trials);
  const double generations = first ? report.generation + 1.0 : report.generation - from.generation;
  const double left =
      (static_cast<double>(generations_) - report.generation - 1) * span / std::max(1.0, generations);

  const bool bar = style_ == ProgressStyle::kBar;
  const bool last = report.generation + 1 >= generations_;
  if (!bar && !last && report.generation != 0 &&
      std::chrono::duration<double>(now - last_line_).count() < kSecondsBetweenLines)
    return;
  last_line_ = now;
  std::string text = line(report, generations_, trials / span, left, 0);
  if (bar) {
    // A line that wraps could not be drawn over: the bar gives way first, then the mean, then what stands
    // last.
    const int columns = terminal_size(out_).columns - 1;
    if (static_cast<int>(text.size()) > columns)
      text = line(report, generations_, trials / span, left, 0, false);
    const int room = std::min(kBarWidth, columns - 1 - static_cast<int>(text.size()));
    if (room >= kLeastBar) text = line(report, generations_, trials / span, left, room);
    text = cut(text, columns);
  }
  std::fprintf(out_, bar ? "\r\033[K%s" : "%s\n", text.c_str());
  std::fflush(out_);
  open_line_ = bar;
}

void Progress::finish() {
  if (open_line_) std::fputc('\n', out_);
  open_line_ = false;
}

}  // namespace evograsp::cli
