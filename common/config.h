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

// Where something stands in a file, counted from 1.
struct Position {
  int line = 0, column = 0;
};
// Of each value, by dotted path: "neat.population", "scene.object[1]", "scene.friction[0].mu".
using Positions = std::map<std::string, Position>;

// Parses protobuf text into `message` and checks every annotation of proto/options.proto but `path` (ranges,
// required fields). Returns the diagnostics: all of them at once (at most 30), in the order of the file;
// empty when the file is good. Strict: unknown keys, duplicate keys and numbers that are not finite are
// refused. Bounded: files that
// are no UTF-8 text, files over 1 MiB and nesting over 32 levels are refused. Thread-safe.
std::vector<Diagnostic> parse_text(std::string_view text, const std::string& file_name,
                                   google::protobuf::Message& message, Positions* positions = nullptr);

// A whole file of at most `limit` bytes. Errors: kNotFound (with near misses of the same folder), kIo,
// kInvalid (too large, a folder).
Result<std::string> read_file(const std::filesystem::path& path, std::size_t limit = 1 << 20);

// Where a value came from, for `validate --show`.
enum class Origin { kDefault, kFile, kEnvironment, kFlag };

struct LoadedConfig {
  proto::Config config;                  // every default written out
  std::map<std::string, Origin> origin;  // by dotted path, e.g. "neat.population"
  std::filesystem::path base;            // relative names in the file are relative to this
  std::string file;                      // as diagnostics name it
  Positions positions;                   // of the values that the file gave
};
const char* origin_name(Origin origin);  // "default", "file", "environment", "flag"

// Built-in names that a key accepts beside files, e.g. {"scene.object", assets::builtin_objects()}. A key
// that is not listed accepts any name.
using KnownNames = std::map<std::string, std::vector<std::string>>;

// file: path, or the name of a built-in config (builtin_configs()). Precedence: overrides (flags,
// "neat.population=200"), environment (EVOGRASP_NEAT__POPULATION=200), file, defaults. Lists are given with
// commas ("scene.object=cylinder,cube") and replace the file's. Files named by overrides or the environment
// are relative to the working folder, those named by the file to its folder. run.name defaults to the file's
// name.
//
// Left absent when nobody gives them: what has no default in proto/config.proto (run.stop_at_fitness,
// camera.noise, grasp.home, the constants of fitness, which the preset decides, ...). All diagnostics at
// once.
tl::expected<LoadedConfig, std::vector<Diagnostic>> load_config(
    const std::string& file, const std::vector<std::string>& overrides = {}, const KnownNames& names = {});

// Names of the configs inside the program: the *.txtpb of configs/, without their extension.
std::vector<std::string> builtin_configs();
// Its text; nullopt when there is none of that name.
std::optional<std::string_view> builtin_config(std::string_view name);

// Writes out every default of the message and of the messages in it that are present: fields with [default],
// and message fields with (default_text). Absent messages without default_text stay absent. Idempotent.
void write_defaults(google::protobuf::Message& message);

// Every leaf as (dotted path, value as text), in schema order: defaults included.
std::vector<std::pair<std::string, std::string>> flatten(const google::protobuf::Message& message);

// The diagnostics, one a line.
std::string text(const std::vector<Diagnostic>& diagnostics);

}  // namespace evograsp
