// Wrench sets in text, plain or gzip:
//
//     set OBJECT ID [contacts C] wrenches N [epsilon E] [KEY VALUE ...]
//     fx fy fz tx ty tz          (N lines)
//
// Empty lines and lines that begin with # are skipped. Untrusted input: lines, sets and counts are bounded.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/result.h"
#include "sim/quality.h"

namespace evograsp::cli {

inline constexpr int kMaxWrenches = 4096;  // a set

struct WrenchSet {
  std::string object, id;
  int contacts = 0;               // 0: not said
  std::optional<double> epsilon;  // what the file claims
  int line = 0;                   // of its header
  std::vector<sim::Wrench> wrenches;
};

// Reads one set after another. Not thread-safe.
class WrenchReader {
 public:
  // path: a file, or "-" for standard input. kNotFound, kIo.
  static Result<WrenchReader> open(const std::string& path);
  ~WrenchReader();
  WrenchReader(WrenchReader&&) noexcept;

  // Nothing at the end of the file. Errors start with "FILE:LINE: ".
  Result<std::optional<WrenchSet>> next();

 private:
  struct File;
  explicit WrenchReader(std::unique_ptr<File> file);

  std::unique_ptr<File> file_;
};

}  // namespace evograsp::cli
