// Where a master can be found, in a file that its workers read: on a cluster nobody knows before the job
// starts on which node that will be.
//
//   connect = tcp://node17:40213
//   http = http://node17:40871
//
// Once the run is over, so that workers that come late do not wait for a master that will never be:
//
//   over = the run is finished
#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"

namespace evograsp {

struct Rendezvous {
  std::string connect;  // for workers
  std::string http{};   // of the HTTP API; empty: it has none
  std::string over{};   // why no master will be there again, `connect` being empty then; empty: one is there
};

// What others have to say to reach a socket that was bound as `bound`: `host` takes the place of an address
// that stands for all of a machine's ("tcp://0.0.0.0:40213", "tcp://[::]:40213").
std::string advertised(const std::string& bound, const std::string& host);
// The same for the HTTP API, which listens at net.http and was given `port`.
std::string advertised_http(const std::string& listen, int port, const std::string& host);

// Replaces the file as a whole: a reader sees the old one or the new one. kIo.
Status write_rendezvous(const std::filesystem::path& file, const Rendezvous& where);
// Addresses have a scheme, no value has control characters. kNotFound: not there (yet). kInvalid: something
// else than a rendezvous.
Result<Rendezvous> read_rendezvous(const std::filesystem::path& file);
// Takes the file away if it still says `where`: a successor may have written its own.
void remove_rendezvous(const std::filesystem::path& file, const Rendezvous& where);
// Says that the run is over, if the file still says `where`. kIo.
Status end_rendezvous(const std::filesystem::path& file, const Rendezvous& where, const std::string& why);

}  // namespace evograsp
