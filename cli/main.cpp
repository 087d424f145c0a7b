#include <cstdio>

int main() {
  std::puts("evograsp 0.1.0");
  return 0;
}
