// `evograsp pause`, `resume`, `stop`, `checkpoint` and `log-level`: what a running server is asked to do.
#include <optional>

#include "cli/output.h"
#include "cli/queries.h"

namespace evograsp::cli {
namespace {

struct SteerOptions {
  SourceOptions source;
};

struct Verb {
  const char* name;
  const char* description;
  const char* done;
  const char* footer;
};

constexpr Verb kVerbs[] = {
    {"pause", "let a server finish what is under way and start nothing new", "pausing",
     "Example:\n  evograsp pause --server http://master:8080"},
    {"resume", "let a paused server go on", "going on",
     "A run whose server is gone goes on with: evograsp-server --resume DIR\n\nExample:\n  evograsp resume"},
    {"stop", "commit what there is and end the server; the run can be resumed",
     "stopping; the run can be resumed", "Example:\n  evograsp stop"},
    {"checkpoint", "wait until all finished work is on the server's disk",
     "everything finished is on the disk",
     "Example:\n  evograsp checkpoint && sqlite3 run.db '.backup copy.db'"},
};

int steer(Source& source, const SteerOptions& options, const Verb& verb) {
  if (const Status done = source.steer(verb.name); !done) return report(done.error());
  if (options.source.json) {
    print_json(nlohmann::json{{"accepted", true}});
  } else {
    print(source.name() + ": " + verb.done + "\n");
  }
  return kExitOk;
}

struct LogOptions {
  SourceOptions source;
  std::optional<std::string> level;
};

int log_level(Source& source, const LogOptions& options) {
  const auto answer = source.log_level(options.level);
  if (!answer) return report(answer.error());
  if (options.source.json) {
    print_json(*answer);
  } else {
    print(text_in(*answer, "level") + "\n");
  }
  return kExitOk;
}

struct DrainOptions {
  SourceOptions source;
  std::string node;
};

int drain(Source& source, const DrainOptions& options, bool drained) {
  const auto workers = source.drain(options.node, drained);
  if (!workers) return report(workers.error());
  if (options.source.json) {
    print_json(nlohmann::json{{"accepted", true}, {"workers", *workers}});
  } else {
    print(options.node + ": " + std::to_string(*workers) +
          (*workers == 1 ? " worker gets " : " workers get ") +
          (drained ? "no more work\n" : "work again\n"));
  }
  return kExitOk;
}

void add_log_level(CLI::App& app, Outcome& outcome) {
  const auto options = std::make_shared<LogOptions>();
  CLI::App* sub = app.add_subcommand("log-level", "say or set how much a server logs");
  sub->add_option("level", options->level,
                  "trace, debug, info, warn, error or off; without it: say which it is")
      ->type_name("LEVEL");
  add_source_options(*sub, options->source);
  sub->footer("Examples:\n  evograsp log-level\n  evograsp log-level debug --server http://master:8080");
  answer_with_source(*sub, options, outcome, log_level);
}

void add_drain(CLI::App& workers, Outcome& outcome, const char* name, const char* description, bool drained) {
  const auto options = std::make_shared<DrainOptions>();
  CLI::App* sub = workers.add_subcommand(name, description);
  sub->add_option("node", options->node, "a host, or the identity of one worker")->required();
  add_source_options(*sub, options->source);
  sub->footer(
      "What a drained worker has begun it finishes. Workers of a drained host that join later wait as well. "
      "A restarted\n"
      "server has forgotten it.\n\nExample:\n  evograsp workers " +
      std::string(name) + " node17 --server http://master:8080");
  answer_with_source(*sub, options, outcome, [drained](Source& source, const DrainOptions& given) {
    return drain(source, given, drained);
  });
}

}  // namespace

void add_steering(CLI::App& app, Outcome& outcome) {
  for (const Verb& verb : kVerbs) {
    const auto options = std::make_shared<SteerOptions>();
    CLI::App* sub = app.add_subcommand(verb.name, verb.description);
    add_source_options(*sub, options->source);
    sub->footer(
        std::string(verb.footer) +
        "\n\nA server that asks for a token gets the one in $EVOGRASP_TOKEN_FILE or $EVOGRASP_TOKEN.");
    answer_with_source(*sub, options, outcome, [&verb](Source& source, const SteerOptions& given) {
      return steer(source, given, verb);
    });
  }
  add_log_level(app, outcome);
  CLI::App* workers = app.get_subcommand("workers");
  workers->require_subcommand(0, 1);
  add_drain(*workers, outcome, "drain", "give the workers of a node no more work", true);
  add_drain(*workers, outcome, "undrain", "give the workers of a node work again", false);
}

}  // namespace evograsp::cli
