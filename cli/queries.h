// The family of commands that ask a server or a run folder: each file adds some, add_queries() adds all.
#pragma once

#include <memory>

#include "cli/cli.h"
#include "cli/queries_source.h"
#include "cli/report.h"

namespace evograsp::cli {

void add_status(CLI::App& app, Outcome& outcome);  // status, watch
void add_lists(CLI::App& app, Outcome& outcome);   // workers, generations, species, events, history
void add_champion(CLI::App& app, Outcome& outcome);
void add_archive(CLI::App& app, Outcome& outcome);
void add_runs(CLI::App& app, Outcome& outcome);
void add_steering(CLI::App& app, Outcome& outcome);  // pause, resume, stop, checkpoint

// A command whose callback opens the source that its options name and asks `answer`, which gives the exit
// code.
template <class Options, class Answer>
void answer_with_source(CLI::App& command, std::shared_ptr<Options> options, Outcome& outcome,
                        Answer answer) {
  command.callback([options, &outcome, answer, &command] {
    if (!command.get_subcommands().empty()) return;  // one of its own commands was called
    const auto source = Source::open(options->source);
    outcome.exit_code = source ? answer(**source, *options) : report(source.error());
  });
}

// Members of a document that a stranger may have written, which need not even be an object. A member that is
// not there, or of another type, is null, NaN, "", 0, false and an empty array.
const nlohmann::json& part_in(const nlohmann::json& document, const char* key);
double number_in(const nlohmann::json& document, const char* key);
std::string text_in(const nlohmann::json& document, const char* key);  // printable()
std::uint64_t count_in(const nlohmann::json& document, const char* key);
bool flag_in(const nlohmann::json& document, const char* key);
nlohmann::json rows_in(const nlohmann::json& document, const char* key);

}  // namespace evograsp::cli
