#include "server/api_json.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/digest.h"

namespace evograsp::server {
namespace {

using nlohmann::json;

json number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

std::string hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

json worker_json(const std::string& identity, const std::string& host, const std::string& build,
                 const std::string& state) {
  return {{"identity", identity}, {"host", host}, {"build", build}, {"state", state}};
}

}  // namespace

const char* to_string(RunState state) {
  switch (state) {
    case RunState::kRunning:
      return "running";
    case RunState::kPaused:
      return "paused";
    case RunState::kFinished:
      return "finished";
    case RunState::kStopped:
      return "stopped";
    case RunState::kFailed:
      return "failed";
  }
  return "failed";
}

json run_json(const RunSnapshot& s) {
  std::uint64_t active = 0, slots = 0, busy = 0;
  for (const WorkerView& w : s.workers) {
    if (w.state != "active" && w.state != "draining") continue;
    ++active;
    slots += w.slots;
    busy += w.busy;
  }
  const bool judged = s.committed > 0;
  json j = {{"name", s.name},
            {"run_id", hex(s.run_id)},
            {"seed", s.seed},
            {"build", s.build},
            {"fingerprint", s.fingerprint},
            {"folder", s.run_dir},
            {"epoch", s.epoch},
            {"started_at", number(s.started_at)},
            {"state", to_string(s.state)},
            {"phase", s.phase},
            {"generation", s.generation},
            {"generations", s.generations},
            {"committed", s.committed},
            {"trials", s.trials},
            {"seconds", number(s.seconds)},
            {"trials_per_second", number(s.trials_per_second)},
            {"seconds_left", s.seconds_left >= 0 ? number(s.seconds_left) : json(nullptr)},
            {"evaluations", {{"done", s.evaluations_done}, {"total", s.evaluations_total}}},
            {"workers",
             {{"active", active},
              {"slots", slots},
              {"busy", busy},
              {"slots_wanted", s.slots_wanted > 0 ? json(s.slots_wanted) : json(nullptr)}}},
            {"champion", {{"available", s.champion != nullptr}, {"chosen", s.champion_chosen}}},
            {"error", s.error.empty() ? json(nullptr) : json(s.error)}};
  j["fitness"] = {{"best", judged ? number(s.best) : json(nullptr)},
                  {"mean", judged ? number(s.mean) : json(nullptr)},
                  {"best_ever", judged ? number(s.best_ever) : json(nullptr)}};
  j["species"] = {{"count", s.species.size()}, {"threshold", judged ? number(s.threshold) : json(nullptr)}};
  return j;
}

json workers_json(const RunSnapshot& snapshot) {
  json list = json::array();
  for (const WorkerView& w : snapshot.workers) {
    json one = worker_json(w.identity, w.host, w.build, w.state);
    one.update(
        {{"slots", w.slots},
         {"busy", w.busy},
         {"tasks", w.tasks},
         {"trials", w.trials},
         {"trials_per_second", number(w.trials_per_second)},
         {"silent_seconds", number(w.silent_seconds)},
         {"round_trip_seconds", w.round_trip_seconds > 0 ? number(w.round_trip_seconds) : json(nullptr)},
         {"trial_seconds", w.trial_seconds > 0 ? number(w.trial_seconds) : json(nullptr)}});
    list.push_back(std::move(one));
  }
  return {{"workers", std::move(list)}};
}

json species_json(std::uint32_t generation, const std::vector<neat::SpeciesSummary>& species) {
  json list = json::array();
  for (const neat::SpeciesSummary& s : species)
    list.push_back({{"id", s.id},
                    {"age", s.age},
                    {"last_improved", s.last_improved},
                    {"size", s.size},
                    {"best", number(s.best)},
                    {"mean", number(s.mean)}});
  return {{"generation", generation}, {"species", std::move(list)}};
}

json generations_json(const std::vector<GenerationRecord>& page, bool more) {
  json list = json::array();
  for (const GenerationRecord& g : page)
    list.push_back({{"generation", g.generation},
                    {"best", number(g.best)},
                    {"mean", number(g.mean)},
                    {"deviation", number(g.deviation)},
                    {"species", g.species},
                    {"threshold", number(g.threshold)},
                    {"best_genome", g.best_genome},
                    {"links", number(g.links)},
                    {"evaluations", g.evaluations},
                    {"trials", g.trials},
                    {"seconds", number(g.seconds)},
                    {"committed_at", number(g.committed_at)}});
  const json next = more ? json(page.back().generation + 1) : json(nullptr);
  return {{"generations", std::move(list)}, {"next", next}};
}

json events_json(const std::vector<Event>& events, std::int64_t since) {
  json list = json::array();
  for (const Event& e : events)
    list.push_back({{"id", e.id},
                    {"time", number(e.time)},
                    {"severity", to_string(e.severity)},
                    {"kind", e.kind},
                    {"text", e.text}});
  return {{"events", std::move(list)}, {"last", events.empty() ? since : events.back().id}};
}

Result<std::string> champion_json(const std::string& serialised) {
  proto::Champion champion;
  if (!champion.ParseFromString(serialised))
    return fail(ErrorCode::kInvalid, "champion: the bytes do not parse");
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(champion, &text, options).ok())
    return fail(ErrorCode::kInternal, "champion: cannot be written as JSON");
  return text;
}

