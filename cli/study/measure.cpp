#include "cli/study/measure.h"

#include <nlohmann/json.hpp>

#include "assets/assets.h"
#include "cli/alone.h"
#include "cli/champion_assets.h"
#include "cli/inputs.h"
#include "cli/judge.h"
#include "cli/study/curve.h"
#include "common/config.h"

namespace evograsp::cli::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kLargestCache = 64u << 20;

std::string file_stem(const std::string& object) {
  const bool is_file = object.find('/') != std::string::npos || object.find('.') != std::string::npos;
  return is_file ? fs::path(object).stem().string() : object;
}

// What was measured before, by a key that says all that the answer depends on.
class Cache {
 public:
  explicit Cache(fs::path file, std::string run) : file_(std::move(file)), run_(std::move(run)) {
    const auto text = read_file(file_, kLargestCache);
    if (!text) return;
    json stored = json::parse(*text, nullptr, false);
    if (stored.is_object() && stored.value("run", "") == run_ && stored["known"].is_object())
      known_ = std::move(stored["known"]);
  }
  const json* find(const json& key) const {
    const auto at = known_.find(key.dump());
    return at == known_.end() ? nullptr : &*at;
  }
  Status keep(const json& key, json value) {
    known_[key.dump()] = std::move(value);
    return write_file(file_, json{{"run", run_}, {"known", known_}}.dump(1) + "\n");
  }

 private:
  const fs::path file_;
  const std::string run_;
  json known_ = json::object();
};

json as_json(const TestedObject& t) {
  return {{"object", t.object}, {"n", t.n},           {"successes", t.successes}, {"lifts", t.lifts},
          {"unseen", t.unseen}, {"lifted", t.lifted}, {"extent_m", t.extent_m},   {"refused", t.refused}};
}

TestedObject tested_from(const json& j) {
  return {j.at("object"), j.at("n"),      j.at("successes"), j.at("lifts"),
          j.at("unseen"), j.at("lifted"), j.at("extent_m"),  j.at("refused")};
}

class Measuring {
 public:
  Measuring(const RunFolder& run, const MeasureOptions& options)
      : run_(run),
        options_(options),
        test_(options.study.test()),
        cache_(run.path / "measured.json",
               std::to_string(run.info.run_id) + "/" + std::to_string(run.champion->generation())) {}
  Result<Measured> all();

 private:
  Result<TestedObject> test(const Network& network, const std::string& object, int trained_index);
  Result<TestedObject> test_cached(const Network& network, const std::string& object, int trained_index);
  Result<std::vector<CurvePoint>> curve();
  json test_key(const std::string& object) const;

  const RunFolder& run_;
  const MeasureOptions& options_;
  const proto::StudyTest& test_;
  Cache cache_;
  assets::Bundles trained_;
};

// A file is told apart by its size and time: reading meshes anew for every champion would cost more than the
// answer.
json Measuring::test_key(const std::string& object) const {
  json key{"test", object, test_.placements(), test_.seed(), test_.lift(), options_.scale, options_.mass};
  std::error_code error;
  if (fs::is_regular_file(object, error)) {
    key.push_back(fs::file_size(object, error));
    key.push_back(fs::last_write_time(object, error).time_since_epoch().count());
  }
  return key;
}

