// Work done twice to compare, and what becomes of workers that lie.
//
// A share of the networks, chosen by a random stream of their own, is audited: each piece that one worker did
// is done again by another, and the two are compared bit for bit. An audited network counts as evaluated, and
// is journalled, only when its audit is over; so a generation is never committed ahead of its audits.
#include <algorithm>
#include <utility>

#include "common/random.h"
#include "server/dispatch_loop.h"
#include "server/store_records.h"

namespace evograsp::server {

namespace {

constexpr double kReunionSeconds = 2;   // in which workers that lost their connection are back
constexpr double kLoadingSeconds = 30;  // in which one that is connected has its simulator

}  // namespace

bool DispatchLoop::is_audited(std::uint64_t genome) const {
  if (options_.audit_share <= 0) return false;
  return Random(work_.trial_set, Purpose::kAudit, work_.generation, genome).chance(options_.audit_share);
}

// A liar that comes back under another name, and what shares its hardware, are no more trusted than it was.
bool DispatchLoop::is_on_probation(const Session& session) const {
  return probation_.contains(session.party.host);
}

std::string DispatchLoop::name_of(Party party) const {
  const auto found = names_.find(party);
  return found == names_.end() ? "?" : found->second;
}

namespace {

// What two honest workers have in common: the measurements of one network.
std::string opinion_of(const proto::TaskResult& result, int network, std::uint32_t trials) {
  std::vector<proto::Measurement> own;
  own.reserve(trials);
  for (std::uint32_t i = 0; i < trials; ++i)
    own.push_back(result.measurement(network * static_cast<int>(trials) + static_cast<int>(i)));
  return pack_measurements(own);
}

}  // namespace

// Before the scheduler hears of the result: what has to be done again must be known before the network is
// complete.
void DispatchLoop::book(const Session& session, const Assignment& what, const proto::TaskResult& result) {
  if (what.audit != 0) return hear(session, what, result);
  names_.try_emplace(session.party, session.view.identity);
  int next = 0, position = 0;
  for (const std::uint32_t network : what.networks) {
    const Piece piece{network, what.first_trial, what.trials};
    std::vector<proto::Measurement>& all = measurements_[network];
    all.resize(work_.trials.size());
    for (std::uint32_t i = 0; i < what.trials; ++i) all[what.first_trial + i] = result.measurement(next++);
    const int own = position++;
    if (told_[network] != 0) continue;  // given up meanwhile
    auditor_.did(piece, session.party);
    if (!is_audited(networks_[network].id) && !is_on_probation(session)) continue;
    const std::uint32_t number = auditor_.open(piece, session.party, opinion_of(result, own, what.trials));
    scheduler_.audit(number, piece, {session.party});
  }
}

// A second opinion, or a third.
void DispatchLoop::hear(const Session& session, const Assignment& what, const proto::TaskResult& result) {
  names_.try_emplace(session.party, session.view.identity);
  if (told_[what.networks.front()] != 0) return;
  const Auditor::Verdict verdict =
      auditor_.opinion(what.audit, session.party, opinion_of(result, 0, what.trials));
  if (verdict.state == Auditor::State::kStale) return;
  ++totals_.audits;
  if (verdict.state == Auditor::State::kAgreed) return;
  if (verdict.state == Auditor::State::kDecided) return condemn(verdict);
  ++totals_.audit_mismatches;
  std::string names;
  for (const Party party : verdict.heard) names += (names.empty() ? "" : ", ") + name_of(party);
  sink_.event(true, "audit_mismatch",
              "genome " + std::to_string(networks_[verdict.piece.network].id) + " of generation " +
                  std::to_string(work_.generation) + ": the results of " + names +
                  " differ: another worker decides, of another host when there is one");
  scheduler_.audit(what.audit, verdict.piece, verdict.heard);
}

void DispatchLoop::condemn(const Auditor::Verdict& verdict) {
  std::string honest;
  for (const Party party : verdict.heard)
    if (std::find(verdict.liars.begin(), verdict.liars.end(), party) == verdict.liars.end())
      honest += (honest.empty() ? "" : " and ") + name_of(party);
  for (const Party liar : verdict.liars) {
    const std::string identity = name_of(liar);
    if (quarantined_.contains(identity)) continue;
    ++totals_.quarantined;
    verdicts_[identity] = "its results for genome " + std::to_string(networks_[verdict.piece.network].id) +
                          " of generation " + std::to_string(work_.generation) + " differ from what " +
                          honest + " agree on";
    quarantined_[identity].identity = identity;
    quarantined_[identity].state = "quarantined";
    liars_.push_back(liar);
    probation_.insert(liar.host);
    discard_work(liar);
  }
}

// All that the liar did of this work is done again. A network that has been told already is retracted and
// done anew as a whole, because its measurements have been given away.
void DispatchLoop::discard_work(Party liar) {
  const Auditor::Discarded discarded = auditor_.discard(liar);
  std::vector<std::uint32_t> retracted;
  std::size_t pieces = 0;
  for (const Piece& piece : discarded.pieces) {
    if (std::find(retracted.begin(), retracted.end(), piece.network) != retracted.end()) continue;
    Piece again = piece;
    if (told_[piece.network] != 0)
      again = {piece.network, 0, static_cast<std::uint32_t>(work_.trials.size())};
    if (!scheduler_.redo(again)) continue;
    ++pieces;
    if (told_[piece.network] == 0) continue;
    told_[piece.network] = 0;
    auditor_.forget(piece.network);
    retracted.push_back(piece.network);
  }
  for (const std::uint32_t number : discarded.cases) scheduler_.withdraw_audit(number);
  if (!retracted.empty()) {
    totals_.evaluations -= retracted.size();
    sink_.retracted(retracted);
  }
  const std::string identity = name_of(liar);
  sink_.event(true, "quarantine",
              "worker " + identity + " is quarantined: " + verdicts_[identity] + "; " +
                  std::to_string(pieces) +
                  " of its results of this generation are done again, and all that its host does is audited");
}

void DispatchLoop::send_liars_away() {
  for (const Party liar : std::exchange(liars_, {})) {
    const auto found =
        std::find_if(by_id_.begin(), by_id_.end(), [&](const auto& e) { return e.second->party == liar; });
    if (found == by_id_.end()) continue;
    Session& session = *found->second;
    PeerView& kept = quarantined_[session.view.identity];
    kept = session.view;
    kept.state = "quarantined";
    kept.outstanding = 0;
    refuse(session.peer, "quarantined: " + verdicts_[kept.identity], false);
    session.leaving = true;
    end_session(session, Departure::kLeft, "quarantined");
    sink_.worker(kept);
  }
  pump_all();
}

bool DispatchLoop::refuse_quarantined(const std::string& identity, const Received& message) {
  const auto found = verdicts_.find(identity);
  if (found == verdicts_.end()) return false;
  turn_away(message.address, "worker " + identity + ": quarantined, " + found->second);
  refuse(message.peer, "quarantined: " + found->second, false);
  return true;
}

bool DispatchLoop::two_parties() const {
  return std::any_of(by_id_.begin(), by_id_.end(),
                     [&](const auto& e) { return e.second->party != by_id_.begin()->second->party; });
}

// Whether somebody who could give an opinion beside the one party that can now is to be expected: those who
// were here, or who served this run's last master, are back at once, and who is connected is loading. With
// nobody here, waiting costs nothing.
bool DispatchLoop::another_is_near() {
  const int auditors = scheduler_.auditors();
  if (auditors != 1) {
    alone_for_opinions_.reset();
    return auditors == 0;
  }
  if (!alone_for_opinions_) alone_for_opinions_ = now();
  if (now() - *alone_for_opinions_ >= kLoadingSeconds) return false;
  if (parted_ && now() - *parted_ < kReunionSeconds) return true;
  return std::any_of(by_id_.begin(), by_id_.end(), [](const auto& entry) {
    return !entry.second->ready && entry.second->view.state == "active";
  });
}

// It may be back at once.
void DispatchLoop::note_parted(const Session& session) {
  if (two_parties()) parted_ = now();
  parted_hosts_[session.party.host] = now();
  scheduler_.await_host(session.party.host);
}

// A bad machine's workers shall not confirm each other while those of another host are away for a moment.
void DispatchLoop::await_hosts() {
  std::erase_if(parted_hosts_, [&](const auto& host) { return now() - host.second >= kReunionSeconds; });
  std::set<std::uint64_t> awaited;
  for (const auto& [host, when] : parted_hosts_) awaited.insert(host);
  for (const auto& [id, session] : by_id_)
    if (!session->ready && now() - session->began < kLoadingSeconds) awaited.insert(session->party.host);
  scheduler_.await_hosts(std::move(awaited));
}

// Audits for which there is nobody hold up nothing, once it is sure that nobody is near; a contradiction that
// nobody can decide does.
void DispatchLoop::skip_audits() {
  if (!working_ || paused_) return;
  const bool near = another_is_near();
  const Scheduler::Skipped skipped = scheduler_.skip_audits(near || options_.audits_required);
  for (const std::uint32_t number : skipped.audits) auditor_.drop(number);
  tell_complete(skipped.complete);
  if (!skipped.audits.empty() && !std::exchange(said_alone_, true))
    sink_.event(false, "unaudited",
                "audits need two workers: the results of generation " + std::to_string(work_.generation) +
                    " are not compared, nor those of later ones until another worker connects");
  if (skipped.waiting && !near && !std::exchange(said_alone_, true))
    sink_.event(
        true, "audit_waiting",
        "every result is to be compared (dispatch.audit_share is 1): the generation waits until a second "
        "worker connects");
  if (skipped.disputed && !std::exchange(said_disputed_, true))
    sink_.event(true, "audit_waiting",
                "workers contradict each other and there is no other to decide: the generation waits until "
                "one more worker connects, best on a host that has not been heard");
}

}  // namespace evograsp::server
