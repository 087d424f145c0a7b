// One object alone on the table of a champion's experiment: what champions are tested with.
#pragma once

#include <memory>
#include <string>

#include "assets/experiment.h"
#include "common/result.h"
#include "proto/genome.pb.h"
#include "sim/simulator.h"

namespace evograsp::cli {

// object: a built-in name or a file. scale, mass: of mesh files; 0: as the champion's experiment says.
// at_hand: bundles that are used in the place of files, empty or the object's and the hand's. Warnings of the
// assets are told.
Result<std::shared_ptr<const sim::Simulator>> alone(const proto::Champion& champion,
                                                    const std::string& object, const assets::Bundles& at_hand,
                                                    double scale, double mass);

// The smallest distance between two parallel planes that hold the object, to about a percent (240
// directions), m: what a hand must open to. 0 for an object without parts.
double smallest_width(const proto::ObjectBundle& object);

}  // namespace evograsp::cli
