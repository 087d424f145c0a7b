#include "score/grasp_measure.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/det_math.h"
#include "common/pose.h"

namespace evograsp::score {
namespace {

constexpr double kDegrees = 180 / det::kPi;

struct Means {
  Vec3 approach = Vec3::Zero();
  double height = 0, offset = 0, depth = 0;
  int trials = 0;
};

Means means_of(std::span<const proto::Measurement> trials) {
  Means sum;
  for (const proto::Measurement& m : trials) {
    if (!m.has_approach()) continue;
    const Vec3 d = from_proto(m.approach()), s = from_proto(m.s()), o = from_proto(m.o());
    const Vec3 apart = o - s;
    sum.approach += d;
    sum.height -= apart.z();
    sum.offset += std::sqrt(apart.x() * apart.x() + apart.y() * apart.y());
    sum.depth += apart.dot(d);
    ++sum.trials;
  }
  const double n = std::max(sum.trials, 1);
  sum.height /= n;
  sum.offset /= n;
  sum.depth /= n;
  return sum;
}

double value_of(proto::GraspMeasure measure, const Means& mean) {
  const Vec3& d = mean.approach;
  switch (measure) {
    case proto::PITCH:
      return det::atan2(-d.z(), std::sqrt(d.x() * d.x() + d.y() * d.y())) * kDegrees;
    case proto::YAW:
      return det::atan2(d.y(), d.x()) * kDegrees;
    case proto::HEIGHT:
      return mean.height;
    case proto::OFFSET:
      return mean.offset;
    case proto::DEPTH:
      return mean.depth;
  }
  return 0;
}

}  // namespace

MeasureRange range_of(const proto::ArchiveAxis& axis) {
  MeasureRange range{-0.1, 0.1};  // HEIGHT, DEPTH
  if (axis.of() == proto::PITCH) range = {0, 90};
  if (axis.of() == proto::YAW) range = {-180, 180};
  if (axis.of() == proto::OFFSET) range = {0, 0.1};
  if (axis.has_low()) range.low = axis.low();
  if (axis.has_high()) range.high = axis.high();
  return range;
}

bool is_angle(proto::GraspMeasure measure) {
  return measure == proto::PITCH || measure == proto::YAW;
}

std::string words_of(proto::GraspMeasure measure) {
  switch (measure) {
    case proto::PITCH:
      return "approach pitch";
    case proto::YAW:
      return "approach heading";
    case proto::HEIGHT:
      return "height above the centre of mass";
    case proto::OFFSET:
      return "distance beside the centre of mass";
    case proto::DEPTH:
      return "centre of mass ahead of the tool point";
  }
  return "";
}

Result<GraspMap> GraspMap::create(const proto::ArchiveConfig& config) {
  GraspMap map;
  map.of_ = {config.x().of(), config.y().of()};
  map.range_ = {range_of(config.x()), range_of(config.y())};
  for (const MeasureRange& range : map.range_)
    if (!(range.low < range.high && std::isfinite(range.high - range.low)))
      return fail(ErrorCode::kInvalid, "neat.archive: an axis must have low below high");
  return map;
}

std::array<double, 2> GraspMap::place(std::span<const proto::Measurement> trials) const {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  constexpr double kShortest = 1e-6;  // of a mean direction that still is one
  const Means mean = means_of(trials);
  const Vec3 sum = mean.approach;
  if (mean.trials == 0 || !(sum.dot(sum) > kShortest * kShortest * mean.trials)) return {kUnknown, kUnknown};
  std::array<double, 2> place{};
  for (std::size_t a = 0; a < 2; ++a) {
    const double value = value_of(of_[a], mean);
    if (!std::isfinite(value)) return {kUnknown, kUnknown};
    place[a] = std::clamp((value - range_[a].low) / (range_[a].high - range_[a].low), 0.0, 1.0);
  }
  return place;
}

}  // namespace evograsp::score
