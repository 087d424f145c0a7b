// Config files: protobuf text, checked like a compiler checks a program.
#pragma once

#include <google/protobuf/message.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "proto/config.pb.h"

namespace evograsp {

// One thing to say about a file: `file:line:column: message`, the way compilers say it. Lines and columns
// count from 1; 0 when the complaint is about the whole file.
struct Diagnostic {
  std::string file;
  int line = 0, column = 0;
  std::string message;  // what is wrong, what was found, what is allowed, and for a near miss what was meant
  std::string text() const;
};

// Parses protobuf text into `message` and checks every annotation of proto/options.proto (range, required).
// Returns the diagnostics: empty when the file is good. Bounded: files over 1 MiB are refused.
std::vector<Diagnostic> parse_text(std::string_view text, const std::string& file_name,
                                   google::protobuf::Message& message);

// Where a value came from, for `validate --show`.
enum class Origin { kDefault, kFile, kEnvironment, kFlag };

struct LoadedConfig {
  proto::Config config;                  // every default written out
  std::map<std::string, Origin> origin;  // by dotted path, e.g. "neat.population"
  std::filesystem::path base;            // relative names in the file are relative to this
};

// file: path or built-in config name. Precedence: overrides (flags, "neat.population=200"), environment
// (EVOGRASP_NEAT__POPULATION=200), file, defaults. All diagnostics at once.
tl::expected<LoadedConfig, std::vector<Diagnostic>> load_config(
    const std::string& file, const std::vector<std::string>& overrides = {});

// Every leaf as (dotted path, value as text), in schema order: defaults included.
std::vector<std::pair<std::string, std::string>> flatten(const google::protobuf::Message& message);

}  // namespace evograsp
