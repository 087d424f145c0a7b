// `evograsp champion`: fetch it, look at it.
#include <charconv>

#include "cli/inputs.h"
#include "cli/output.h"
#include "cli/queries.h"
#include "cli/table.h"
#include "common/digest.h"
#include "server/api_json.h"

namespace evograsp::cli {
namespace {

struct ChampionOptions {
  SourceOptions source;
  std::string out;
  std::string format;
  std::string cell;  // "X,Y" of the map of grasps; empty: the run's champion
};

nlohmann::ordered_json summary(const proto::Champion& champion, const Source::Champion& given) {
  const proto::Network& network = champion.network();
  nlohmann::ordered_json out{{"chosen", given.chosen},
                             {"generation", champion.generation()},
                             {"fitness", champion.fitness()},
                             {"inputs", network.inputs()},
                             {"outputs", network.outputs()},
                             {"nodes", network.activation_size()},
                             {"links", network.weight_size()},
                             {"run_seed", champion.run_seed()},
                             {"fingerprint", champion.fingerprint()},
                             {"sha256", sha256_hex(given.bytes)},
                             {"bytes", given.bytes.size()},
                             {"validation", nullptr}};
  if (champion.validation_trials() > 0)
    out["validation"] = {{"trials", champion.validation_trials()},
                         {"successes", champion.validation_successes()},
                         {"fitness", champion.validation_fitness()}};
  return out;
}

std::string in_words(const Source::Champion& given, const std::string& cell) {
  if (!cell.empty()) return "the elite of cell " + cell + " of the map of grasps, not validated";
  return given.chosen ? "chosen on fresh placements" : "best so far, not validated";
}

// "8,3" to (8, 3).
Result<std::pair<std::uint32_t, std::uint32_t>> parse_cell(const std::string& text) {
  std::uint32_t x = 0, y = 0;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, x);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == ',') {
    const auto second = std::from_chars(first.ptr + 1, end, y);
    if (second.ec == std::errc() && second.ptr == end) return std::pair(x, y);
  }
  return fail(ErrorCode::kUsage, "--cell: '" + text + "' is no cell like 8,3 (evograsp archive lists them)");
}

Result<Source::Champion> fetch(Source& source, const std::string& cell) {
  if (cell.empty()) return source.champion();
  const auto place = parse_cell(cell);
  if (!place) return tl::unexpected(place.error());
  return source.elite(place->first, place->second);
}

std::string summary_text(const proto::Champion& c, const Source::Champion& given, const std::string& cell) {
  const auto line = [](const char* label, const std::string& text) {
    std::string out = label;
    out.resize(12, ' ');
    return out + text + "\n";
  };
  std::string out = line("champion", in_words(given, cell));
  out += line("bred in", "generation " + std::to_string(c.generation()) + ", fitness " + fixed(c.fitness()));
  if (c.validation_trials() > 0)
    out += line("validated", std::to_string(c.validation_successes()) + " of " +
                                 std::to_string(c.validation_trials()) + " grasps succeeded, fitness " +
                                 fixed(c.validation_fitness()));
  const proto::Network& n = c.network();
  out += line("network", std::to_string(n.inputs()) + " inputs, " + std::to_string(n.activation_size()) +
                             " nodes, " + std::to_string(n.weight_size()) + " links, " +
                             std::to_string(n.outputs()) + " outputs");
  out += line("sha256", sha256_hex(given.bytes));
  out += line("next", "evograsp champion --out champion.pb; evograsp test champion.pb");
  return out;
}

// The bytes in the format that was asked for.
Result<std::string> formatted(const ChampionOptions& options, const Source::Champion& champion) {
  const bool json = options.format == "json" || (options.format.empty() && options.out.ends_with(".json"));
  if (!json) return champion.bytes;
  auto text = server::champion_json(champion.bytes);
  if (text) text->push_back('\n');
  return text;
}

int champion(Source& source, const ChampionOptions& options) {
  const auto given = fetch(source, options.cell);
  if (!given) return report(given.error());
  proto::Champion message;
  if (!message.ParseFromString(given->bytes) || !message.has_network())
    return report(Error{ErrorCode::kInvalid, source.name() + ": what it gave is no champion"});
  if (options.out.empty() && options.format.empty()) {
    if (options.source.json) return print_json(summary(message, *given)), kExitOk;
    return print(summary_text(message, *given, options.cell)), kExitOk;
  }
  const auto bytes = formatted(options, *given);
  if (!bytes) return report(bytes.error());
  if (options.out.empty()) {
    if (options.format == "pb" && stdout_is_terminal())
      return report(
          Error{ErrorCode::kUsage, "--format pb: protobuf bytes are not for a terminal; add --out FILE"});
    return print(*bytes), kExitOk;
  }
  if (const Status written = write_file(options.out, *bytes); !written) return report(written.error());
  if (!given->chosen && options.cell.empty())
    warn("the run has not chosen its champion yet: this is the best so far, not validated");
  if (options.source.json) {
    auto document = summary(message, *given);
    document["file"] = options.out;
    print_json(document);
  } else {
    say(options.out + ": " + std::to_string(bytes->size()) + " bytes; try it with: evograsp test " +
        options.out);
  }
  return kExitOk;
}

}  // namespace

void add_champion(CLI::App& app, Outcome& outcome) {
  const auto options = std::make_shared<ChampionOptions>();
  CLI::App* sub = app.add_subcommand("champion", "fetch the champion network, or say what it is");
  add_source_options(*sub, options->source);
  sub->add_option("-o,--out", options->out, "write it to this file")->type_name("FILE");
  sub->add_option("--format", options->format, "pb (protobuf) or json; default: by the file's name, else pb")
      ->type_name("pb|json")
      ->check([](const std::string& given) {
        return given == "pb" || given == "json" ? std::string() : "'" + given + "' is neither pb nor json";
      });
  sub->add_option("--cell", options->cell,
                  "the elite of this cell of the map of grasps (see evograsp archive)")
      ->type_name("X,Y");
  sub->footer(
      "Examples:\n  evograsp champion\n  evograsp champion --out champion.pb\n"
      "  evograsp champion --run runs/quick --format json | jq .generation\n"
      "  evograsp champion --run runs/mug --cell 8,3 --out from_above.pb");
  answer_with_source(*sub, options, outcome, champion);
}

}  // namespace evograsp::cli
