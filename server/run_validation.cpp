// The end of a run: its finalists on placements that no generation has seen.
#include <algorithm>
#include <utility>

#include "common/digest.h"
#include "common/log.h"
#include "common/network_pack.h"
#include "server/champion.h"
#include "server/run_loop.h"

namespace evograsp::server {

Status RunLoop::validate() {
  const std::vector<BestRecord> finalists = candidates({bests_.begin(), bests_.end()});
  if (finalists.empty()) return fail(ErrorCode::kInternal, "a run without a generation has no champion");
  const TrialPlan plan = plan_validation(config_);
  position_.phase = "validating";
  position_.wanted = static_cast<std::uint32_t>(finalists.size());
  std::vector<Gather::Item> items;
  for (const BestRecord& best : finalists) items.push_back({best.genome, best.generation});
  gather_.begin(Gather::Kind::kValidation, judged_generations_, std::move(items), plan.trials);
  for (std::uint32_t i = 0; i < finalists.size(); ++i) {
    const auto found = std::find_if(validated_.begin(), validated_.end(), [&](const ValidationRecord& v) {
      return v.generation == finalists[i].generation && v.genome == finalists[i].genome &&
             v.trials == plan.trials.size();
    });
    if (found != validated_.end())
      gather_.already(i, {found->fitness, found->trials, found->successes, true, 0, {}});
  }

  const std::vector<std::uint32_t> pending = gather_.pending();
  if (!pending.empty()) {
    dispatcher_.begin(
        {judged_generations_, plan.set, plan.trials, false, static_cast<std::uint32_t>(pending.size()), {}});
    std::vector<NetworkFrame> frames;
    for (const std::uint32_t i : pending) {
      const auto packed = pack_serialised(finalists[i].network);
      if (!packed) return tl::unexpected(packed.error());
      frames.push_back({finalists[i].genome, to_frame(*packed)});
    }
    dispatcher_.add(0, std::move(frames));
  }
  if (Status status = wait_for_work(); !status || stopped_) return status;

  const std::vector<Judgement> judgements = gather_.take();
  std::vector<ValidationRecord> records;
  for (std::size_t i = 0; i < finalists.size(); ++i)
    records.push_back({finalists[i].generation, finalists[i].genome, judgements[i].trials,
                       judgements[i].successes, judgements[i].fitness, 0, 0});
  if (Status status = lift_finalists(finalists, records); !status || stopped_) return status;
  const std::size_t chosen = choose(records);
  return publish_champion(finalists[chosen], records[chosen]);
}

Status RunLoop::publish_champion(const BestRecord& best, const ValidationRecord& validation) {
  auto champion = make_champion(config_, fingerprint_, best, validation);
  if (!champion) return tl::unexpected(champion.error());
  std::optional<Status> kept;
  Mutex mutex;
  store_.keep_champion(*champion, [&](const Status& status) {
    const MutexLock lock(mutex);
    kept = status;
    gather_.wake();
  });
  for (;;) {
    {
      const MutexLock lock(mutex);
      if (kept) break;
    }
    gather_.wait_for_wake(0.1);
  }
  if (!*kept) return *kept;
  spdlog::info("champion: genome {} of generation {}, {} of {} fresh placements grasped", best.genome,
               best.generation, validation.successes, validation.trials);
  position_.champion = std::move(*champion);
  store_.set_state("finished");
  return store_.flush();
}

}  // namespace evograsp::server
