// The experiments of Stanley and Miikkulainen 2002, section 4, run again: evaluations to a solution, failures
// counted. docs/NEAT.md has the table.
//
//   evograsp-literature [--runs N] [--first-seed S] [--task xor|double-pole|double-pole-hidden] [--set
//   KEY=VALUE]...
//
// Runs have the seeds S, S + 1, ... The settings were chosen on seeds below 1000; the table's runs begin at
// the default of 1001. --set changes a field of the task's neat config (protobuf text), for studies.
#include <google/protobuf/text_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/double_pole.h"
#include "neat/local_evaluator.h"
#include "neat/population.h"

namespace {

using evograsp::Network;
using evograsp::bench::DoublePole;
namespace neat = evograsp::neat;
namespace proto = evograsp::proto;

// ---- XOR: fitness (4 - sum of errors)^2; solved when every answer is on the right side of one half.

struct XorAnswer {
  double fitness = 0;
  bool solved = true;
};

XorAnswer ask_xor(const Network& network) {
  Network::Scratch scratch;
  XorAnswer answer;
  double error = 0;
  for (int k = 0; k < 4; ++k) {
    const float in[] = {static_cast<float>(k & 1), static_cast<float>(k >> 1)};
    float out = 0;
    network.activate(in, {&out, 1}, scratch);
    const bool wanted = (k == 1) != (k == 2);
    error += std::fabs((wanted ? 1.0 : 0.0) - static_cast<double>(out));
    answer.solved &= (out >= 0.5f) == wanted;
  }
  answer.fitness = (4 - error) * (4 - error);
  return answer;
}

// ---- Double pole. The network pushes with up to 10 N; its inputs are scaled as usual for this task.

constexpr DoublePole::State kStart = {0, 0, 4 * evograsp::det::kPi / 180, 0, 0, 0};

class Balancer {
 public:
  Balancer(const Network& network, bool velocities) : network_(network), velocities_(velocities) {}

  // Steps of 0.02 s that the poles stay up, at most `limit`. `watch` sees the state after each.
  template <class Watch>
  int balance(const DoublePole::State& start, int limit, Watch watch) {
    constexpr double kScale[] = {1 / 2.4, 1 / 10.0, 1 / 0.628329, 1 / 5.0, 1 / 0.628329, 1 / 16.0};
    DoublePole poles(start);
    Network::State memory;
    for (int step = 0; step < limit; ++step) {
      float in[6], out = 0;
      std::size_t n = 0;
      const DoublePole::State state = poles.state();
      for (std::size_t i = 0; i < 6; i += velocities_ ? 1 : 2)
        in[n++] = static_cast<float>(state[i] * kScale[i]);
      network_.step({in, n}, {&out, 1}, memory);
      poles.push((static_cast<double>(out) - 0.5) * 20);  // the output is a sigmoid's
      if (poles.fallen()) return step;
      watch(poles.state());
    }
    return limit;
  }
  int balance(const DoublePole::State& start, int limit) {
    return balance(start, limit, [](const DoublePole::State&) {});
  }

 private:
  const Network& network_;
  bool velocities_;
};

constexpr int kLong = 100'000, kShort = 1'000;

// Gruau, Whitley and Pyeatt 1996: 0.1 f1 + 0.9 f2, f1 the share of 1,000 steps, f2 = 0.75 / (sum over the
// last 100 steps of |x| + |dx| + |theta1| + |dtheta1|), 0 before step 100: a solution must not oscillate.
double gruau_fitness(const Network& network) {
  std::deque<double> last;
  const int steps = Balancer(network, false).balance(kStart, kShort, [&](const DoublePole::State& s) {
    last.push_back(std::fabs(s[0]) + std::fabs(s[1]) + std::fabs(s[2]) + std::fabs(s[3]));
    if (last.size() > 100) last.pop_front();
  });
  double sum = 0;
  for (const double x : last) sum += x;
  const double f2 = steps < 100 ? 0.0 : 0.75 / std::max(sum, 1e-9);
  return 0.1 * steps / kShort + 0.9 * f2;
}

// The paper's test of a generation's best: 100,000 steps from the start, then 200 of 625 other starts for
// 1,000.
bool generalises(const Network& network) {
  Balancer balancer(network, false);
  if (balancer.balance(kStart, kLong) < kLong) return false;
  constexpr double kPart[] = {0.05, 0.25, 0.5, 0.75, 0.95}, kDegree = evograsp::det::kPi / 180;
  constexpr int kStarts = 625, kEnough = 200;
  int good = 0, bad = 0;
  for (const double a : kPart)
    for (const double b : kPart)
      for (const double c : kPart)
        for (const double d : kPart) {
          const DoublePole::State start = {(2 * a - 1) * 2.16,
                                           (2 * b - 1) * 1.35,
                                           (2 * c - 1) * 3.6 * kDegree,
                                           (2 * d - 1) * 8.6 * kDegree,
                                           0,
                                           0};
          ++(balancer.balance(start, kShort) == kShort ? good : bad);
          if (good >= kEnough) return true;
          if (bad > kStarts - kEnough) return false;
        }
  return false;
}

// ---- Runs

struct Task {
  const char* name;
  int inputs;
  std::uint32_t generations;  // then the run has failed
  const char* config;
  std::function<double(const Network&)> judge;
  std::function<bool(const Network& best, double fitness)> solved;
  const char* paper;
};

struct Outcome {
  bool solved = false;
  std::uint64_t evaluations = 0;
  std::uint32_t generations = 0, hidden = 0;
};

Outcome run(const Task& task, const proto::NeatConfig& config, std::uint64_t seed) {
  auto population = neat::Population::create(config, task.inputs, 1, seed).value();
  Outcome outcome;
  std::uint64_t tested = 0;  // a champion that was kept need not be tested twice
  for (outcome.generations = 1; outcome.generations <= task.generations; ++outcome.generations) {
    const std::vector<double> fitness = neat::evaluate(population.ask(), config, task.judge);
    const auto best =
        static_cast<std::size_t>(std::max_element(fitness.begin(), fitness.end()) - fitness.begin());
    outcome.evaluations += fitness.size();
    const neat::Genome& champion = population.ask()[best];
    if (champion.id() != std::exchange(tested, champion.id()) &&
        task.solved(neat::express(champion, config), fitness[best])) {
      outcome.solved = true;
      outcome.hidden = champion.hidden_nodes();
      break;
    }
    population.tell(fitness);
  }
  return outcome;
}

double mean(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v;
  return x.empty() ? 0 : sum / static_cast<double>(x.size());
}

double deviation(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += (v - mean(x)) * (v - mean(x));
  return x.size() < 2 ? 0 : std::sqrt(sum / static_cast<double>(x.size() - 1));
}

double median(std::vector<double> x) {
  if (x.empty()) return 0;
  std::sort(x.begin(), x.end());
  return x[x.size() / 2];
}

void report(const Task& task, const proto::NeatConfig& config, int runs, std::uint64_t first_seed) {
  std::vector<double> evaluations, generations, hidden;
  for (int r = 0; r < runs; ++r) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(r);
    const Outcome outcome = run(task, config, seed);
    std::fprintf(stderr, "%s seed %llu: %s, %llu evaluations\n", task.name,
                 static_cast<unsigned long long>(seed), outcome.solved ? "solved" : "failed",
                 static_cast<unsigned long long>(outcome.evaluations));
    if (!outcome.solved) continue;
    evaluations.push_back(static_cast<double>(outcome.evaluations));
    generations.push_back(outcome.generations);
    hidden.push_back(outcome.hidden);
  }
  std::printf(
      "%-20s %4d runs, %2d failed in %u generations: evaluations mean %.0f sd %.0f median %.0f, "
      "generations mean %.1f, hidden nodes mean %.2f; paper: %s\n",
      task.name, runs, runs - static_cast<int>(evaluations.size()), task.generations, mean(evaluations),
      deviation(evaluations), median(evaluations), mean(generations), mean(hidden), task.paper);
  std::fflush(stdout);
}

