// The name of a worker that is given none: HOST-PLACE-NUMBER, e.g. "lab3-5f2c81aa-1".
//
// A worker that is started again goes by the name it had, so that a master which has sent a liar away knows
// it when it comes back; no two that run at a time share one. NUMBER is the lowest that no running worker of
// this place holds. PLACE stands for the machine since its start (boot id and network namespace: host names
// alone are not unique) and for the master's address as the worker was given it. Where the system does not
// tell, the name has a random part.
#pragma once

#include <string>

namespace evograsp::worker {

// What this machine calls itself.
std::string host_name();

// Holds the number until it ends, or its process does, however.
class Seat {
 public:
  Seat() = default;
  ~Seat();
  Seat(Seat&& other) noexcept;
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;
  Seat& operator=(Seat&&) = delete;

  // master: its address, or the file that has it.
  static Seat take(const std::string& master);
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  int fd_ = -1;  // a socket bound to the number
};

}  // namespace evograsp::worker
