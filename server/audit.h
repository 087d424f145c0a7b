// Who did what, and who is to be believed when two workers disagree. A pure book: no sockets, no clock.
//
// A trial is a pure function, so two honest workers give the same bits. A piece of work that is audited is
// done again by another worker; when the two differ, more are asked until two of them agree: the others lied
// (or their hardware did). Workers of one host share its hardware and its operator: where opinions of two
// hosts have been heard, only agreement across hosts counts.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace evograsp::server {

// Whom a worker speaks for, both hashed. A session that comes back under its identity is the same party, from
// wherever it comes.
struct Party {
  std::uint64_t identity = 0, host = 0;
  Party() = default;
  explicit Party(std::uint64_t who, std::uint64_t where = 0) : identity(who), host(where) {}
  bool operator==(const Party& other) const { return identity == other.identity; }
  bool operator<(const Party& other) const { return identity < other.identity; }
};

// Consecutive trials of one network.
struct Piece {
  std::uint32_t network = 0, first = 0, trials = 0;
};

// Not thread-safe.
class Auditor {
 public:
  // New work: forgets the old.
  void begin();

  // `party`'s result of the piece has been accepted.
  void did(const Piece& piece, Party party);

  // Opens a case: `result` is what `party` made of the piece (bytes that two honest workers have in common).
  // Gives the case's number, never 0.
  std::uint32_t open(const Piece& piece, Party party, std::string result);

  enum class State {
    kStale,     // the case is closed: the opinion means nothing
    kAgreed,    // closed: the first opinion was confirmed by the second
    kDisputed,  // not decided yet: another opinion is wanted, by none of `heard`
    kDecided,   // closed: two agree who are to be believed, those in `liars` do not
  };
  struct Verdict {
    State state = State::kStale;
    Piece piece;
    std::vector<Party> heard;
    std::vector<Party> liars;
  };
  Verdict opinion(std::uint32_t number, Party party, std::string result);
  // No opinion is to be had: the case is closed.
  void drop(std::uint32_t number) { cases_.erase(number); }

  struct Discarded {
    std::vector<Piece> pieces;         // to be done again
    std::vector<std::uint32_t> cases;  // closed, because they were about these pieces
  };
  // Forgets everything that `party` did.
  Discarded discard(Party party);
  // Forgets who did the network's pieces: it is done again as a whole.
  void forget(std::uint32_t network);

 private:
  struct Done {
    Piece piece;
    Party party;
  };
  struct Opinion {
    Party party;
    std::string result;
  };
  struct Case {
    Piece piece;
    std::vector<Opinion> opinions;  // the first is the one that was accepted
  };
  static bool convinces(const std::vector<Opinion>& opinions, const std::string& result);

  std::vector<Done> done_;
  std::map<std::uint32_t, Case> cases_;
  std::uint32_t next_case_ = 1;
};

}  // namespace evograsp::server
