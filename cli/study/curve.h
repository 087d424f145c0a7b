// The best network of each generation, simulated again: what its fitness was made of, and what it is worth on
// placements that nobody was trained on.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "assets/experiment.h"
#include "cli/study/measure.h"

namespace evograsp::cli::study {

// A point a generation. The trials are those of the run itself, by the same path as on a worker, so that the
// fitness is the stored one to the bit. trained: the run's own assets.
Result<std::vector<CurvePoint>> measure_curve(const RunFolder& run, const assets::Bundles& trained,
                                              const proto::StudyCurve& how, int threads);

nlohmann::json curve_to_json(const std::vector<CurvePoint>& points);
std::vector<CurvePoint> curve_from_json(const nlohmann::json& stored);  // throws json::exception

}  // namespace evograsp::cli::study
