// What a study's text cannot say by its schema alone.
#pragma once

#include <string>
#include <vector>

#include "common/config.h"
#include "proto/study.pb.h"

namespace evograsp::cli::study {

// Writes the defaults out, then looks for names that are no column, axis or value, and for files that would
// be written twice. Empty: the study is good.
std::vector<Diagnostic> check(proto::Study& study, const std::string& file, const Positions& positions);

}  // namespace evograsp::cli::study
