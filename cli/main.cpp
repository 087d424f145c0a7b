#include "cli/program.h"
#include "cli/stop_signals.h"

int main(int argc, char** argv) {
  evograsp::cli::end_at_signals();
  return evograsp::cli::run(argc, argv);
}
