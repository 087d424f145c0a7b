// The command line: one file a command family, each adding its subcommands to the program.
#pragma once

#include <CLI/CLI.hpp>

namespace evograsp::cli {

// A command's callback sets the exit code (docs/EXIT-CODES.md) here.
struct Outcome {
  int exit_code = 0;
};

// Looking at single things: sim, epsilon, validate, render, infer.
void add_sim(CLI::App& app, Outcome& outcome);
void add_epsilon(CLI::App& app, Outcome& outcome);
void add_validate(CLI::App& app, Outcome& outcome);
void add_render(CLI::App& app, Outcome& outcome);
void add_infer(CLI::App& app, Outcome& outcome);
// Runs: train, test, experiment.
void add_train(CLI::App& app, Outcome& outcome);
void add_test(CLI::App& app, Outcome& outcome);
void add_experiment(CLI::App& app, Outcome& outcome);
// Asking a server or a run folder: status, watch, workers, generations, species, champion, runs, history,
// pause, resume, stop.
void add_queries(CLI::App& app, Outcome& outcome);
void add_export(CLI::App& app, Outcome& outcome);
// Setting up, and running elsewhere: keygen, slurm.
void add_keygen(CLI::App& app, Outcome& outcome);
void add_slurm(CLI::App& app, Outcome& outcome);
void add_completions(CLI::App& app, Outcome& outcome);

}  // namespace evograsp::cli
