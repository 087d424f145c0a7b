// The same seed gives the same bytes: on every machine, with either compiler, at -O2 and -O3. The digests are
// part of what a version means: a change here changes every run, so it must be meant and be in the changelog.
#include <gtest/gtest.h>

#include <cstring>

#include "common/digest.h"
#include "neat/express.h"
#include "tests/neat/support.h"

namespace evograsp::neat {
namespace {

using testing::lively;

// Judges genomes by what their networks answer, so that the phenotype's bits decide who breeds.
double judge(const Network& network) {
  Network::Scratch scratch;
  std::vector<float> in(static_cast<std::size_t>(network.inputs())),
      out(static_cast<std::size_t>(network.outputs()));
  double fitness = 10;
  for (int k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < in.size(); ++i)
      in[i] = static_cast<float>((i * 37 + static_cast<std::size_t>(k) * 11) % 17) / 17;
    network.activate(in, out, scratch, 2);
    for (std::size_t o = 0; o < out.size(); ++o)
      fitness += static_cast<double>(o % 2 == 0 ? out[o] : -out[o]);
  }
  return fitness;
}

// Digest of the state after `generations`, and of every answer on the way.
std::string digest(const proto::NeatConfig& config, int inputs, int outputs, int generations,
                   bool interrupted = false) {
  auto population = Population::create(config, inputs, outputs, 2026).value();
  Expressor expressor(config);
  std::string answers;
  for (int g = 0; g < generations; ++g) {
    std::vector<double> fitness;
    for (const Genome& genome : population.ask()) fitness.push_back(judge(expressor.express(genome)));
    answers.append(reinterpret_cast<const char*>(fitness.data()), fitness.size() * sizeof(double));
    population.tell(fitness);
    if (interrupted && g % 7 == 3) population = Population::load(config, population.save()).value();
  }
  return sha256_hex(sha256_hex(answers) + population.save()).substr(0, 32);
}

proto::NeatConfig recurrent() {
  proto::NeatConfig config = lively();
  config.set_recurrent(true);
  config.set_topology(proto::SPARSE);
  config.clear_hidden_choice();
  for (int f = 0; f < 8; ++f) config.add_hidden_choice(static_cast<proto::Activation>(f));
  return config;
}

proto::NeatConfig cppn() {
  proto::NeatConfig config = lively(20);
  config.mutable_hyperneat()->set_input_columns(8);
  config.mutable_hyperneat()->set_input_rows(6);
  return config;
}

TEST(Digest, FiftyFeedForwardGenerations) {
  EXPECT_EQ(digest(lively(), 54, 7, 50), "40e179c0b1411e413ae4f4159ec48ff2");
}
TEST(Digest, FiftyRecurrentGenerations) {
  EXPECT_EQ(digest(recurrent(), 9, 3, 50), "45bf781499833ae7407bd608384429ff");
}
TEST(Digest, TenHyperNeatGenerations) {
  EXPECT_EQ(digest(cppn(), 52, 7, 10), "30e94c1415dbc5974e9f52b32ae33873");
}

TEST(Digest, StoppingAndGoingOnChangesNothing) {
  EXPECT_EQ(digest(lively(), 54, 7, 20, true), digest(lively(), 54, 7, 20));
  EXPECT_EQ(digest(recurrent(), 9, 3, 20, true), digest(recurrent(), 9, 3, 20));
  EXPECT_EQ(digest(cppn(), 52, 7, 8, true), digest(cppn(), 52, 7, 8));
}

TEST(Digest, SeedsAndConfigsMatter) {
  proto::NeatConfig other = lively();
  other.set_perturb_power(0.51);
  EXPECT_NE(digest(other, 54, 7, 3), digest(lively(), 54, 7, 3));
  EXPECT_NE(Population::create(lively(), 5, 2, 1).value().save(),
            Population::create(lively(), 5, 2, 2).value().save());
}

}  // namespace
}  // namespace evograsp::neat
