#include "cli/program.h"

#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "cli/bench.h"
#include "cli/help.h"
#include "cli/report.h"
#include "common/last_words.h"
#include "common/near_miss.h"
#include "common/version.h"

namespace evograsp::cli {
namespace {

constexpr int kUsage = static_cast<int>(ErrorCode::kUsage);

constexpr char kFooter[] =
    "First steps:\n"
    "  evograsp train quick --out runs/quick       evolve a controller, watch it learn\n"
    "  evograsp test runs/quick/champion.pb        how often does it grasp what it has not seen?\n"
    "  evograsp validate --show quick              every setting, and where it came from\n"
    "\n"
    "evograsp help COMMAND explains a command and shows examples.";

// Shown in this order; a command that is not listed stands last.
struct Group {
  const char* name;
  std::vector<std::string> commands;
};
const std::vector<Group>& groups() {
  static const std::vector<Group> kGroups = {
      {"Evolve and judge", {"train", "test", "experiment", "validate"}},
      {"Look at a grasp", {"sim", "render", "infer", "epsilon"}},
      {"Ask a running server or a run folder",
       {"status", "watch", "workers", "generations", "species", "champion", "archive", "export", "runs",
        "history", "events"}},
      {"Steer a running server", {"pause", "resume", "stop", "checkpoint", "log-level"}},
      {"Set up", {"slurm", "keygen", "bench", "completions"}},
  };
  return kGroups;
}

void put_in_groups(CLI::App& app) {
  for (const Group& group : groups()) {
    for (CLI::App* sub : app.get_subcommands({})) {
      if (std::ranges::find(group.commands, sub->get_name()) != group.commands.end()) sub->group(group.name);
    }
  }
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* sub : app.get_subcommands({})) names.push_back(sub->get_name());
  return names;
}

// The command that the arguments got to.
const CLI::App& deepest(const CLI::App& app) {
  const auto parsed = app.get_subcommands();
  return parsed.empty() ? app : deepest(*parsed.back());
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : shown_options(app, false)) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// CLI11's complaint in one line, with what was meant and where to read on.
std::string explain(const CLI::App& app, const CLI::Error& error) {
  const CLI::App& at = deepest(app);
  const std::vector<std::string> extras = app.remaining(true);
  const bool top = &at == &app;
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !extras.empty()) {
    const std::string& word = extras.front();
    if (word.starts_with("-")) {
      return "unknown option " + word.substr(0, word.find('=')) +
             did_you_mean(word.substr(0, word.find('=')), option_names(at));
    }
    return top ? "unknown command '" + word + "'" + did_you_mean(word, command_names(app))
               : "unexpected argument '" + word + "'";
  }
  return error.what();
}

int usage_error(const CLI::App& app, const CLI::Error& error) {
  const CLI::App& at = deepest(app);
  const std::string command = &at == &app ? "" : " " + at.get_name();
  std::fprintf(stderr, "evograsp%s: %s\nevograsp help%s shows how it is called.\n", command.c_str(),
               explain(app, error).c_str(), command.c_str());
  return kUsage;
}

int parse_and_run(CLI::App& app, std::vector<std::string> arguments, const Outcome& outcome) {
  try {
    std::ranges::reverse(arguments);  // as CLI11 wants them
    app.parse(std::move(arguments));
  } catch (const CLI::CallForHelp&) {
    std::fputs(deepest(app).help().c_str(), stdout);
    return kExitOk;
  } catch (const CLI::CallForVersion& version) {
    std::puts(version.what());
    return kExitOk;
  } catch (const CLI::ParseError& error) {
    return usage_error(app, error);
  }
  if (app.get_subcommands().empty()) std::fputs(app.help().c_str(), stdout);
  return outcome.exit_code;
}

}  // namespace

std::unique_ptr<CLI::App> make_app(Outcome& outcome) {
  auto app =
      std::make_unique<CLI::App>("evolves robot grasp controllers and puts them to the test", "evograsp");
  app->formatter(std::make_shared<HelpFormatter>());
  app->set_version_flag("--version", std::string("evograsp ") + kVersion, "print the version");
  app->set_help_flag("-h,--help", "show this help");
  app->require_subcommand(0, 1);
  app->footer(kFooter);
  add_train(*app, outcome);
  add_test(*app, outcome);
  add_experiment(*app, outcome);
  add_validate(*app, outcome);
  add_epsilon(*app, outcome);
  add_queries(*app, outcome);
  add_sim(*app, outcome);
  add_render(*app, outcome);
  add_infer(*app, outcome);
  add_export(*app, outcome);
  add_slurm(*app, outcome);
  add_keygen(*app, outcome);
  add_bench(*app, outcome);
  add_completions(*app, outcome);
  put_in_groups(*app);
  return app;
}

int run(int argc, const char* const* argv) {
  try {
    std::vector<std::string> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
    // `evograsp help train` is `evograsp train --help`.
    if (!arguments.empty() && arguments.front() == "help") {
      arguments.erase(arguments.begin());
      arguments.push_back("--help");
    }
    Outcome outcome;
    const auto app = make_app(outcome);
    const int code = parse_and_run(*app, std::move(arguments), outcome);
    // A buffer that could not be written is forgotten: only the stream's mark is left of it.
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      return report({ErrorCode::kIo, "standard output: writing failed"});
    return code;
  } catch (const std::exception& error) {
    return report(error_of_exception(error));
  }
}

}  // namespace evograsp::cli
