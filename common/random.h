// Counter-based random streams: what a stream gives depends on its key and on nothing else, never on how many
// numbers somebody drew elsewhere. Generator: SplitMix (Steele, Lea, Flood, OOPSLA 2014), 64-bit state and a
// per-stream odd increment, both hashed from the key.
#pragma once

#include <cstdint>

namespace evograsp {

// What a stream is for. Values are part of the run's meaning: never renumber.
enum class Purpose : std::uint32_t {
  kPlacement = 1,  // cmd_shuffle
  kClick = 2,      // cmd_get_info
  kSensorNoise = 3,
  kDomain = 4,      // domain randomisation
  kTrialSeeds = 5,  // the trials of a generation
  kInitialPopulation = 6,
  kReproduction = 7,  // one stream a child
  kSpeciation = 8,
  kValidation = 9,  // placements that choose the champion
  kTest = 10,       // placements that judge it
  kAudit = 11,
  kLifts = 12,          // placements on which a generation's best are lifted
  kArchive = 13,        // one stream a child of elites
  kTestHarness = 1000,  // tests and benchmarks only
};

// Bijective 64-bit finaliser (Stafford's variant 13 of the MurmurHash3 finaliser).
constexpr std::uint64_t mix64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

// One 64-bit key from four; order matters.
constexpr std::uint64_t hash_key(std::uint64_t seed, Purpose purpose, std::uint64_t generation,
                                 std::uint64_t index) {
  std::uint64_t h = mix64(seed + 0x9e3779b97f4a7c15ULL);
  h = mix64(h ^ (static_cast<std::uint64_t>(purpose) * 0xd1342543de82ef95ULL + 1));
  h = mix64(h ^ (generation * 0xaf251af3b0f025b5ULL + 2));
  return mix64(h ^ (index * 0xc2b2ae3d27d4eb4fULL + 3));
}

// A stream of numbers. A value type: copying it forks the stream. Not shared between threads.
// Draws in one expression must not depend on the order in which a compiler evaluates arguments: draw into
// named variables or a braced list first.
class Random {
 public:
  explicit constexpr Random(std::uint64_t key)
      : state_(mix64(key ^ 0x6a09e667f3bcc909ULL)), gamma_(odd_gamma(mix64(key + 0xbb67ae8584caa73bULL))) {}
  constexpr Random(std::uint64_t seed, Purpose purpose, std::uint64_t generation = 0, std::uint64_t index = 0)
      : Random(hash_key(seed, purpose, generation, index)) {}

  constexpr std::uint64_t next() { return mix64(state_ += gamma_); }

  // Uniform in [0, 1), 53 bits.
  constexpr double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  // Uniform in [a, b).
  constexpr double uniform(double a, double b) { return a + (b - a) * uniform(); }
  // Uniform in [0, n), n > 0; unbiased to 2^-32 for n < 2^32 (multiply-shift; Lemire 2019, without
  // rejection).
  constexpr std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>(((next() >> 32) * static_cast<std::uint64_t>(n)) >> 32);
  }
  constexpr bool chance(double p) { return uniform() < p; }

  // The next n numbers of next(), left for the caller to make in any order: number k (from 0) is
  // mix64(state + (k + 1) * gamma). The stream stands behind them.
  struct Counter {
    std::uint64_t state, gamma;
  };
  constexpr Counter take(std::uint64_t n) {
    const Counter counter = {state_, gamma_};
    state_ += n * gamma_;
    return counter;
  }

 private:
  static constexpr std::uint64_t odd_gamma(std::uint64_t z) {
    z |= 1;
    const std::uint64_t flips = z ^ (z >> 1);
    int ones = 0;
    for (std::uint64_t v = flips; v != 0; v &= v - 1) ++ones;
    return ones < 24 ? z ^ 0xaaaaaaaaaaaaaaaaULL : z;  // too regular an increment mixes badly
  }

  std::uint64_t state_;
  std::uint64_t gamma_;
};

}  // namespace evograsp
