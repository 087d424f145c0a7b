// The tree of commands: every command explains itself, and completions know what the tree knows.
#include "cli/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/help.h"

namespace evograsp::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

int exit_code(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "evograsp");
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const int code = run(static_cast<int>(arguments.size()), arguments.data());
  ::testing::internal::GetCapturedStdout();
  ::testing::internal::GetCapturedStderr();
  return code;
}

std::string complaint(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "evograsp");
  ::testing::internal::CaptureStderr();
  const int code = run(static_cast<int>(arguments.size()), arguments.data());
  EXPECT_EQ(code, 2);
  return ::testing::internal::GetCapturedStderr();
}

TEST(Program, EveryCommandAndOptionIsDescribedAndHasAnExample) {
  Outcome outcome;
  const auto app = make_app(outcome);
  for (const CLI::App* command : app->get_subcommands({})) {
    EXPECT_FALSE(command->get_description().empty()) << command->get_name();
    EXPECT_THAT(command->get_footer(), HasSubstr("evograsp " + command->get_name())) << command->get_name();
    EXPECT_NE(command->get_group(), "Subcommands")
        << command->get_name() << " stands in no group of the help";
    for (const bool positional : {false, true}) {
      for (const CLI::Option* option : shown_options(*command, positional)) {
        EXPECT_FALSE(option->get_description().empty()) << command->get_name() << " " << option->get_name();
      }
    }
  }
}

TEST(Program, EveryCommandAnswersHelpBothWays) {
  Outcome outcome;
  const auto app = make_app(outcome);
  for (const CLI::App* command : app->get_subcommands({})) {
    EXPECT_EQ(exit_code({command->get_name().c_str(), "--help"}), 0);
    EXPECT_EQ(exit_code({"help", command->get_name().c_str()}), 0);
  }
  EXPECT_EQ(exit_code({}), 0);
  EXPECT_EQ(exit_code({"--version"}), 0);
}

TEST(Program, UsageMistakesSayWhatWasMeantAndEndWithTwo) {
  EXPECT_THAT(complaint({"valdiate"}), HasSubstr("unknown command 'valdiate': did you mean 'validate'?"));
  EXPECT_THAT(complaint({"validate", "quick", "--jsno"}),
              HasSubstr("unknown option --jsno: did you mean '--json'?"));
  EXPECT_THAT(complaint({"validate"}), HasSubstr("evograsp help validate"));
  EXPECT_THAT(complaint({"completions", "zhs"}), HasSubstr("did you mean 'zsh'?"));
  EXPECT_THAT(complaint({"test", "x.pb", "--placements", "many"}), HasSubstr("--placements"));
  EXPECT_EQ(exit_code({"--nonsense"}), 2);
}

TEST(Program, FilesThatAreNotThereEndWithFourAndRefusedOnesWithOne) {
  EXPECT_EQ(exit_code({"test", "/nonexistent/champion.pb"}), 4);
  EXPECT_EQ(exit_code({"validate", "/nonexistent.txtpb"}), 1);
  EXPECT_EQ(exit_code({"validate", "quick"}), 0);
}

TEST(Completions, KnowEveryCommandAndOption) {
  Outcome outcome;
  const auto app = make_app(outcome);
  for (const char* shell : {"bash", "zsh", "fish"}) {
    ::testing::internal::CaptureStdout();
    const char* arguments[] = {"evograsp", "completions", shell};
    ASSERT_EQ(run(3, arguments), 0);
    const std::string script = ::testing::internal::GetCapturedStdout();
    for (const CLI::App* command : app->get_subcommands({})) {
      EXPECT_THAT(script, HasSubstr(command->get_name())) << shell;
      for (const CLI::Option* option : shown_options(*command, false)) {
        for (const std::string& name : option->get_lnames()) EXPECT_THAT(script, HasSubstr(name)) << shell;
      }
    }
  }
}

TEST(Wrap, BreaksBetweenWordsOnly) {
  EXPECT_THAT(wrap("one two  three four", 9), ElementsAre("one two", "three", "four"));
  EXPECT_THAT(wrap("incomprehensibilities x", 5), ElementsAre("incomprehensibilities", "x"));
  EXPECT_TRUE(wrap("", 5).empty());
}

}  // namespace
}  // namespace evograsp::cli
