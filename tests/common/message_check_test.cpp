#include "common/message_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "proto/config.pb.h"
#include "proto/wire.pb.h"

namespace evograsp {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string complaint(const google::protobuf::Message& message) {
  const Status status = check_message(message, "run.db");
  return status ? "" : status.error().message;
}

TEST(MessageCheck, WhatAFileMaySayAMessageMaySay) {
  proto::Config config;
  config.mutable_run()->set_seed(std::numeric_limits<std::uint64_t>::max());
  config.mutable_scene()->add_object("cube \"6\"");
  config.mutable_neat()->add_hidden_choice(proto::SINE);
  config.mutable_neat()->set_perturb_power(1e-300);
  config.mutable_camera()->mutable_eye()->set_x(-0.1);
  config.mutable_neat()->mutable_hyperneat();
  EXPECT_EQ(complaint(config), "");
}

TEST(MessageCheck, RangesHoldForBytesToo) {
  proto::Experiment experiment;
  experiment.mutable_camera()->set_columns(4'000'000'000);
  EXPECT_THAT(complaint(experiment), StartsWith("run.db: "));
  EXPECT_THAT(complaint(experiment), HasSubstr("camera.columns"));
  experiment.Clear();
  experiment.mutable_scene()->set_placement_half_x(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(complaint(experiment), HasSubstr("placement_half_x"));
  experiment.Clear();
  experiment.mutable_scene()->add_object("\xff\xfe");
  EXPECT_THAT(complaint(experiment), HasSubstr("UTF-8"));
}

TEST(MessageCheck, NoLargerThanAFile) {
  proto::Experiment experiment;
  experiment.set_hand_id(std::string(2 << 20, 'a'));
  EXPECT_THAT(complaint(experiment), HasSubstr("1 MiB"));
}

}  // namespace
}  // namespace evograsp
