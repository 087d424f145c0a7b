#include "common/rendezvous.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>

#include "common/utf8.h"

namespace evograsp {

namespace {

constexpr std::size_t kMaxFile = 4096;
constexpr char kSpace[] = " \t\r";

bool stands_for_all(const std::string& host) {
  return host == "0.0.0.0" || host == "[::]" || host == "::" || host == "*";
}

Result<std::string> read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return fail(ErrorCode::kNotFound, file.string() + ": " + std::strerror(errno));
  std::string text(kMaxFile + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxFile)
    return fail(ErrorCode::kInvalid, file.string() + ": too large for a rendezvous");
  return text;
}

bool is_address(const std::string& value) {
  const auto scheme = value.find("://");
  return scheme != std::string::npos && scheme > 0 && scheme + 3 < value.size() &&
         value.find_first_of(kSpace) == std::string::npos;
}

bool still_says(const std::filesystem::path& file, const Rendezvous& where) {
  const auto now = read_rendezvous(file);
  return now && now->connect == where.connect;
}

}  // namespace

std::string advertised(const std::string& bound, const std::string& host) {
  const auto scheme = bound.find("://");
  const auto colon = bound.rfind(':');
  if (scheme == std::string::npos || colon <= scheme + 2) return bound;
  if (!stands_for_all(bound.substr(scheme + 3, colon - scheme - 3))) return bound;
  return bound.substr(0, scheme + 3) + host + bound.substr(colon);
}

std::string advertised_http(const std::string& listen, int port, const std::string& host) {
  if (port == 0) return {};
  const std::string own = listen.substr(0, listen.rfind(':'));
  return "http://" + (stands_for_all(own) ? host : own) + ":" + std::to_string(port);
}

Status write_rendezvous(const std::filesystem::path& file, const Rendezvous& where) {
  const std::filesystem::path fresh = file.string() + "." + std::to_string(getpid());
  std::string text;
  for (const auto& [name, value] :
       {std::pair{"connect", &where.connect}, {"http", &where.http}, {"over", &where.over}})
    if (!value->empty()) text += std::string(name) + " = " + *value + "\n";
  const int fd = open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  bool written = fd >= 0 && write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  written = written && fsync(fd) == 0;
  if (fd >= 0) close(fd);
  if (written && rename(fresh.c_str(), file.c_str()) == 0) return {};
  const std::string reason = std::strerror(errno);
  unlink(fresh.c_str());
  return fail(ErrorCode::kIo, file.string() + ": cannot be written: " + reason);
}

Result<Rendezvous> read_rendezvous(const std::filesystem::path& file) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  Rendezvous where;
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, equals, value;
    words >> name >> equals >> std::ws;
    std::getline(words, value);
    value.erase(value.find_last_not_of(kSpace) + 1);
    if (name.empty() || name[0] == '#') continue;
    std::string* const known = name == "connect" ? &where.connect
                               : name == "http"  ? &where.http
                               : name == "over"  ? &where.over
                                                 : nullptr;
    const bool address = known != &where.over;
    if (known == nullptr || equals != "=" || value.empty() || has_control(value) ||
        (address && !is_address(value)))
      return fail(ErrorCode::kInvalid,
                  file.string() + ": not a rendezvous: 'connect = tcp://HOST:PORT' is wanted");
    *known = value;
  }
  if (where.connect.empty() && where.over.empty())
    return fail(ErrorCode::kInvalid, file.string() + ": does not say where to connect");
  return where;
}

void remove_rendezvous(const std::filesystem::path& file, const Rendezvous& where) {
  if (still_says(file, where)) unlink(file.c_str());
}

Status end_rendezvous(const std::filesystem::path& file, const Rendezvous& where, const std::string& why) {
  if (!still_says(file, where)) return {};
  return write_rendezvous(file, {{}, {}, why});
}

}  // namespace evograsp