// trained_index: of the run's own objects, whose bundles are at hand; -1: a name or a file.
Result<TestedObject> Measuring::test(const Network& network, const std::string& object, int trained_index) {
  TestedObject tested;
  tested.object = file_stem(object);
  assets::Bundles at_hand{{}, trained_.hand};
  const auto index = static_cast<std::size_t>(trained_index);
  if (trained_index >= 0 && index < trained_.objects.size())
    at_hand.objects.push_back(trained_.objects[index]);
  const double scale = trained_index >= 0 ? 0 : options_.scale > 0 ? options_.scale : 1;
  const auto simulator = alone(*run_.champion, object, at_hand, scale, options_.mass);
  if (!simulator) {
    // Somebody's mesh that cannot be used is a finding; a name of the study's own that cannot be is a
    // mistake.
    if (!test_.folder()) return tl::unexpected(simulator.error());
    tested.refused = simulator.error().message;
    return tested;
  }
  tested.extent_m = smallest_width((*simulator)->object(0));
  JudgeOptions how;
  how.placements = static_cast<int>(test_.placements());
  how.seed = test_.seed();
  how.bounding_box = run_.champion->experiment().trials().bounding_box();
  how.lift = test_.lift();
  how.threads = options_.threads;
  how.stop = options_.stop;
  const auto judged = judge(network, **simulator, 0, how);
  if (!judged) {
    if (judged.error().code == ErrorCode::kUnavailable) return tl::unexpected(judged.error());
    if (!test_.folder()) return fail(judged.error().code, object + ": " + judged.error().message);
    tested.refused = judged.error().message;
    return tested;
  }
  tested.n = judged->n;
  tested.successes = judged->successes;
  tested.lifts = judged->lifts;
  tested.unseen = judged->unseen;
  tested.lifted = how.lift;
  return tested;
}

Result<TestedObject> Measuring::test_cached(const Network& network, const std::string& object,
                                            int trained_index) {
  const json key = test_key(object);
  if (const json* known = cache_.find(key)) return tested_from(*known);
  if (options_.stop != nullptr && *options_.stop) return fail(ErrorCode::kUnavailable, "stopped");
  options_.tell("testing on " + file_stem(object));
  auto tested = test(network, object, trained_index);
  if (!tested) return tested;
  if (auto status = cache_.keep(key, as_json(*tested)); !status) return tl::unexpected(status.error());
  return tested;
}

Result<std::vector<CurvePoint>> Measuring::curve() {
  const proto::StudyCurve& how = options_.study.curve();
  const json key{"curve", how.terms(), how.every(), how.placements(), how.seed()};
  if (const json* known = cache_.find(key)) return curve_from_json(*known);
  if (options_.stop != nullptr && *options_.stop) return fail(ErrorCode::kUnavailable, "stopped");
  options_.tell("looking at each generation's best again");
  auto points = measure_curve(run_, trained_, how, options_.threads);
  if (!points) return points;
  if (auto status = cache_.keep(key, curve_to_json(*points)); !status) return tl::unexpected(status.error());
  return points;
}

Result<Measured> Measuring::all() {
  auto network = Network::from_proto(run_.champion->network());
  if (!network) return tl::unexpected(network.error());
  auto bundles = trained_bundles(run_.path, *run_.champion, {});
  if (!bundles) return tl::unexpected(bundles.error());
  trained_ = std::move(*bundles);
  Measured measured;
  if (options_.study.has_test()) {
    const auto& own = run_.champion->experiment().scene().object();
    const bool trained = options_.objects.empty();
    std::vector<std::string> objects = options_.objects;
    if (trained) objects.assign(own.begin(), own.end());
    for (std::size_t i = 0; i < objects.size(); ++i) {
      auto tested = test_cached(*network, objects[i], trained ? static_cast<int>(i) : -1);
      if (!tested) return tl::unexpected(tested.error());
      measured.tests.push_back(std::move(*tested));
    }
  }
  if (options_.study.has_curve()) {
    auto points = curve();
    if (!points) return tl::unexpected(points.error());
    measured.curve = std::move(*points);
  }
  return measured;
}

}  // namespace

Result<Measured> measure(const RunFolder& run, const MeasureOptions& options) {
  if (!run.champion)
    return fail(ErrorCode::kInternal, run.path.string() + ": a finished run without a champion");
  try {
    return Measuring(run, options).all();
  } catch (const json::exception& error) {
    const std::string file = (run.path / "measured.json").string();
    return fail(ErrorCode::kInvalid, file + ": is damaged (" + error.what() + "); remove it and start again");
  }
}

}  // namespace evograsp::cli::study