Result<json> run_json(const std::filesystem::path& run_dir, StoreReader& reader) {
  const auto info = reader.run();
  if (!info) return tl::unexpected<Error>(info.error());
  const auto progress = reader.progress();
  if (!progress) return tl::unexpected<Error>(progress.error());
  const auto last = reader.last_generation();
  if (!last) return tl::unexpected<Error>(last.error());
  const auto champion = reader.champion();
  if (!champion) return tl::unexpected<Error>(champion.error());
  RunSnapshot s;
  s.name = info->name;
  s.build = info->build;
  s.fingerprint = info->experiment.fingerprint();
  s.run_dir = run_dir.string();
  s.run_id = info->run_id;
  s.seed = info->config.run().seed();
  s.epoch = progress->epoch;
  s.started_at = info->created_at;
  s.generations = info->config.run().generations();
  s.champion_chosen = !champion->empty();
  s.phase = s.champion_chosen ? "done" : "evolving";
  if (last->has_value()) {
    const GenerationRecord& g = **last;
    s.generation = g.generation + 1;
    s.committed = s.generation;
    s.trials = g.trials;
    s.seconds = g.seconds;
    s.trials_per_second = g.seconds > 0 ? static_cast<double>(g.trials) / g.seconds : 0;
    s.best = g.best;
    s.mean = g.mean;
    s.threshold = g.threshold;
    const auto species = reader.species(g.generation);
    if (!species) return tl::unexpected<Error>(species.error());
    s.species = *species;
    const auto best = reader.best();
    if (!best) return tl::unexpected<Error>(best.error());
    s.best_ever = best->has_value() ? (*best)->fitness : g.best;
  }
  json j = run_json(s);
  const bool over =
      progress->state == "finished" || progress->state == "stopped" || progress->state == "failed";
  j["state"] = over || is_live(run_dir) ? progress->state : "interrupted";
  j["champion"]["available"] = s.champion_chosen || s.committed > 0;
  return j;
}

Result<json> workers_json(StoreReader& reader) {
  const auto workers = reader.workers();
  if (!workers) return tl::unexpected<Error>(workers.error());
  json list = json::array();
  for (const WorkerRecord& w : *workers) {
    json one = worker_json(w.identity, w.host, w.build, w.state);
    const double seconds = w.last_seen - w.first_seen;
    one.update(
        {{"slots", w.slots},
         {"busy", 0},
         {"tasks", w.tasks},
         {"trials", w.trials},
         {"trials_per_second", seconds > 0 ? number(static_cast<double>(w.trials) / seconds) : json(0.0)},
         {"silent_seconds", number(std::max(0.0, unix_time() - w.last_seen))},
         {"round_trip_seconds", nullptr},
         {"trial_seconds", nullptr}});
    list.push_back(std::move(one));
  }
  return json{{"workers", std::move(list)}};
}

Result<std::string> champion_of(StoreReader& reader) {
  auto chosen = reader.champion();
  if (!chosen || !chosen->empty()) return chosen;
  const auto info = reader.run();
  if (!info) return tl::unexpected<Error>(info.error());
  const auto best = reader.best();
  if (!best) return tl::unexpected<Error>(best.error());
  if (!best->has_value())
    return fail(ErrorCode::kNotFound, "no champion yet: the first generation has not been judged");
  const auto champion = make_champion(info->config, info->experiment.fingerprint(), **best, std::nullopt);
  if (!champion) return tl::unexpected<Error>(champion.error());
  return deterministic_bytes(*champion);
}

std::string dump(const json& document, int indent) {
  return document.dump(indent, ' ', false, json::error_handler_t::replace);
}

}  // namespace evograsp::server
