#include "cli/study/curve.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "cli/champion_assets.h"
#include "common/network_pack.h"
#include "common/random.h"
#include "common/wire.h"
#include "score/score.h"
#include "server/store_reader.h"
#include "server/trial_plan.h"
#include "worker/evaluator.h"

namespace evograsp::cli::study {
namespace {

using nlohmann::json;

constexpr std::uint64_t kFreshSet = 1;  // any name that is no generation's

// Placement i is that of (seed, Purpose::kTest, 0, i), as `evograsp test` has it; objects take turns.
proto::Task fresh_task(const proto::StudyCurve& how, int objects) {
  proto::Task task;
  task.set_trial_set(kFreshSet);
  for (std::uint32_t i = 0; i < how.placements(); ++i) {
    proto::TrialKey& key = *task.add_trial();
    key.set_seed(hash_key(how.seed(), Purpose::kTest, 0, i));
    key.set_target(i % static_cast<std::uint32_t>(std::max(1, objects)));
    key.set_click(0);
  }
  return task;
}

proto::Task training_task(const proto::Config& config, std::uint32_t generation) {
  const server::TrialPlan plan = server::plan_generation(config, generation);
  proto::Task task;
  task.set_trial_set(plan.set);
  task.mutable_trial()->Assign(plan.trials.begin(), plan.trials.end());
  return task;
}

// One thread's share.
class Replay {
 public:
  Replay(const RunFolder& run, std::shared_ptr<worker::SharedSimulator> shared, const score::Scorer& scorer,
         const proto::StudyCurve& how)
      : run_(run), shared_(std::move(shared)), scorer_(scorer), how_(how), evaluator_(shared_) {}

  Result<CurvePoint> point(const server::BestRecord& best) {
    CurvePoint point;
    point.generation = best.generation;
    if (how_.terms()) {
      if (auto status = add_terms(best, point); !status) return tl::unexpected(status.error());
    }
    const bool last = best.generation + 1 == run_.generations.size();
    if (how_.every() > 0 && (best.generation % how_.every() == 0 || last)) {
      if (auto status = add_fresh(best, point); !status) return tl::unexpected(status.error());
    }
    return point;
  }

 private:
  Result<std::vector<proto::Measurement>> measure(proto::Task task, const server::BestRecord& best) {
    task.add_network(best.genome);
    std::vector<zmq::message_t> networks;
    const auto packed = pack_serialised(best.network);
    if (!packed) return tl::unexpected(packed.error());
    networks.push_back(to_frame(*packed));
    proto::TaskResult result;
    evaluator_.evaluate(task, networks, result);
    if (result.has_error()) return fail(ErrorCode::kInvalid, run_.path.string() + ": " + result.error());
    return std::vector<proto::Measurement>(result.measurement().begin(), result.measurement().end());
  }

  Status add_terms(const server::BestRecord& best, CurvePoint& point) {
    const auto trials = measure(training_task(run_.info.config, best.generation), best);
    if (!trials) return tl::unexpected(trials.error());
    score::Terms sum;
    for (const proto::Measurement& m : *trials) {
      const score::Terms terms = scorer_.trial(m);
      sum.f1 += terms.f1;
      sum.f2 += terms.f2;
      sum.f3 += terms.f3;
      sum.f4 += terms.f4;
    }
    const auto n = static_cast<double>(std::max<std::size_t>(1, trials->size()));
    point.f1 = sum.f1 / n;
    point.f2 = sum.f2 / n;
    point.f3 = sum.f3 / n;
    point.f4 = sum.f4 / n;
    return {};
  }

  Status add_fresh(const server::BestRecord& best, CurvePoint& point) {
    const auto trials = measure(fresh_task(how_, shared_->simulator->object_count()), best);
    if (!trials) return tl::unexpected(trials.error());
    point.fresh_n = static_cast<int>(trials->size());
    point.fresh_successes = static_cast<int>(std::ranges::count_if(*trials, score::success));
    point.fresh_fitness = scorer_.evaluation(*trials);
    return {};
  }

  const RunFolder& run_;
  const std::shared_ptr<worker::SharedSimulator> shared_;
  const score::Scorer& scorer_;
  const proto::StudyCurve& how_;
  worker::Evaluator evaluator_;
};

Result<std::vector<server::BestRecord>> bests_of(const RunFolder& run) {
  auto reader = server::StoreReader::open(run.path);
  if (!reader) return tl::unexpected(reader.error());
  return (*reader)->bests(0, static_cast<std::uint32_t>(run.generations.size()));
}

}  // namespace

Result<std::vector<CurvePoint>> measure_curve(const RunFolder& run, const assets::Bundles& trained,
                                              const proto::StudyCurve& how, int threads) {
  const auto bests = bests_of(run);
  if (!bests) return tl::unexpected(bests.error());
  const auto experiment = resolve_trained(run.info.config, trained, "--objects");
  if (!experiment) return tl::unexpected(experiment.error());
  auto simulator = sim::Simulator::create(experiment->experiment, experiment->objects, experiment->hand);
  if (!simulator) return tl::unexpected(simulator.error());
  const auto scorer = score::Scorer::create(run.info.config.fitness());
  if (!scorer) return tl::unexpected(scorer.error());

  const auto shared = std::make_shared<worker::SharedSimulator>();
  shared->simulator = *simulator;
  std::vector<CurvePoint> points(bests->size());
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  Status status;  // guarded by mutex
  const auto work = [&] {
    Replay replay(run, shared, *scorer, how);
    for (std::size_t i = next++; i < bests->size(); i = next++) {
      auto point = replay.point((*bests)[i]);
      const std::lock_guard lock(mutex);
      if (point) {
        points[i] = *point;
      } else {
        status = tl::unexpected(point.error());
        return;
      }
    }
  };
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<std::thread> pool;
  for (int i = threads > 0 ? threads : cores; i > 0; --i) pool.emplace_back(work);
  for (std::thread& thread : pool) thread.join();
  if (!status) return tl::unexpected(status.error());
  return points;
}

json curve_to_json(const std::vector<CurvePoint>& points) {
  json out = json::array();
  const auto number = [](const std::optional<double>& v) { return v ? json(*v) : json(); };
  for (const CurvePoint& p : points) {
    out.push_back({p.generation, number(p.f1), number(p.f2), number(p.f3), number(p.f4), p.fresh_n,
                   p.fresh_successes, p.fresh_fitness});
  }
  return out;
}

std::vector<CurvePoint> curve_from_json(const json& stored) {
  std::vector<CurvePoint> points;
  const auto number = [](const json& j) {
    return j.is_null() ? std::nullopt : std::optional(j.get<double>());
  };
  for (const json& j : stored) {
    points.push_back({j.at(0), number(j.at(1)), number(j.at(2)), number(j.at(3)), number(j.at(4)), j.at(5),
                      j.at(6), j.at(7)});
  }
  return points;
}

}  // namespace evograsp::cli::study
