// Can the hand grasp this object at all? Searches poses relative to an object, then counts on placements that
// the search has never seen. If no pose succeeds, evolution has nothing to find; docs/REACH.md reports what
// was found.
//
//   evograsp-reach [--out FILE.json] [--placements N] [--scale S] [--upright] OBJECT...
//
// An object is a built-in name, an object file or a mesh file. All numbers come from fixed seeds: running it
// again gives the same table.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "assets/assets.h"
#include "common/det_math.h"
#include "common/random.h"
#include "sim/lift.h"

namespace evograsp {
namespace {

using sim::Placements;

constexpr int kRandomPoses = 3000, kCandidates = 16, kClimb = 150;
constexpr int kSearchPlacements = 24, kLiftPlacements = 2, kScripted = 32;

struct Options {
  std::vector<std::string> objects;
  std::string hand = "meka_h2", out;
  double scale = 1;
  int placements = 100;
  bool upright = false, lift = true;
};

// Where the object's centre of mass is in the tool's frame, and how the tool is turned, in a frame that
// stands upright at the centre of mass: the world's axes, or turned with the object's yaw (its heading).
struct Reach {
  double azimuth = 0, tilt = 0, roll = 0;  // rad: of the approach; tilt 0 is straight down
  Vec3 offset = Vec3::Zero();              // m, of the tool point from the centre of mass

  Mat3 rotation() const {
    return rotation_about(Vec3::UnitZ(), azimuth) * rotation_about(Vec3::UnitY(), det::kPi - tilt) *
           rotation_about(Vec3::UnitZ(), roll);
  }
};

enum class Frame { kWorld, kHeading };

// One object on its table.
class Bench {
 public:
  Bench(std::shared_ptr<const sim::Simulator> simulator, int placements)
      : sim_(std::move(simulator)), workspace_(sim_->make_workspace()) {
    for (int i = 0; i < kSearchPlacements; ++i) search_.push_back(place(Purpose::kValidation, i));
    for (int i = 0; i < placements; ++i) test_.push_back(place(Purpose::kTest, i));
  }

  const std::vector<Placements>& search() const { return search_; }
  const std::vector<Placements>& test() const { return test_; }

  Pose tool(const Placements& p, const Reach& reach, Frame frame) const {
    const Vec3 centre = p.pose[0] * from_proto(sim_->object(0).centre_of_mass());
    const Mat3 turn = frame == Frame::kWorld ? Mat3(Mat3::Identity()) : heading(p);
    return {turn * reach.rotation(), centre + turn * reach.offset};
  }

  double quality(const Placements& p, const Reach& reach, Frame frame, sim::GraspReport* report = nullptr) {
    const auto m = sim_->get_quality(p, 0, tool(p, reach, frame), *workspace_, report);
    return m.outcome == proto::GRASPED ? m.quality : 0;
  }

  bool lifts(const Placements& p, const Reach& reach, Frame frame) {
    sim::GraspReport report;
    if (!(quality(p, reach, frame, &report) > 0)) return false;
    const auto lift = sim::lift_test(*sim_, p, 0, report);
    return lift && lift->held;
  }

 private:
  Placements place(Purpose purpose, int index) const {
    for (std::uint64_t attempt = 0;; ++attempt) {
      auto placed = sim_->shuffle(hash_key(1, purpose, attempt, static_cast<std::uint64_t>(index)));
      if (placed) return *placed;
      if (attempt > 100) throw std::runtime_error(placed.error().message);
    }
  }

  // The turn about z that shuffle drew: the pose without the resting face's own rotation.
  Mat3 heading(const Placements& p) const {
    const auto& resting = sim_->object(0).resting(p.resting[0]);
    return p.pose[0].rotation * from_proto(resting.orientation()).transpose();
  }

