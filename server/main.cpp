#include <cstdio>

int main() {
  std::puts("evograsp-server 0.1.0");
  return 0;
}
