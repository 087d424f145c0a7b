// What stands in the place of a server, as the commands that ask one see it: the first byte chooses the
// command, then come answers (status, body), one a question. Whatever they are, the command prints text and
// gives an exit code that docs/EXIT-CODES.md lists, but the one for bugs.
#include <algorithm>
#include <deque>
#include <iterator>

#include "cli/queries.h"
#include "cli/server_answers.h"
#include "tests/fuzz/capture.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace evograsp;

fuzz::Pieces* answers = nullptr;

Result<cli::HttpAnswer> next_answer() {
  constexpr int kStatus[] = {200, 200, 200, 200, 202, 302, 400, 401, 404, 409, 500, 503};
  if (answers->empty()) return fail(ErrorCode::kUnavailable, "http://fuzz: nobody answers any more");
  const std::uint8_t kind = answers->byte();
  return cli::HttpAnswer{kStatus[kind % std::size(kStatus)], std::string(answers->bytes()),
                         kind < 128 ? "chosen" : "best"};
}

const fuzz::Folder& folder() {
  static const fuzz::Folder made;
  return made;
}

// As main() has it, but made once: the tree of all commands takes longer than any answer.
class Command {
 public:
  Command(std::vector<std::string> words, bool prints_text = true)
      : prints_text_(prints_text), words_(std::move(words)) {
    cli::add_queries(app_, outcome_);
    words_.insert(words_.end(), {"--server", "http://fuzz"});
    std::ranges::reverse(words_);  // as CLI11 wants them
  }
  bool prints_text() const { return prints_text_; }
  int run() {
    outcome_.exit_code = -1;
    app_.parse(std::vector<std::string>(words_));
    return outcome_.exit_code;
  }

 private:
  const bool prints_text_;
  std::vector<std::string> words_;
  cli::Outcome outcome_;
  CLI::App app_;
};

std::deque<Command>& commands() {
  using Words = std::vector<std::string>;
  static std::deque<Command> all;
  if (!all.empty()) return all;
  for (const Words& words :
       std::vector<Words>{{"status"},
                          {"status", "--json"},
                          {"watch", "--count", "1"},
                          {"watch", "--count", "1", "--json"},
                          {"workers"},
                          {"generations"},
                          {"generations", "--last", "0", "--json"},
                          {"species", "--generation", "3"},
                          {"events"},
                          {"events", "--json"},
                          {"history"},
                          {"history", "--csv"},
                          {"champion"},
                          {"champion", "--json"},
                          {"champion", "--format", "json"},
                          {"champion", "--cell", "8,3", "--out", (folder().path() / "champion.pb").string()},
                          {"archive"},
                          {"archive", "--best", "0", "--json"},
                          {"archive", "--out", (folder().path() / "map.svg").string()},
                          {"pause"},
                          {"log-level", "debug"},
                          {"log-level", "--json"},
                          {"workers", "drain", "node17"}})
    all.emplace_back(words);
  all.emplace_back(Words{"champion", "--format", "pb"}, false);
  return all;
}

}  // namespace

// In the place of the connection.
Result<std::unique_ptr<cli::Source>> cli::open_server(const std::string& url) {
  return server_source(url,
                       [](const char*, const std::string&, const std::string&) { return next_answer(); });
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Pieces pieces(data, size);
  answers = &pieces;
  Command& command = commands()[pieces.byte() % commands().size()];
  fuzz::Caught out(stdout), err(stderr);
  const int code = command.run();
  const std::string_view printed = out.end(), said = err.end();
  fuzz::require(code == 0 || (code >= 2 && code <= 7), "an exit code says what went wrong, and is no bug");
  fuzz::require(!command.prints_text() || fuzz::is_harmless(printed, true), "answers are text");
  fuzz::require(fuzz::is_harmless(said, true), "complaints are text");
  fuzz::require(code == 0 || !said.empty(), "a failure gives a reason");
  return 0;
}