  std::shared_ptr<const sim::Simulator> sim_;
  std::unique_ptr<sim::Workspace> workspace_;
  std::vector<Placements> search_, test_;
};

struct Rated {
  Reach reach;
  double worth = 0;  // share of placements that close, and the mean quality to tell equals apart
};

double worth(Bench& bench, const Reach& reach, Frame frame) {
  double closed = 0, sum = 0;
  for (const Placements& p : bench.search()) {
    const double q = bench.quality(p, reach, frame);
    closed += q > 0 ? 1 : 0;
    sum += q;
  }
  return (closed + sum) / kSearchPlacements;
}

Reach random_reach(Random& random) {
  Reach r;
  r.azimuth = random.uniform(-det::kPi, det::kPi);
  r.tilt = random.uniform(0, 1.75);
  r.roll = random.uniform(-det::kPi, det::kPi);
  for (int k = 0; k < 3; ++k) r.offset[k] = random.uniform(-0.045, 0.045);
  return r;
}

Reach near(const Reach& reach, Random& random, double step) {
  Reach r = reach;
  r.azimuth += step * random.uniform(-0.4, 0.4);
  r.tilt += step * random.uniform(-0.3, 0.3);
  r.roll += step * random.uniform(-0.4, 0.4);
  for (int k = 0; k < 3; ++k) r.offset[k] += step * random.uniform(-0.015, 0.015);
  return r;
}

bool better(const Rated& a, const Rated& b) {
  return a.worth > b.worth;
}

// Random poses, each on one placement; the best on all of them; hill climbing from the best. Best first.
std::vector<Rated> find_poses(Bench& bench, Frame frame) {
  Random random(3, Purpose::kValidation, frame == Frame::kWorld ? 1 : 2);
  std::vector<Rated> found;
  for (int i = 0; i < kRandomPoses; ++i) {
    const Reach reach = random_reach(random);
    const double q = bench.quality(bench.search()[i % kSearchPlacements], reach, frame);
    if (q > 0) found.push_back({reach, q});
  }
  std::stable_sort(found.begin(), found.end(), better);
  if (found.size() > 3 * kCandidates) found.resize(3 * kCandidates);
  for (Rated& r : found) r.worth = worth(bench, r.reach, frame);
  std::stable_sort(found.begin(), found.end(), better);
  if (found.size() > kCandidates) found.resize(kCandidates);
  for (std::size_t start = 0; start < std::min<std::size_t>(3, found.size()); ++start) {
    Rated best = found[start];
    for (int i = 0; i < kClimb / 3; ++i) {
      const Reach next = near(best.reach, random, i < kClimb / 6 ? 1 : 0.3);
      const double value = worth(bench, next, frame);
      if (value > best.worth) best = {next, value};
    }
    found.push_back(best);
  }
  std::stable_sort(found.begin(), found.end(), better);
  return found;
}

// Of the poses found the ones that hold what they lift most often.
std::vector<Reach> script(Bench& bench, const std::vector<Rated>& found, Frame frame) {
  std::vector<Rated> held;
  for (const Rated& candidate : found) {
    double lifted = 0;
    for (int i = 0; i < kLiftPlacements; ++i)
      lifted += bench.lifts(bench.search()[static_cast<std::size_t>(i)], candidate.reach, frame) ? 1 : 0;
    if (lifted > 0) held.push_back({candidate.reach, lifted / kLiftPlacements});
  }
  std::stable_sort(held.begin(), held.end(), better);
  std::vector<Reach> out;
  for (const Rated& r : held) {
    if (out.size() < kScripted && 2 * r.worth >= held.front().worth) out.push_back(r.reach);
  }
  return out;
}

struct Verdict {
  int closed = 0;
  int lifted = -1;     // -1: not tried
  double quality = 0;  // mean of all placements
};

// On placements that the search has not seen, the pose of highest quality among the given ones.
Verdict judge(Bench& bench, const std::vector<Reach>& poses, Frame frame, bool lift) {
  Verdict out;
  out.lifted = lift ? 0 : -1;
  for (const Placements& p : bench.test()) {
    const Reach* best = nullptr;
    double most = 0;
    for (const Reach& reach : poses) {
      const double q = bench.quality(p, reach, frame);
      if (q > most) most = q, best = &reach;
    }
    out.quality += most / static_cast<double>(bench.test().size());
    if (best == nullptr) continue;
    ++out.closed;
    out.lifted += lift && bench.lifts(p, *best, frame) ? 1 : 0;
  }
  return out;
}

nlohmann::ordered_json to_json(const Reach& reach) {
  const proto::Quat q = to_proto(reach.rotation());
  return {{"offset", {reach.offset.x(), reach.offset.y(), reach.offset.z()}},
          {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}},
          {"tilt_deg", reach.tilt * 180 / det::kPi}};
}

nlohmann::ordered_json to_json(const Verdict& v, int placements) {
  nlohmann::ordered_json out = {{"of", placements}, {"closed", v.closed}, {"mean_quality", v.quality}};
  if (v.lifted >= 0) out["lifted"] = v.lifted;
  return out;
}

// Only the resting face nearest to how the object was modelled.
void keep_upright(proto::ObjectBundle& object) {
  proto::RestingPose best = object.resting(0);
  for (const proto::RestingPose& face : object.resting()) {
    if (std::fabs(face.orientation().w()) > std::fabs(best.orientation().w())) best = face;
  }
  object.clear_resting();
  *object.add_resting() = best;
}

nlohmann::ordered_json study(const std::string& name, const Options& options) {
  proto::Config config;
  config.mutable_scene()->add_object(name);
  config.mutable_scene()->set_mesh_scale(options.scale);
  config.mutable_grasp()->set_hand(options.hand);
  auto what = assets::resolve_experiment(config, std::filesystem::current_path());
  if (!what) throw std::runtime_error(what.error().message);
  if (options.upright) keep_upright(what->objects[0]);
  auto simulator = sim::Simulator::create(what->experiment, what->objects, what->hand);
  if (!simulator) throw std::runtime_error(simulator.error().message);
  Bench bench(*simulator, options.placements);
  nlohmann::ordered_json out;
  out["object"] = what->objects[0].name();
  const auto row = [&](const char* title, const Verdict& v) {
    const std::string lifted = v.lifted < 0 ? "-" : std::to_string(v.lifted);
    std::printf("%-20s %-24s %6d %5s %4d   %.3f\n", what->objects[0].name().c_str(), title, v.closed,
                lifted.c_str(), options.placements, v.quality);
    std::fflush(stdout);
    return to_json(v, options.placements);
  };
  const auto world = find_poses(bench, Frame::kWorld);
  const auto heading = find_poses(bench, Frame::kHeading);
  const auto first = [](const std::vector<Rated>& found) {
    return found.empty() ? std::vector<Reach>{} : std::vector<Reach>{found.front().reach};
  };
  out["world"] = row("fixed, world's axes", judge(bench, first(world), Frame::kWorld, false));
  out["heading"] = row("fixed, object's heading", judge(bench, first(heading), Frame::kHeading, false));
  if (!world.empty()) out["world"]["pose"] = to_json(world.front().reach);
  if (!heading.empty()) out["heading"]["pose"] = to_json(heading.front().reach);
  if (!options.lift) return out;
  const auto scripted = script(bench, heading, Frame::kHeading);
  const std::string title = "best of " + std::to_string(scripted.size()) + " scripted";
  out["scripted"] = row(title.c_str(), judge(bench, scripted, Frame::kHeading, true));
  for (const Reach& reach : scripted) out["scripted"]["pose"].push_back(to_json(reach));
  return out;
}

}  // namespace
}  // namespace evograsp

int main(int argc, char** argv) {
  evograsp::Options options;
  CLI::App app("Poses that grasp an object, and how often on fresh placements");
  app.add_option("objects", options.objects, "built-in names, object files or mesh files")->required();
  app.add_option("--hand", options.hand, "built-in name or hand file");
  app.add_option("--scale", options.scale, "mesh file units to metres");
  app.add_option("--placements", options.placements, "to count on")->check(CLI::Range(1, 100000));
  app.add_flag("--upright", options.upright, "only the resting face nearest to how the object was modelled");
  app.add_flag("!--no-lift", options.lift,
               "no scripted poses and no lift tests, which take nearly all of the time");
  app.add_option("--out", options.out, "JSON with the figures and the poses");
  CLI11_PARSE(app, argc, argv);
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  std::printf("%-20s %-24s %6s %5s %4s   %s\n", "object", "poses", "closes", "lifts", "of", "mean quality");
  try {
    for (const std::string& name : options.objects) {
      all.push_back(evograsp::study(name, options));
      if (!options.out.empty()) std::ofstream(options.out) << all.dump(1) << "\n";
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "evograsp-reach: %s\n", e.what());
    return 1;
  }
  return 0;
}
