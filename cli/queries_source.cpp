#include "cli/queries_source.h"

#include <cstdlib>

#include "cli/queries.h"

namespace evograsp::cli {

using nlohmann::json;

namespace {
constexpr std::uint64_t kMostGenerations = 10'000'000;
}  // namespace

void add_source_options(CLI::App& command, SourceOptions& options) {
  command
      .add_option("--server", options.server,
                  "address of the server to ask (default: $EVOGRASP_SERVER, else http://127.0.0.1:8080)")
      ->type_name("URL");
  command.add_option("--run", options.run, "read this run folder instead; works with and without a server")
      ->type_name("DIR");
  command.add_flag("--json", options.json, "machine-readable");
}

Result<std::unique_ptr<Source>> Source::open(const SourceOptions& options) {
  if (!options.server.empty() && !options.run.empty())
    return fail(ErrorCode::kUsage, "--server and --run: give one of them");
  if (!options.run.empty()) return open_folder(options.run);
  const char* named = std::getenv("EVOGRASP_SERVER");
  const std::string fallback = named != nullptr && *named != '\0' ? named : "http://127.0.0.1:8080";
  return open_server(options.server.empty() ? fallback : options.server);
}

Result<json> Source::all_generations(std::uint32_t from) {
  json all = json::array();
  for (;;) {
    auto page = generations(from, kPage);
    if (!page) return page;
    json rows = rows_in(*page, "generations");
    const std::uint64_t next = count_in(*page, "next");
    const bool more = part_in(*page, "next").is_number_unsigned();
    for (json& one : rows) all.push_back(std::move(one));
    if (!more) return json{{"generations", std::move(all)}, {"next", nullptr}};
    // A page that leads nowhere would be asked for without end.
    if (next <= from || next > kMostGenerations || rows.empty() || rows.size() > kPage)
      return fail(ErrorCode::kUnavailable, name() + ": its pages of generations do not go on");
    from = static_cast<std::uint32_t>(next);
  }
}

}  // namespace evograsp::cli
