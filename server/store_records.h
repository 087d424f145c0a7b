// What run.db holds, as values. docs/STORE.md describes the tables.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "neat/population.h"
#include "proto/config.pb.h"
#include "proto/genome.pb.h"
#include "proto/store.pb.h"
#include "proto/wire.pb.h"

namespace evograsp::server {

// A bundle as it is served: id = SHA-256 of the bundle, packed = assets::pack_bundle.
struct StoredAsset {
  std::string id;
  std::string kind;  // "object" or "hand"
  std::string name;
  std::string packed;
};

// What a run is; never changes.
struct RunInfo {
  std::uint64_t run_id = 0;
  std::string name;
  std::string build;      // of the server that made the run
  double created_at = 0;  // Unix time, s
  proto::Config config;   // every default written out
  proto::Experiment experiment;
};

// How far a run is, in words that outlive its process.
struct RunProgress {
  std::uint64_t epoch = 0;  // counts the starts of a server on this run, from 1
  std::string state;        // running, paused, finished, stopped, failed
  double updated_at = 0;    // Unix time, s
};

// One judged generation.
struct GenerationRecord {
  std::uint32_t generation = 0;
  double best = 0, mean = 0, deviation = 0;  // of the fitness of its genomes
  std::uint32_t species = 0;
  double threshold = 0;           // compatibility threshold
  std::uint64_t best_genome = 0;  // genome id
  double links = 0;               // mean enabled links a genome
  std::uint64_t evaluations = 0;  // so far in the run
  std::uint64_t trials = 0;       // so far in the run
  double seconds = 0;             // wall time of the run so far, resumed parts included
  double committed_at = 0;        // Unix time, s; set by the store
};

// The best genome of a generation: a candidate for the champion.
struct BestRecord {
  std::uint32_t generation = 0;
  std::uint64_t genome = 0;
  double fitness = 0;
  std::string genotype;  // serialised proto::Genome
  std::string network;   // serialised proto::Network
};

// One genome's raw measurements, in trial order.
struct Evaluation {
  std::uint32_t generation = 0;
  std::uint64_t genome = 0;
  std::string measurements;  // serialised proto::Measurements: see pack_measurements()
  std::string stage = {};    // empty: the mandatory trials; else which optional ones ("race 1", "lift", ...)
};

// A cell of the map of grasps (neat/archive.h).
struct EliteRecord {
  std::uint32_t cell = 0, x = 0, y = 0;  // bins; cell = x + y * bins of x
  double x_value = 0, y_value = 0;       // mean of what the axes measure, degrees or m
  double fitness = 0;                    // mean
  std::uint32_t judged = 0;              // over so many generations
  std::uint64_t genome = 0;
  std::uint32_t generation = 0;  // that brought it onto the map
  std::uint32_t updated = 0;     // generation that changed the row last
  std::string genotype;          // serialised proto::Genome
  std::string network;           // serialised proto::Network
};

// Everything that a generation leaves behind; committed at once.
struct GenerationCommit {
  GenerationRecord record;
  std::vector<neat::SpeciesSummary> species;
  BestRecord best;
  std::string population;  // neat::Population::save() after tell(): of generation record.generation + 1
  std::vector<EliteRecord> elites = {};     // cells that it changed
  std::vector<std::uint32_t> emptied = {};  // and those that it emptied
};

// A genome that killed or hung workers: scored zero, kept for replay.
struct PoisonRecord {
  std::uint32_t generation = 0;
  std::uint64_t genome = 0;
  std::string reason;
  std::string network;  // serialised proto::Network
  std::string trials;   // serialised proto::TrialKeys
};

struct ValidationRecord {
  std::uint32_t generation = 0;  // that bred the candidate
  std::uint64_t genome = 0;
  std::uint32_t trials = 0, successes = 0;
  double fitness = 0;                        // mean over the validation's trials
  std::uint32_t lift_trials = 0, lifts = 0;  // of the best ones (LiftConfig.finalists): lifted, and held
};

enum class Severity { kInfo = 0, kWarning = 1, kError = 2 };
const char* to_string(Severity severity);

// Something an operator wants to know afterwards.
struct Event {
  std::int64_t id = 0;  // grows; set by the store
  double time = 0;      // Unix time, s; 0: now
  Severity severity = Severity::kInfo;
  std::string kind;  // a fixed word: worker_joined, worker_lost, quarantine, poison, resumed, ...
  std::string text;
};

// A worker as last seen.
struct WorkerRecord {
  std::string identity;
  std::string host;
  std::string build;
  std::string state;  // active, draining, gone, quarantined
  std::uint32_t slots = 0;
  double first_seen = 0, last_seen = 0;  // Unix time, s
  std::uint64_t tasks = 0, trials = 0;   // accepted from it
};

double unix_time();  // now, s

// Appends one genome's measurements in trial order; equal to serialising proto::Measurements.
std::string pack_measurements(std::span<const proto::Measurement> measurements);
Result<std::vector<proto::Measurement>> unpack_measurements(std::string_view packed);

// The champion message of a genome that has (not yet) been validated: what /champion and `evograsp champion`
// give out before the run has chosen. Deterministic.
Result<proto::Champion> make_champion(const proto::Config& config, const std::string& fingerprint,
                                      const BestRecord& best,
                                      const std::optional<ValidationRecord>& validation);

}  // namespace evograsp::server
