#include "server/audit.h"

#include <algorithm>
#include <set>
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

// Two of different hosts; two of one host when no other has said anything.
bool Auditor::convinces(const std::vector<Opinion>& opinions, const std::string& result) {
  std::set<std::uint64_t> hosts, agreeing_hosts;
  std::size_t agreeing = 0;
  for (const Opinion& o : opinions) {
    hosts.insert(o.party.host);
    if (o.result != result) continue;
    agreeing_hosts.insert(o.party.host);
    ++agreeing;
  }
  return agreeing >= 2 && (hosts.size() == 1 || agreeing_hosts.size() >= 2);
}

Auditor::Verdict Auditor::opinion(std::uint32_t number, Party party, std::string result) {
  Verdict verdict;
  const auto found = cases_.find(number);
  if (found == cases_.end()) return verdict;
  std::vector<Opinion>& opinions = found->second.opinions;
  verdict.piece = found->second.piece;
  opinions.push_back({party, std::move(result)});
  const std::string& last = opinions.back().result;
  for (const Opinion& o : opinions) verdict.heard.push_back(o.party);
  if (!convinces(opinions, last)) {
    verdict.state = State::kDisputed;
    return verdict;
  }
  for (const Opinion& o : opinions)
    if (o.result != last) verdict.liars.push_back(o.party);
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
