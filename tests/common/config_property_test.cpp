// The config reader against protobuf's own text-format parser, and against damaged files.
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <string>

#include "common/config.h"
#include "common/near_miss.h"
#include "common/random.h"
#include "proto/options.pb.h"

namespace evograsp {
namespace {

namespace pb = google::protobuf;

// A config with a random choice of keys, each at a random value that its annotations allow.
void fill(pb::Message& message, Random& random, int depth) {
  const pb::Descriptor& type = *message.GetDescriptor();
  const pb::Reflection& set = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& f = *type.field(i);
    if (random.chance(0.4)) continue;
    const double min = f.options().HasExtension(proto::min) ? f.options().GetExtension(proto::min) : 1;
    const double max =
        f.options().HasExtension(proto::max) ? f.options().GetExtension(proto::max) : min + 1000;
    const double value = min + (max - min) * (1 - random.uniform());  // above min
    const int count = f.is_repeated() ? static_cast<int>(random.below(4)) : 1;
    for (int k = 0; k < count; ++k) {
      const bool add = f.is_repeated();
      switch (f.cpp_type()) {
        case pb::FieldDescriptor::CPPTYPE_UINT32:
          set.SetUInt32(&message, &f, static_cast<std::uint32_t>(value));
          break;
        case pb::FieldDescriptor::CPPTYPE_UINT64:
          set.SetUInt64(&message, &f, random.next());
          break;
        case pb::FieldDescriptor::CPPTYPE_DOUBLE:
          set.SetDouble(&message, &f, value);
          break;
        case pb::FieldDescriptor::CPPTYPE_BOOL:
          set.SetBool(&message, &f, random.chance(0.5));
          break;
        case pb::FieldDescriptor::CPPTYPE_ENUM: {
          const auto* v = f.enum_type()->value(static_cast<int>(random.below(f.enum_type()->value_count())));
          add ? set.AddEnum(&message, &f, v) : set.SetEnum(&message, &f, v);
          break;
        }
        case pb::FieldDescriptor::CPPTYPE_STRING: {
          std::string text;
          for (std::uint32_t n = random.below(12); n > 0; --n)
            text += static_cast<char>(1 + random.below(127));
          add ? set.AddString(&message, &f, text) : set.SetString(&message, &f, text);
          break;
        }
        default:
          if (depth < 4)
            fill(add ? *set.AddMessage(&message, &f) : *set.MutableMessage(&message, &f), random, depth + 1);
      }
    }
  }
}

TEST(ConfigProperty, WhatProtobufPrintsIsReadBackAsTheSame) {
  for (std::uint64_t i = 0; i < 300; ++i) {
    Random random(11, Purpose::kTestHarness, 0, i);
    proto::Config config;
    fill(config, random, 0);
    std::string printed;
    ASSERT_TRUE(pb::TextFormat::PrintToString(config, &printed));
    proto::Config read;
    const auto mistakes = parse_text(printed, "printed", read);
    ASSERT_TRUE(mistakes.empty()) << text(mistakes) << "\n" << printed;
    ASSERT_EQ(read.SerializeAsString(), config.SerializeAsString()) << printed;
  }
}

TEST(ConfigProperty, WritingDefaultsOutIsIdempotentAndKeepsWhatWasGiven) {
  for (std::uint64_t i = 0; i < 100; ++i) {
    Random random(12, Purpose::kTestHarness, 0, i);
    proto::Config given;
    fill(given, random, 0);
    proto::Config once = given;
    write_defaults(once);
    proto::Config twice = once;
    write_defaults(twice);
    ASSERT_EQ(once.SerializeAsString(), twice.SerializeAsString());
    pb::util::MessageDifferencer differencer;
    differencer.set_scope(pb::util::MessageDifferencer::PARTIAL);  // what `given` leaves out may differ
    std::string difference;
    differencer.ReportDifferencesToString(&difference);
    ASSERT_TRUE(differencer.Compare(given, once)) << difference;
  }
}

// Whatever happens to a file, the reader ends, stays bounded, and accepts only what protobuf accepts with the
// same meaning.
TEST(ConfigProperty, DamagedFilesAreRefusedOrMeanTheSameToProtobuf) {
  const std::string whole = R"(# A comment.
run { name: "damaged" seed: 42, generations: 0x20; stop_at_fitness: .95 }
neat: < population: 60 recurrent: true hidden_choice: [SINE, ABS]
  hyperneat { hidden_sheet { columns: 3 rows: 4 } hidden_sheet { columns: 5 } } >
scene { object: 'cube' object: ["a", "b" "c"] clearance: 1e-2 friction: [{ a: "x" mu: .5 }, { b: "y" }] }
camera { eye { x: 1 y: -0.5 } noise { } far: 2f }
)";
  proto::Config undamaged;
  ASSERT_EQ(text(parse_text(whole, "whole", undamaged)), "");
  int accepted = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    Random random(13, Purpose::kTestHarness, 0, i);
    std::string damaged = whole;
    for (std::uint32_t n = 1 + random.below(3); n > 0; --n) {
      const std::size_t at = random.below(static_cast<std::uint32_t>(damaged.size()));
      const std::uint32_t kind = random.below(4);
      const std::size_t length = 1 + random.below(20);
      const char letter = "{}[]<>:,;\"'-1e.x#\n \\"[random.below(20)];
      if (kind == 0) damaged.erase(at, length);
      if (kind == 1) damaged[at] = letter;
      if (kind == 2) damaged.insert(at, 1, letter);
      if (kind == 3) damaged.insert(at, damaged.substr(at, length));
    }
    proto::Config ours, theirs;
    const auto mistakes = parse_text(damaged, "damaged", ours);
    ASSERT_LE(mistakes.size(), 31u);
    if (!mistakes.empty()) continue;
    ++accepted;
    ASSERT_TRUE(pb::TextFormat::ParseFromString(damaged, &theirs)) << damaged;
    ASSERT_EQ(ours.SerializeAsString(), theirs.SerializeAsString()) << damaged;
  }
  EXPECT_GT(accepted, 100) << "the damage is too heavy to test anything";
}

TEST(EditDistance, IsAMetricOnShortWordsAndMatchesHandCounts) {
  EXPECT_EQ(edit_distance("population", "populaton"), 1);
  EXPECT_EQ(edit_distance("neat", "naet"), 1);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("CUBE", "cube"), 0);
  const std::vector<std::string> words = {"completions", "champion", "checkpoint"};
  EXPECT_EQ(near_miss("compl", words), "completions");
  EXPECT_EQ(near_miss("champoin", words), "champion");
  EXPECT_EQ(near_miss("ch", words), std::nullopt);
  Random random(14, Purpose::kTestHarness);
  const auto word = [&random] {
    std::string w;
    for (std::uint32_t n = random.below(7); n > 0; --n) w += static_cast<char>('a' + random.below(3));
    return w;
  };
  for (int i = 0; i < 2000; ++i) {
    const std::string a = word(), b = word();
    ASSERT_EQ(edit_distance(a, b), edit_distance(b, a)) << a << " " << b;
    ASSERT_EQ(edit_distance(a, b) == 0, a == b) << a << " " << b;
    ASSERT_LE(edit_distance(a, b), static_cast<int>(std::max(a.size(), b.size()))) << a << " " << b;
  }
}

}  // namespace
}  // namespace evograsp
