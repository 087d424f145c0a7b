#include "cli/program.h"

int main(int argc, char** argv) {
  return evograsp::cli::run(argc, argv);
}
