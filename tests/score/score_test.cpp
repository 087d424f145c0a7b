// Algorithm 1 of the thesis (4.2.2.1) against values worked out by hand.
#include "score/score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace evograsp::score {
namespace {

proto::FitnessConfig config(const char* terms, proto::FitnessPreset preset) {
  proto::FitnessConfig c;
  c.set_terms(terms);
  c.set_preset(preset);
  return c;
}

proto::Measurement grasp(double quality) {
  proto::Measurement m;
  m.set_outcome(proto::GRASPED);
  m.set_quality(quality);
  m.set_contacts(5);
  m.mutable_p()->set_x(0.1);
  m.mutable_s()->set_x(0.1);
  m.mutable_o()->set_x(0.13);
  m.set_nearest_object(0.03);
  m.set_target_distance(0.03);
  m.set_theta(90);
  return m;
}

TEST(Score, APerfectTrialIsOneInTheNormalisedPreset) {
  const auto scorer = Scorer::create(config("1234", proto::NORMALISED));
  ASSERT_TRUE(scorer);
  const Terms t = scorer->trial(grasp(0.5));
  EXPECT_DOUBLE_EQ(t.f1, 0.6);
  EXPECT_DOUBLE_EQ(t.f2, 0.1);
  EXPECT_DOUBLE_EQ(t.f3, 0.1);
  EXPECT_DOUBLE_EQ(t.f4, 0.2);
  EXPECT_DOUBLE_EQ(t.total, 1.0);
}

TEST(Score, QualityCountsInProportionUpToTheReference) {
  const auto scorer = Scorer::create(config("1", proto::NORMALISED));
  ASSERT_TRUE(scorer);
  EXPECT_DOUBLE_EQ(scorer->trial(grasp(0.1)).total, 0.3);
  EXPECT_DOUBLE_EQ(scorer->trial(grasp(0.2)).total, 0.6);
  EXPECT_DOUBLE_EQ(scorer->trial(grasp(0.4)).total, 0.6);
}

TEST(Score, WithoutClosureApproachIsPaidByDistance) {
  const auto scorer = Scorer::create(config("12", proto::RAW));
  ASSERT_TRUE(scorer);
  const Terms t = scorer->trial(grasp(0));
  EXPECT_EQ(t.f1, 0);
  EXPECT_DOUBLE_EQ(t.f2, 100 / (0.03 + 0.1));
}

TEST(Score, AnotherObjectNearerThanTheTargetForfeitsQuality) {
  const auto scorer = Scorer::create(config("12", proto::RAW));
  ASSERT_TRUE(scorer);
  proto::Measurement m = grasp(0.3);
  EXPECT_DOUBLE_EQ(scorer->trial(m).total, 10000 * 0.3 + 1000);
  m.set_nearest_object(0.01);
  EXPECT_EQ(scorer->trial(m).f1, 0);
}

TEST(Score, AngleTermNeedsTheWindowAndDependsOnDistance) {
  const auto scorer = Scorer::create(config("14", proto::NORMALISED));
  ASSERT_TRUE(scorer);
  proto::Measurement m = grasp(0.1);
  m.set_theta(84.9);
  EXPECT_EQ(scorer->trial(m).f4, 0);
  m.set_theta(95);
  EXPECT_DOUBLE_EQ(scorer->trial(m).f4, 0.2);
  m.set_target_distance(0.08);
  m.set_nearest_object(0.08);
  EXPECT_DOUBLE_EQ(scorer->trial(m).f4, 0.1);
}

TEST(Score, HoveringWithoutContactEarnsNothingUnlessTheLiteralReadingIsAsked) {
  proto::Measurement m = grasp(0);
  m.set_outcome(proto::MISSED);
  m.set_contacts(0);
  proto::FitnessConfig c = config("1234", proto::NORMALISED);
  EXPECT_EQ(Scorer::create(c)->trial(m).f3, 0);
  EXPECT_EQ(Scorer::create(c)->trial(m).f4, 0);
  c.set_contact_gates_f3_f4(false);
  EXPECT_DOUBLE_EQ(Scorer::create(c)->trial(m).f3, 0.1);
  EXPECT_DOUBLE_EQ(Scorer::create(c)->trial(m).f4, 0.2);
}

TEST(Score, EveryCombinationSumsItsOwnTerms) {
  const Terms all = Scorer::create(config("1234", proto::NORMALISED))->trial(grasp(0.1));
  const struct {
    const char* terms;
    double want;
  } cases[] = {{"1", all.f1},
               {"12", all.f1 + all.f2},
               {"13", all.f1 + all.f3},
               {"14", all.f1 + all.f4},
               {"123", all.f1 + all.f2 + all.f3},
               {"124", all.f1 + all.f2 + all.f4},
               {"134", all.f1 + all.f3 + all.f4}};
  for (const auto& c : cases)
    EXPECT_DOUBLE_EQ(Scorer::create(config(c.terms, proto::NORMALISED))->trial(grasp(0.1)).total, c.want)
        << c.terms;
}

TEST(Score, UnknownCombinationIsRefused) {
  EXPECT_FALSE(Scorer::create(config("23", proto::NORMALISED)));
  EXPECT_FALSE(Scorer::create(config("", proto::NORMALISED)));
}

TEST(Score, NotANumberIsAFailedTrialAndNeverABest) {
  const auto scorer = Scorer::create(config("1234", proto::NORMALISED));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  proto::Measurement m = grasp(nan);
  EXPECT_EQ(scorer->trial(m).total, 0);
  m = grasp(0.3);
  m.mutable_p()->set_y(std::numeric_limits<double>::infinity());
  EXPECT_EQ(scorer->trial(m).total, 0);
  m = grasp(0.3);
  m.set_outcome(proto::NOT_A_NUMBER);
  EXPECT_EQ(scorer->trial(m).total, 0);
}

TEST(Score, HoldTakesFromGraspsFarFromTheCentre) {
  proto::FitnessConfig c = config("1234", proto::NORMALISED);
  c.set_hold_weight(0.4);
  c.set_hold_range(0.06);
  const auto scorer = Scorer::create(c);
  ASSERT_TRUE(scorer);
  EXPECT_NEAR(scorer->trial(grasp(0.5)).total, 1 - 0.4 * 0.5, 1e-12);  // 3 of 6 cm
  proto::Measurement centred = grasp(0.5);
  centred.set_target_distance(0);
  EXPECT_NEAR(scorer->trial(centred).total, 1, 1e-12);
  const auto plain = Scorer::create(config("1234", proto::NORMALISED));
  EXPECT_NEAR(scorer->trial(grasp(0)).total, 0.6 * plain->trial(grasp(0)).total, 1e-12);
}

TEST(Score, HeldIsWhatWasLiftedAndStayed) {
  proto::Measurement m = grasp(0.5);
  EXPECT_FALSE(held(m));
  m.set_held(true);
  EXPECT_TRUE(held(m));
}

TEST(Score, EvaluationIsTheMean) {
  const auto scorer = Scorer::create(config("1", proto::NORMALISED));
  const proto::Measurement trials[] = {grasp(0.2), grasp(0)};
  EXPECT_DOUBLE_EQ(scorer->evaluation(trials), 0.3);
  EXPECT_EQ(scorer->evaluation({}), 0);
}

TEST(Score, SuccessIsForceClosure) {
  EXPECT_TRUE(success(grasp(0.01)));
  EXPECT_FALSE(success(grasp(0)));
}

// A worker may send any bits. NaN or infinity in a fitness would spoil means, deviations and run.db.
TEST(Score, IsFiniteWhateverAWorkerSays) {
  using Limits = std::numeric_limits<double>;
  const double specials[] = {Limits::quiet_NaN(),
                             Limits::infinity(),
                             -Limits::infinity(),
                             Limits::max(),
                             -Limits::max(),
                             -1e308,
                             1e300,
                             Limits::denorm_min(),
                             -0.0,
                             0.0,
                             -1.0,
                             1e-300};
  for (const auto preset : {proto::NORMALISED, proto::RAW})
    for (const double hold_weight : {0.0, 0.5}) {
      proto::FitnessConfig fitness = config("1234", preset);
      fitness.set_hold_weight(hold_weight);
      const auto scorer = Scorer::create(fitness);
      ASSERT_TRUE(scorer);
      for (const double x : specials)
        for (int field = 0; field < 13; ++field) {
          proto::Measurement m = grasp(0.5);
          proto::Vec3* vectors[] = {m.mutable_p(), m.mutable_s(), m.mutable_o()};
          if (field == 0) m.set_quality(x);
          if (field == 1) m.set_nearest_object(x);
          if (field == 2) m.set_target_distance(x);
          if (field == 3) m.set_theta(x);
          if (field >= 4) {
            proto::Vec3& v = *vectors[(field - 4) / 3];
            const int axis = (field - 4) % 3;
            axis == 0 ? v.set_x(x) : axis == 1 ? v.set_y(x) : v.set_z(x);
          }
          const double total = scorer->trial(m).total;
          // Squares of a million of them add up.
          EXPECT_LT(std::abs(total), 1e140) << "field " << field << " = " << x;
        }
    }
}

}  // namespace
}  // namespace evograsp::score
