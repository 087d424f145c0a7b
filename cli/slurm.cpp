// `evograsp slurm submit`: a run as two jobs of a Slurm cluster, a server and an array of workers. The batch
// scripts are those of deploy/slurm/, carried inside the program.
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "assets/assets.h"
#include "cli/cli.h"
#include "cli/output.h"
#include "cli/report.h"
#include "common/config.h"
#include "common/rendezvous.h"
#include "common/zap.h"
#include "embedded/slurm_scripts.h"
#include "server/store.h"

namespace evograsp::cli {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

struct SubmitOptions {
  std::string config, out, listen = "tcp://*:*", http = "127.0.0.1:0", time, worker_time, account, partition,
                           resume;
  Words overrides, sbatch;
  std::optional<std::uint64_t> seed;
  int workers = 0, slots = 1;
  bool dry_run = false, insecure = false, json = false;
};

fs::path program_folder() {
  std::error_code problem;
  const fs::path self = fs::read_symlink("/proc/self/exe", problem);
  return problem ? fs::path() : self.parent_path();
}

// As a shell reads it back: quoted where it must be.
std::string quoted(const std::string& word) {
  constexpr char kPlain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string line_of(const Words& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + quoted(word);
  return line;
}

// Runs a program found in PATH and gives what it printed; its complaints go where ours go.
Result<std::string> output_of(const Words& words) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return fail(ErrorCode::kIo, std::string("no pipe: ") + std::strerror(errno));
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  close(ends[1]);
  std::string text;
  std::array<char, 512> piece{};
  for (ssize_t size = 0; (size = read(ends[0], piece.data(), piece.size())) > 0;)
    text.append(piece.data(), static_cast<std::size_t>(size));
  close(ends[0]);
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child)
    return fail(ErrorCode::kIo, words[0] + ": cannot be started");
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
    return fail(ErrorCode::kNotFound, words[0] + ": not found; is this a node of a Slurm cluster?");
  if (status != 0) return fail(ErrorCode::kUnavailable, words[0] + " failed: see above");
  return text;
}

// What the two jobs are made of.
class Submission {
 public:
  Submission(const SubmitOptions& options, fs::path run, fs::path bin)
      : options_(options), run_(std::move(run)), bin_(std::move(bin)), scripts_(run_ / "slurm") {}

  Status prepare() const {
    std::error_code problem;
    fs::create_directories(scripts_, problem);
    // Workers start with the server: that a run before this one is over must not send them home.
    const auto before = read_rendezvous(run_ / "rendezvous");
    if (before && !before->over.empty()) fs::remove(run_ / "rendezvous", problem);
    for (const embedded::File& file : embedded::slurm_scripts()) {
      std::ofstream out(scripts_ / file.name, std::ios::binary);
      out << file.data;
      if (!out.flush()) return fail(ErrorCode::kIo, (scripts_ / file.name).string() + ": cannot be written");
    }
    return options_.insecure ? Status() : make_keys();
  }

  Words server() const {
    Words words = sbatch("server", options_.time);
    words.insert(words.end(), {script("server"), run_.string(), bin_.string()});
    if (options_.resume.empty()) words.insert(words.end(), {"--config", config()});
    words.insert(words.end(), {"--listen", options_.listen, "--http", options_.http});
    if (options_.seed) words.insert(words.end(), {"--seed", std::to_string(*options_.seed)});
    for (const std::string& value : options_.overrides) words.insert(words.end(), {"--set", value});
    if (options_.insecure) {
      words.emplace_back("--insecure");
    } else {
      words.insert(words.end(), {"--set", "net.curve_secret_key_file=" + key("server.key"), "--set",
                                 "net.curve_allow_file=" + key("workers.allow")});
    }
    return words;
  }

  Words workers(const std::string& server_job) const {
    Words words = sbatch("worker", options_.worker_time);
    words.insert(words.end(),
                 {"--array=0-" + std::to_string(options_.workers - 1),
                  "--cpus-per-task=" + std::to_string(options_.slots), "--dependency=after:" + server_job,
                  script("workers"), run_.string(), bin_.string(), server_job});
    if (!options_.insecure) words.insert(words.end(), {"--curve-key-file", key("worker.key")});
    return words;
  }

  const fs::path& run() const { return run_; }

 private:
  Words sbatch(const std::string& what, const std::string& time) const {
    Words words{"sbatch", "--parsable", "--job-name=evograsp-" + what, "--chdir=" + run_.string(),
                "--output=" + (scripts_ / (what == "worker" ? "worker-%a.log" : "server.log")).string()};
    if (!time.empty()) words.push_back("--time=" + time);
    if (!options_.account.empty()) words.push_back("--account=" + options_.account);
    if (!options_.partition.empty()) words.push_back("--partition=" + options_.partition);
    words.insert(words.end(), options_.sbatch.begin(), options_.sbatch.end());
    return words;
  }

  // The job runs elsewhere: a file must be named by its whole path, a built-in config by its name.
  std::string config() const {
    std::error_code problem;
    return fs::exists(options_.config, problem) ? fs::absolute(options_.config).string() : options_.config;
  }
  std::string script(const std::string& name) const { return (scripts_ / (name + ".sbatch")).string(); }
  std::string key(const std::string& name) const { return (scripts_ / name).string(); }

