// Epsilon by qhull's whole hull: what ours is held against, in tests and benchmarks.
#pragma once

#include <cstdio>
#include <optional>
#include <span>
#include <string>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include "sim/quality.h"

namespace evograsp::sim::testing {

// What GraspIt! passes when it builds a wrench space (its source, gws.cpp), and it asks for the volume, too.
inline constexpr char kGraspitOptions[] = "qhull Pp n Qx C-0.0001 FA";
// Exact facets, triangulated.
inline constexpr char kExactOptions[] = "qhull Pp Qt";

// Distance of the facet nearest the origin, 0 when the origin is outside or the set is flat; nothing when
// qhull fails for another reason.
inline std::optional<double> qhull_epsilon(std::span<const Wrench> wrenches, std::string options) {
  static std::FILE* const nowhere = std::fopen("/dev/null", "w");
  qhT memory;
  qhT* qh = &memory;  // the name that qhull's macros look for
  qh_zero(qh, nowhere);
  std::vector<double> points;
  for (const Wrench& w : wrenches) points.insert(points.end(), w.begin(), w.end());
  const int code = qh_new_qhull(qh, 6, static_cast<int>(wrenches.size()), points.data(), False,
                                options.data(), nullptr, nowhere);
  std::optional<double> nearest;
  if (code == 0) {
    facetT* facet;
    FORALLfacets {
      if (!nearest || -facet->offset < *nearest) nearest = -facet->offset;
    }
    if (nearest && *nearest < 0) nearest = 0;
  }
  if (code == qh_ERRsingular) nearest = 0;
  qh_freeqhull(qh, !qh_ALL);
  int kept = 0, total = 0;
  qh_memfreeshort(qh, &kept, &total);
  return nearest;
}

}  // namespace evograsp::sim::testing
