// `evograsp pause`, `resume`, `stop` and `checkpoint`: what a running server is asked to do.
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
}

}  // namespace evograsp::cli