// Common to the tasks: the paper's section 4.1, beyond the defaults.
constexpr char kPaper[] =
    "topology: DIRECT connect_bias_to_outputs: true hidden_activation: STEEP_SIGMOID output_activation: "
    "STEEP_SIGMOID "
    "c1_excess: 1 c2_disjoint: 1 drop_off_age: 15 max_weight: 30 ";

std::vector<Task> tasks() {
  return {
      {"xor", 2, 100,
       "population: 150 target_species: 12 c3_weight: 0.4 add_node: 0.05 add_connection: 0.3 perturb_power: "
       "2.5",
       [](const Network& n) { return ask_xor(n).fitness; },
       [](const Network& n, double) { return ask_xor(n).solved; },
       "4755 evaluations, 32 generations, 2.35 hidden nodes, none failed"},
      {"double-pole", 6, 200,
       "population: 80 target_species: 6 c3_weight: 0.4 add_node: 0.03 add_connection: 0.05 perturb_power: "
       "2.5 "
       "elite_min_size: 1",
       [](const Network& n) { return static_cast<double>(Balancer(n, true).balance(kStart, kLong)) / kLong; },
       [](const Network&, double f) { return f >= 1; }, "3600 evaluations, 24 generations, none failed"},
      {"double-pole-hidden", 3, 1000,
       "population: 100 target_species: 5 c3_weight: 3 normalise_by_genes: false max_weight: 8 recurrent: "
       "true "
       "add_node: 0.003 add_connection: 0.05 perturb_weight: 1 perturb_power: 1 elite_min_size: 0",
       gruau_fitness, [](const Network& n, double) { return generalises(n); },
       "33184 evaluations, 24 generations, none failed"},
  };
}

}  // namespace

int main(int argc, char** argv) {
  int runs = 100;
  std::uint64_t first_seed = 1001;
  std::string only, settings;
  std::vector<std::string> changes;
  CLI::App app("The NEAT paper's experiments: evaluations to a solution, failures counted");
  app.add_option("--runs", runs, "of each task")->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_option("--first-seed", first_seed, "of the first run; the next has the next")
      ->capture_default_str();
  app.add_option("--task", only)->check(CLI::IsMember({"xor", "double-pole", "double-pole-hidden"}));
  app.add_option("--set", changes, "KEY=VALUE of the task's neat config");
  CLI11_PARSE(app, argc, argv);
  for (const std::string& change : changes) settings += " " + change;
  std::replace(settings.begin(), settings.end(), '=', ':');
  for (const Task& task : tasks()) {
    if (!only.empty() && only != task.name) continue;
    proto::NeatConfig config, changed;
    proto::NeatConfig own;
    if (!google::protobuf::TextFormat::ParseFromString(kPaper, &config) ||
        !google::protobuf::TextFormat::ParseFromString(task.config, &own) ||
        !google::protobuf::TextFormat::ParseFromString(settings, &changed)) {
      std::fprintf(stderr, "evograsp-literature: that is no neat config\n");
      return 2;
    }
    config.MergeFrom(own);
    config.MergeFrom(changed);
    report(task, config, runs, first_seed);
  }
}
