#include "cli/program.h"
#include "cli/stop_signals.h"
#include "common/last_words.h"

int main(int argc, char** argv) {
  evograsp::set_last_words("evograsp");
  evograsp::cli::end_at_signals();
  return evograsp::cli::run(argc, argv);
}
