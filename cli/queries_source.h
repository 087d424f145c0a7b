// Where questions about a run are answered: a server over HTTP, or a run folder read in place. Both give the
// documents of docs/API.md, so that a command need not know which it asked.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/result.h"

namespace evograsp::cli {

// --server URL | --run DIR, shared by every command of the family.
struct SourceOptions {
  std::string server;  // http://host:port
  std::string run;     // folder
  bool json = false;
};
// Adds --server, --run and --json.
void add_source_options(CLI::App& command, SourceOptions& options);

class Source {
 public:
  // Does not connect yet. A folder must hold a run.
  static Result<std::unique_ptr<Source>> open(const SourceOptions& options);
  virtual ~Source() = default;

  virtual Result<nlohmann::json> run() = 0;
  virtual Result<nlohmann::json> workers() = 0;
  virtual Result<nlohmann::json> species(std::optional<std::uint32_t> generation) = 0;
  // One page: "generations" and "next".
  virtual Result<nlohmann::json> generations(std::uint32_t from, std::uint32_t limit) = 0;
  virtual Result<nlohmann::json> events(std::int64_t since, std::uint32_t limit) = 0;
  struct Champion {
    std::string bytes;  // serialised proto::Champion
    bool chosen = false;
  };
  virtual Result<Champion> champion() = 0;
  // The map of grasps, and the elite of a cell.
  virtual Result<nlohmann::json> archive() = 0;
  virtual Result<Champion> elite(std::uint32_t x, std::uint32_t y) = 0;
  // pause, resume, stop or checkpoint.
  virtual Status steer(const std::string& verb) = 0;
  // What the server's log says: its level now, or after setting it.
  virtual Result<nlohmann::json> log_level(const std::optional<std::string>& wanted) = 0;
  // Takes the workers of a host, or one by its identity, out of the run or back in; gives how many are meant.
  virtual Result<std::uint32_t> drain(const std::string& node, bool drained) = 0;
  virtual std::string name() const = 0;

  // Every generation from `from` on, page by page.
  Result<nlohmann::json> all_generations(std::uint32_t from);
};

// What Source::open() opens: a server by its URL, a run by its folder.
Result<std::unique_ptr<Source>> open_server(const std::string& url);
Result<std::unique_ptr<Source>> open_folder(const std::string& folder);

inline constexpr std::uint32_t kPage = 1000;  // rows asked for at once: the most an answer holds

}  // namespace evograsp::cli
