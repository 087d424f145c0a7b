#include <cstdio>

int main() {
  std::puts("evograsp-worker 0.1.0");
  return 0;
}
