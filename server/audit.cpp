#include "server/audit.h"

#include <algorithm>
#include <utility>

namespace evograsp::server {

void Auditor::begin() {
  done_.clear();
  cases_.clear();
}

void Auditor::did(const Piece& piece, Party party) {
  done_.push_back({piece, party});
}

std::uint32_t Auditor::open(const Piece& piece, Party party, std::string result) {
  Case& opened = cases_[next_case_];
  opened.piece = piece;
  opened.opinions.push_back({party, std::move(result)});
  return next_case_++;
}

Auditor::Verdict Auditor::opinion(std::uint32_t number, Party party, std::string result) {
  Verdict verdict;
  const auto found = cases_.find(number);
  if (found == cases_.end()) return verdict;
  std::vector<Opinion>& opinions = found->second.opinions;
  verdict.piece = found->second.piece;
  const bool confirmed =
      std::any_of(opinions.begin(), opinions.end(), [&](const Opinion& o) { return o.result == result; });
  if (!confirmed) {
    opinions.push_back({party, std::move(result)});
    for (const Opinion& o : opinions) verdict.heard.push_back(o.party);
    verdict.state = State::kDisputed;
    return verdict;
  }
  for (const Opinion& o : opinions) {
    verdict.heard.push_back(o.party);
    if (o.result != result) verdict.liars.push_back(o.party);
  }
  verdict.heard.push_back(party);
  verdict.state = verdict.liars.empty() ? State::kAgreed : State::kDecided;
  cases_.erase(found);
  return verdict;
}

Auditor::Discarded Auditor::discard(Party party) {
  Discarded discarded;
  std::erase_if(done_, [&](const Done& done) {
    if (done.party != party) return false;
    discarded.pieces.push_back(done.piece);
    return true;
  });
  std::erase_if(cases_, [&](const auto& entry) {
    if (entry.second.opinions.front().party != party) return false;
    discarded.cases.push_back(entry.first);
    return true;
  });
  return discarded;
}

void Auditor::forget(std::uint32_t network) {
  std::erase_if(done_, [&](const Done& done) { return done.piece.network == network; });
}

}  // namespace evograsp::server
