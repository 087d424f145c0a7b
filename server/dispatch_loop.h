// The dispatcher's thread: sessions, messages, time-outs. Everything here runs on that one thread.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/connection_monitor.h"
#include "common/task_memory.h"
#include "server/audit.h"
#include "server/dispatcher.h"
#include "server/slot_hint.h"

namespace evograsp::server {

// One worker's connection, from its Hello to its loss.
struct Session {
  std::string peer;     // routing id
  std::string address;  // without port
  WorkerId id = 0;
  Party party;
  PeerView view;
  int fd = -1;
  bool ready = false;                // its simulator stands
  bool held = false;                 // drained by the operator
  bool leaving = false;              // for good: drained by itself, said goodbye, quarantined
  double heard = 0;                  // s, monotonic
  std::uint64_t ping = 0, pong = 0;  // sequence of the last asked for, and of the last that came back
  double ping_sent = 0;
  double began = 0;        // s
  double told = 0;         // when something was sent last
  std::uint64_t work = 0;  // whose list of trials it has; 0: none
  NetworkMemory has;       // of that work's networks
};

// A peer that drives a slot step by step.
struct Client {
  std::uint64_t id = 0;
  std::optional<std::uint64_t> seed;  // of its last shuffle
  std::uint32_t target = 0;           // of its last get_info
  WorkerId worker = 0;                // that has its command; 0: none
  std::uint64_t pending = 0;          // id of that command
  double heard = 0;
};

class DispatchLoop {
 public:
  // router: not bound yet. Throws zmq::error_t when the monitor cannot be set up.
  DispatchLoop(zmq::context_t& context, zmq::socket_t router, DispatcherOptions options, WorkSink& sink);

  zmq::socket_t& router() { return router_; }
  zmq::socket_t& monitor() { return monitor_.socket(); }

  void begin(Work work);
  void add(std::uint32_t first, std::vector<NetworkFrame> networks);
  void abandon();
  void set_paused(bool paused);
  void set_drained(const std::string& node, bool drained);
  void dismiss(const std::string& reason);

  // Handles what has arrived, at most a bounded amount; true when more may be waiting.
  bool receive_some();
  void drop_disconnected();
  // Heartbeats, silences, deadlines, stragglers. Call at least every tick_seconds().
  void tick();
  double tick_seconds() const { return 0.02; }
  DispatchView view() const;

 private:
  // dispatch_messages.cpp: what peers say.
  void handle(Received& message);
  void handle_stranger(Received& message);
  void handle_session(Session& session, const Received& message);
  void on_hello(const Received& message);
  bool supersede(const Received& message);
  void on_asset_request(const Received& message);
  void on_ready(Session& session, const proto::Ready& ready);
  void on_result(Session& session, const proto::TaskResult& result);
  void on_heartbeat(Session& session, const proto::Heartbeat& heartbeat);
  void on_goodbye(Session& session, const proto::Goodbye& goodbye);
  void cancel(const Scheduler::Accepted& accepted);

  // dispatch_audit.cpp: work done twice, and liars.
  bool is_audited(std::uint64_t genome) const;
  bool is_on_probation(const Session& session) const;
  void book(const Session& session, const Assignment& what, const proto::TaskResult& result);
  void open_case(const Session& session, const Piece& piece, const proto::TaskResult& result);
  void hear(const Session& session, const Assignment& what, const proto::TaskResult& result);
  void condemn(const Auditor::Verdict& verdict);
  void discard_work(Party liar);
  void send_liars_away();
  bool two_parties() const;
  bool another_is_near();
  void note_parted(const Session& session);
  void await_hosts();
  void skip_audits();
  bool refuse_quarantined(const std::string& identity, const Received& message);
  std::string name_of(Party party) const;

  // dispatch_steps.cpp: stepwise clients.
  void on_client_hello(const Received& message);
  void on_step_request(const std::string& peer, Client& client, proto::StepRequest request);
  void on_step_reply(const Session& session, proto::StepReply reply);
  void step_error(const std::string& peer, std::uint64_t id, const std::string& error);
  void fail_steps_of(WorkerId worker);
  void forget_idle_clients();

