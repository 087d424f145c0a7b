#include "sim/friction.h"

#include "common/random.h"

namespace evograsp::sim {
namespace {

constexpr std::uint64_t kFrictionStream = 1000000;  // apart from other domain randomisation of an object

}  // namespace

Friction::Friction(const proto::SceneConfig& scene, const std::vector<proto::ObjectBundle>& objects,
                   const HandModel& hand)
    : links_(hand.link_count()), jitter_(scene.friction_jitter()) {
  for (const proto::ObjectBundle& object : objects) {
    for (int l = 0; l < links_; ++l) {
      double mu = scene.default_friction();
      for (const proto::FrictionPair& pair : scene.friction()) {
        const bool straight = pair.a() == object.material() && pair.b() == hand.material(l);
        const bool crossed = pair.b() == object.material() && pair.a() == hand.material(l);
        if (straight || crossed) mu = pair.mu();
      }
      mu_.push_back(mu);
    }
  }
}

double Friction::mu(int object, int link, std::uint64_t seed) const {
  const double mu = mu_[static_cast<std::size_t>(object) * static_cast<std::size_t>(links_) +
                        static_cast<std::size_t>(link)];
  if (jitter_ == 0) return mu;
  Random random(seed, Purpose::kDomain, 0, kFrictionStream + static_cast<std::uint64_t>(object));
  return mu * random.uniform(1 - jitter_, 1 + jitter_);
}

}  // namespace evograsp::sim
