// How a genome grasps, in two numbers: its place on the map of an archive (proto::ArchiveConfig).
#pragma once

#include <array>
#include <span>
#include <string>

#include "common/result.h"
#include "proto/config.pb.h"
#include "proto/wire.pb.h"

namespace evograsp::score {

// What an axis parts evenly, in degrees or m.
struct MeasureRange {
  double low = 0, high = 1;
};
MeasureRange range_of(const proto::ArchiveAxis& axis);
bool is_angle(proto::GraspMeasure measure);         // degrees; else m
std::string words_of(proto::GraspMeasure measure);  // "approach pitch"

// Over the trials that were answered with a pose (Measurement.approach): d the mean of the approach
// directions, s and o where tool point and centre of mass of the target ended, world.
//   PITCH   angle of d below the horizontal, degrees
//   YAW     heading of d about world z, degrees from x
//   HEIGHT  mean of s_z - o_z, m
//   OFFSET  mean of the distance from s to o along the table, m
//   DEPTH   mean of (o - s) . approach, m
// Immutable and thread-safe.
class GraspMap {
 public:
  // kInvalid when an axis has no length.
  static Result<GraspMap> create(const proto::ArchiveConfig& config);
  // x and y, from 0 at the range's low end to 1 at its high one, limited to that; both NaN when no trial was
  // answered or the approaches cancel out.
  std::array<double, 2> place(std::span<const proto::Measurement> trials) const;

 private:
  std::array<proto::GraspMeasure, 2> of_{};
  std::array<MeasureRange, 2> range_{};
};

}  // namespace evograsp::score
