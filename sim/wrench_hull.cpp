#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include "sim/quality.h"

namespace evograsp::sim {
namespace {

// One run of qhull. It reports by exit code and by writing to a stream: both are caught here.
class HullRun {
 public:
  HullRun(std::vector<double> points, int count, const char* options) : points_(std::move(points)) {
    std::FILE* errors = open_memstream(&text_, &length_);
    qh_zero(&qh_, errors);
    std::string command = std::string("qhull ") + options;
    code_ = qh_new_qhull(&qh_, 6, count, points_.data(), False, command.data(), nullptr, errors);
    volume_ = code_ == 0 ? qh_.totvol : 0;
    qh_freeqhull(&qh_, !qh_ALL);
    int kept = 0, total = 0;
    qh_memfreeshort(&qh_, &kept, &total);
    if (errors != nullptr) std::fclose(errors);
  }
  ~HullRun() { std::free(text_); }
  HullRun(const HullRun&) = delete;
  HullRun& operator=(const HullRun&) = delete;

  int code() const { return code_; }
  double volume() const { return volume_; }
  std::string first_line() const {
    const std::string all = text_ != nullptr ? std::string(text_, length_) : std::string();
    return all.substr(0, all.find('\n'));
  }

 private:
  std::vector<double> points_;
  char* text_ = nullptr;
  std::size_t length_ = 0;
  qhT qh_{};
  int code_ = 0;
  double volume_ = 0;
};

// Joggling gives a flat set this much volume, in cubes of its size, where there is none.
constexpr double kJoggledFlat = 1e-10;

// Is the set thinner, along some direction, than qhull can turn into a hull? (It says so by this code.)
bool is_flat(const HullRun& run) {
  return run.code() == qh_ERRsingular;
}

Result<double> hull_volume(std::span<const Wrench> wrenches) {
  std::vector<double> points;
  points.reserve(6 * wrenches.size());
  for (const Wrench& w : wrenches) points.insert(points.end(), w.begin(), w.end());
  const int count = static_cast<int>(wrenches.size());
  double largest = 0;
  for (double x : points) largest = std::fmax(largest, std::fabs(x));
  const double scale = largest * largest * largest * largest * largest * largest;
  const HullRun exact(points, count, "Qt FA Pp");
  if (exact.code() == 0) return exact.volume();
  if (is_flat(exact)) return 0.0;
  // Merging wide facets sometimes fails where joggled input (about 1e-11 of its size) does not.
  const HullRun joggled(std::move(points), count, "QJ FA Pp");
  if (joggled.code() == 0) return joggled.volume() > kJoggledFlat * scale ? joggled.volume() : 0.0;
  return fail(ErrorCode::kInternal, "wrench hull: qhull gave up: " + joggled.first_line());
}

}  // namespace

Result<WrenchHull> wrench_hull(std::span<const Wrench> wrenches) {
  for (const Wrench& w : wrenches) {
    for (double x : w) {
      if (!std::isfinite(x)) return fail(ErrorCode::kInvalid, "wrench hull: a wrench is not finite");
    }
  }
  WrenchHull hull;
  Epsilon epsilon;
  hull.epsilon = epsilon(wrenches);
  hull.force_closure = hull.epsilon > 0;
  if (hull.force_closure) hull.weakest = epsilon.weakest();
  if (wrenches.size() < 7) return hull;
  auto volume = hull_volume(wrenches);
  if (!volume) return tl::unexpected(volume.error());
  hull.volume = *volume;
  return hull;
}

}  // namespace evograsp::sim
