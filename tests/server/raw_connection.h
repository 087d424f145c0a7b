// A plain TCP connection to an endpoint, for tests that speak no ZeroMQ at all.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstdint>
#include <string>

namespace evograsp::testing {

// To 127.0.0.1 at the port that `endpoint` ("tcp://HOST:PORT") ends with; -1 when nobody listens.
inline int raw_connection(const std::string& endpoint) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1))));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return fd;
  ::close(fd);
  return -1;
}

// One that is through with its ZMTP handshake (3.0, no keys) as a socket of this type, by hand: libzmq guards
// itself, and its peer, from much of what a stranger may say.
inline int zmtp_connection(const std::string& endpoint, const std::string& socket_type) {
  const int fd = raw_connection(endpoint);
  std::string said("\xff\0\0\0\0\0\0\0\1\x7f\3\0NULL", 16);
  said.resize(64, '\0');
  std::string ready = "\5READY\13Socket-Type";
  ready += std::string(3, '\0') + static_cast<char>(socket_type.size()) + socket_type;
  said += '\4' + std::string(1, static_cast<char>(ready.size())) + ready;
  ::send(fd, said.data(), said.size(), MSG_NOSIGNAL);
  const timeval patience{2, 0};
  ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  ::setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  char answer[256];
  ssize_t got = 0, more = 1;
  while (got < 80 && more > 0) got += more = ::recv(fd, answer, sizeof answer, 0);  // its greeting and READY
  return fd;
}

}  // namespace evograsp::testing
