// The plots that a study asks for, as figures.
#pragma once

#include "cli/chart.h"
#include "cli/study/results.h"

namespace evograsp::cli::study {

// LINES: the median over the seeds, with a band from the lower to the upper quartile. BARS: the median, its
// interval (median_interval; of a single seed's rate the interval of Wilson 1927) and a dot a seed.
Figure figure_of(const proto::Study& study, const proto::StudyPlot& plot, const Data& data);

}  // namespace evograsp::cli::study