  // Nodes are shared with others: only who can read this folder joins the run.
  Status make_keys() const {
    const auto kept = load_keys(key("worker.key"));
    const auto allowed = load_allow_list(key("workers.allow"));
    if (load_keys(key("server.key")) && kept && allowed && allowed->contains(kept->public_key)) return {};
    // What an attempt before this one has left of them, cut short.
    std::error_code ignored;
    for (const char* name : {"server.key", "worker.key", "workers.allow"}) fs::remove(key(name), ignored);
    const auto server = generate_keys(key("server.key"), "");
    if (!server) return tl::unexpected(server.error());
    const auto worker = generate_keys(key("worker.key"), server->public_key);
    if (!worker) return tl::unexpected(worker.error());
    std::ofstream allow(key("workers.allow"));
    allow << worker->public_key << " workers of this run\n";
    if (!allow.flush()) return fail(ErrorCode::kIo, key("workers.allow") + ": cannot be written");
    return {};
  }

  const SubmitOptions& options_;
  const fs::path run_, bin_, scripts_;
};

// Mistakes in a config shall be met here and not in the log of a job that starts tomorrow.
int check(const SubmitOptions& options, fs::path& run) {
  if (options.resume.empty() == options.config.empty())
    return report(Error{ErrorCode::kUsage, "slurm submit: a config, or --resume RUN, is wanted"});
  if (!options.resume.empty()) {
    run = fs::absolute(options.resume);
    if (server::Store::holds_run(run)) return kExitOk;
    return report(Error{ErrorCode::kNotFound, options.resume + ": no run there"});
  }
  const auto loaded =
      load_config(options.config, options.overrides,
                  {{"scene.object", assets::object_names()}, {"grasp.hand", assets::builtin_hands()}});
  if (!loaded) return report(loaded.error());
  run = fs::absolute(options.out.empty() ? "runs/" + loaded->config.run().name() : options.out);
  if (!server::Store::holds_run(run)) return kExitOk;
  return report(Error{ErrorCode::kInvalid,
                      run.string() + ": holds a run already; go on with it: evograsp slurm submit " +
                          "--resume " + run.string()});
}

std::string without_newline(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

int submit(const SubmitOptions& options) {
  fs::path run;
  if (const int code = check(options, run); code != kExitOk) return code;
  const Submission submission(options, run, program_folder());
  if (options.dry_run) {
    print(line_of(submission.server()) + "\n" + line_of(submission.workers("SERVERJOB")) + "\n");
    return kExitOk;
  }
  if (const Status status = submission.prepare(); !status) return report(status.error());
  const auto server = output_of(submission.server());
  if (!server) return report(server.error());
  const std::string server_job = without_newline(*server);
  const auto workers = output_of(submission.workers(server_job));
  if (!workers) {
    say("evograsp: the server's job is " + server_job + "; cancel it with: scancel " + server_job);
    return report(workers.error());
  }
  const std::string workers_job = without_newline(*workers);
  if (options.json) {
    print_json(
        nlohmann::json{{"run", run.string()}, {"server_job", server_job}, {"workers_job", workers_job}});
  } else {
    print("server: job " + server_job + ", workers: job " + workers_job +
          "\nfollow it: srun --overlap --jobid=" + server_job + " evograsp watch --run " +
          quoted(run.string()) + "\n");
  }
  return kExitOk;
}

void add_submit(CLI::App& slurm, Outcome& outcome) {
  const auto options = std::make_shared<SubmitOptions>();
  CLI::App* sub = slurm.add_subcommand("submit", "write the batch scripts of a run and submit them");
  sub->add_option("config", options->config, "config file or the name of a built-in one");
  sub->add_option("--workers", options->workers, "tasks of the worker array")
      ->required()
      ->check(CLI::Range(1, 100000));
  sub->add_option("--slots", options->slots, "simulations at a time of each worker: its --cpus-per-task")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  sub->add_option("--out", options->out, "folder of the run, on a file system that all nodes share");
  sub->add_option("--resume", options->resume, "go on with the run in this folder");
  sub->add_option("--seed", options->seed, "the run's seed (run.seed)");
  sub->add_option("--set", options->overrides, "any value of the config: neat.population=200")->take_all();
  sub->add_option("--time", options->time, "time limit of the server's job, as for sbatch");
  sub->add_option("--worker-time", options->worker_time, "time limit of a worker");
  sub->add_option("--account", options->account, "account to charge");
  sub->add_option("--partition", options->partition, "partition of both jobs");
  sub->add_option("--sbatch", options->sbatch, "one more argument for both sbatch: --sbatch=--qos=low")
      ->take_all();
  sub->add_option("--listen", options->listen, "where the server listens; * as port: a free one")
      ->capture_default_str();
  sub->add_option("--http", options->http, "where its HTTP API answers; port 0: a free one")
      ->capture_default_str();
  sub->add_flag("--insecure", options->insecure, "no keys: whoever reaches the port may join");
  sub->add_flag("--dry-run", options->dry_run, "print the two sbatch commands, write and submit nothing");
  sub->add_flag("--json", options->json, "answer as JSON");
  sub->footer(
      "Examples:\n"
      "  evograsp slurm submit --workers 64 cube --out /scratch/me/cube --time 8:00:00\n"
      "  evograsp slurm submit --workers 8 --slots 16 my.txtpb --partition short --dry-run\n"
      "  evograsp slurm submit --workers 64 --resume /scratch/me/cube");
  sub->callback([options, &outcome] { outcome.exit_code = submit(*options); });
}

}  // namespace

void add_slurm(CLI::App& app, Outcome& outcome) {
  CLI::App* sub = app.add_subcommand("slurm", "run on a Slurm cluster: a server job and an array of workers");
  sub->require_subcommand(1);
  sub->footer(
      "Example:\n  evograsp slurm submit --workers 64 cube --out /scratch/me/cube\ndocs/SLURM.md leads "
      "through it.");
  add_submit(*sub, outcome);
}

}  // namespace evograsp::cli