  void welcome(const std::string& peer);
  void tell_dismissed(const std::string& peer);
  void refuse(const std::string& peer, const std::string& reason, bool retry);
  void misbehaved(const Received& message, const std::string& fault);
  void misbehaved(Session& session, const std::string& fault);
  void turn_away(const std::string& address, const std::string& text);
  void complain(Offence offence, const char* kind, const std::string& address, const std::string& text);
  void sum_up_complaints();
  void end_floods();
  bool knocks_too_often(const Received& message);
  void list(bool warning, const std::string& kind, const std::string& text);
  void say_unlisted();
  void end_session(Session& session, Departure departure, const std::string& why);
  Departure how_it_went(const Session& session) const;
  void send_heartbeats();
  void excuse_own_absence();
  void lose_silent();
  void expire_tasks();
  void send_idle_away();
  void say_when_waiting();
  void report_poisoned();
  void pump(Session& session);
  void pump_all();
  void pump_now_and_then();
  bool give_one(Session& session);
  void finish_if_done();
  void follow_drain(Session& session);
  void tell_complete(const std::vector<std::uint32_t>& networks);
  SendResult send_task(Session& session, const Assignment& what);
  Session* find(WorkerId id);
  double now() const;

  DispatcherOptions options_;
  WorkSink& sink_;
  zmq::socket_t router_;
  ConnectionMonitor monitor_;
  Scheduler scheduler_;
  google::protobuf::Arena arena_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();

  std::unordered_map<std::string, std::unique_ptr<Session>> sessions_;  // by routing id
  std::map<WorkerId, Session*> by_id_;
  WorkerId next_id_ = 1;
  std::unordered_map<std::string, Client> clients_;  // by routing id
  std::uint64_t next_client_ = 1;
  std::unordered_map<std::string, zmq::message_t> asset_replies_;  // one frame for all who ask

  Work work_;
  std::uint64_t work_number_ = 0;
  std::vector<NetworkFrame> networks_;
  std::vector<std::vector<proto::Measurement>> measurements_;  // by network
  std::vector<std::uint8_t> told_;                             // by network: evaluated or poisoned
  Auditor auditor_;
  std::map<Party, std::string> names_;            // of those that did something of this work
  std::map<std::string, PeerView> quarantined_;   // by identity
  std::map<std::string, std::string> verdicts_;   // why, by identity
  std::vector<Party> liars_;                      // condemned, still connected
  std::set<std::uint64_t> probation_;             // hosts where a liar was found: all they do is audited
  bool said_alone_ = false;                       // that audits need two workers
  std::optional<double> parted_;                  // s; a party went, not for good, and another was here
  std::map<std::uint64_t, double> parted_hosts_;  // s; when a worker of the host went, not for good
  std::optional<double> alone_for_opinions_;      // s; since one party alone could give opinions
  bool said_disputed_ = false;                    // that a dispute needs a third
  bool working_ = false;
  std::set<std::string> drained_;  // hosts and identities
  SlotHint hint_;
  double busy_before_ = 0;  // busy_seconds when this work began
  bool paused_ = false;
  std::string dismissed_;  // why there is no more work, told to whoever comes; empty: there may be
  double next_look_ = 0;   // for silent workers
  std::string scolded_;    // the stranger that was answered last
  double scold_again_ = 0;
  double next_pump_ = 0;
  double next_sums_ = 0;
  double next_flood_look_ = 0;
  double last_tick_ = 0;
  bool heard_all_ = true;    // nothing was waiting when last looked
  double alone_since_ = -1;  // s; work, but nobody to do it
  bool said_waiting_ = false;
  DispatchView totals_;
  std::unordered_map<std::string, LogLimiter> hellos_;  // by routing id, of those that said one lately
  LogLimiter listed_{1000, 0.2};                        // who joined and who went
  std::uint64_t said_unlisted_ = 0;                     // of those that listed_ held back
  double next_unlisted_ = 0;
};

}  // namespace evograsp::server
