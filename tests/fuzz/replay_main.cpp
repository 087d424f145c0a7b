// Runs a fuzz target over files and folders of inputs: the corpus and the regressions as an ordinary test,
// with any compiler. Says which input it is at before a crash, and holds each to the time and all to the
// memory that fuzzing allows.
#include <signal.h>
#include <sys/resource.h>

#include <chrono>
#include <vector>

#include "tests/fuzz/fuzz.h"

namespace {

constexpr unsigned kSeconds = 10;         // an input
constexpr long kMostKilobytes = 2 << 20;  // at the peak

std::string current;  // the input being run

void say_which(int number) {
  const char* what = number == SIGALRM ? "took too long" : "crashed";
  std::fprintf(stderr, "replay: %s %s (signal %d)\n", current.c_str(), what, number);
  signal(number, SIG_DFL);
  raise(number);
}

std::vector<std::filesystem::path> inputs_of(int count, char** arguments) {
  std::vector<std::filesystem::path> files;
  for (int i = 1; i < count; ++i) {
    const std::filesystem::path path = arguments[i];
    if (std::filesystem::is_regular_file(path)) files.push_back(path);
    if (!std::filesystem::is_directory(path)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(path))
      if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

int main(int count, char** arguments) {
  for (const int number : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGALRM}) signal(number, say_which);
  const auto files = inputs_of(count, arguments);
  for (const auto& file : files) {
    current = file.string();
    std::ifstream in(file, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    alarm(kSeconds);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    alarm(0);
  }
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  std::printf("%zu inputs, %ld MB at the peak\n", files.size(), used.ru_maxrss / 1024);
  if (files.empty()) std::fprintf(stderr, "replay: no input given\n");
  if (used.ru_maxrss > kMostKilobytes) std::fprintf(stderr, "replay: more memory than allowed\n");
  return files.empty() || used.ru_maxrss > kMostKilobytes ? 1 : 0;
}
