#include "common/zap.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

namespace evograsp {

namespace {

constexpr std::size_t kKeyLength = 40;
constexpr std::size_t kMaxKeyFile = 1 << 20;

// The library reads up to the first NUL, and would take a shorter key.
bool is_key(const std::string& text) {
  std::array<std::uint8_t, 32> raw{};
  return text.size() == kKeyLength && text.find('\0') == std::string::npos &&
         zmq_z85_decode(raw.data(), text.c_str()) != nullptr;
}

Result<std::string> read_small(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return fail(ErrorCode::kNotFound, file.string() + ": cannot be read: " + std::strerror(errno));
  std::string text(kMaxKeyFile + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxKeyFile)
    return fail(ErrorCode::kInvalid, file.string() + ": too large for a key file");
  return text;
}

// "name = value" without spaces around; false for comments and empty lines.
bool split(const std::string& line, std::string& name, std::string& value) {
  const std::string text = line.substr(0, line.find('#') == 0 ? 0 : std::string::npos);
  const auto equals = text.find('=');
  if (equals == std::string::npos) return false;
  const auto trim = [](const std::string& s) {
    const auto first = s.find_first_not_of(" \t\r");
    return first == std::string::npos ? std::string()
                                      : s.substr(first, s.find_last_not_of(" \t\r") - first + 1);
  };
  name = trim(text.substr(0, equals));
  value = trim(text.substr(equals + 1));
  return true;
}

}  // namespace

Result<CurveKeys> load_keys(const std::filesystem::path& file) {
  struct stat info {};
  if (stat(file.c_str(), &info) == 0 && (info.st_mode & (info.st_uid == 0 ? 037 : 077)) != 0)
    return fail(ErrorCode::kInvalid, file.string() + ": others may read this secret key: chmod 600 it");
  const auto text = read_small(file);
  if (!text) return tl::unexpected(text.error());
  CurveKeys keys;
  std::istringstream lines(*text);
  std::string line, name, value;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!split(line, name, value)) continue;
    const std::string place = file.string() + ":" + std::to_string(number) + ": ";
    if (!is_key(value))
      return fail(ErrorCode::kInvalid, place + "not a key: 40 characters of Z85 are wanted");
    if (name == "public-key")
      keys.public_key = value;
    else if (name == "secret-key")
      keys.secret_key = value;
    else if (name == "server-key")
      keys.server_key = value;
    else
      return fail(ErrorCode::kInvalid, place + "a key is named public-key, secret-key or server-key");
  }
  if (keys.public_key.empty() || keys.secret_key.empty())
    return fail(ErrorCode::kInvalid,
                file.string() + ": public-key and secret-key are wanted: evograsp keygen");
  return keys;
}

Result<std::set<std::string>> load_allow_list(const std::filesystem::path& file) {
  if (file.empty())
    return fail(ErrorCode::kUsage,
                "net.curve_allow_file is not set: it lists the public keys that may connect");
  const auto text = read_small(file);
  if (!text) return tl::unexpected(text.error());
  std::set<std::string> allowed;
  std::istringstream lines(*text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string key;
    // '#' is a character of Z85: only a line that is no key may be a comment.
    if (!(words >> key) || (key[0] == '#' && !is_key(key))) continue;
    if (!is_key(key))
      return fail(ErrorCode::kInvalid, file.string() + ":" + std::to_string(number) + ": not a public key");
    allowed.insert(key);
  }
  return allowed;
}

Result<CurveKeys> generate_keys(const std::filesystem::path& file, const std::string& server_key) {
  if (!server_key.empty() && !is_key(server_key))
    return fail(ErrorCode::kUsage, "the server key is not a key: 40 characters of Z85 are wanted");
  std::array<char, kKeyLength + 1> public_key{}, secret_key{};
  if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0)
    return fail(ErrorCode::kUnsupported, "this libzmq was built without CURVE");
  CurveKeys keys{public_key.data(), secret_key.data(), server_key};
  std::string text =
      "# evograsp key pair: keep this file to yourself, give away the public key alone\npublic-key = " +
      keys.public_key + "\nsecret-key = " + keys.secret_key + "\n";
  if (!server_key.empty()) text += "server-key = " + server_key + "\n";
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (fd < 0) return fail(ErrorCode::kIo, file.string() + ": cannot be made: " + std::strerror(errno));
  const bool written =
      write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && fsync(fd) == 0;
  const int problem = errno;
  close(fd);
  if (written) return keys;
  unlink(file.c_str());  // half a key would stand in the way of the next attempt
  return fail(ErrorCode::kIo, file.string() + ": cannot be written: " + std::strerror(problem));
}

namespace {

class GatekeeperThread : public Gatekeeper {
 public:
  GatekeeperThread(zmq::socket_t socket, std::optional<std::set<std::string>> allowed,
                   std::shared_ptr<Strangers> strangers)
      : socket_(std::move(socket)),
        allowed_(std::move(allowed)),
        strangers_(strangers ? std::move(strangers) : std::make_shared<Strangers>()),
        thread_([this] { run(); }) {}

  ~GatekeeperThread() override {
    stopping_ = true;
    wakeup_.notify();
    thread_.join();
  }

  std::uint64_t refused() const override { return refused_; }

 private:
  void run() {
    while (!stopping_) {
      zmq::pollitem_t items[] = {{socket_.handle(), 0, ZMQ_POLLIN, 0},
                                 {nullptr, wakeup_.fd(), ZMQ_POLLIN, 0}};
      try {
        zmq::poll(items, 2, std::chrono::milliseconds(-1));
        if (items[0].revents != 0) answer();
      } catch (const zmq::error_t&) {
        return;  // the context ends
      }
    }
  }

  // Request: version, id, domain, address, identity, mechanism, credentials. Reply: version, id, status,
  // text, user, metadata.
  void answer() {
    std::vector<std::string> request;
    zmq::message_t frame;
    do {
      if (!socket_.recv(frame)) return;
      if (request.size() < 16) request.push_back(frame.to_string());
    } while (frame.more());
    const std::string key = request.size() == 7 && request[5] == "CURVE" ? z85(request[6]) : std::string();
    const bool plain = request.size() >= 6 && request[5] == "NULL";
    const bool welcome = allowed_ ? allowed_->contains(key) : plain;
    if (!welcome) complain(request.size() > 3 ? request[3] : "?", key);
    const std::string reply[] = {"1.0",
                                 request.size() > 1 ? request[1] : "",
                                 welcome ? "200" : "400",
                                 welcome ? "OK" : "not on the allow-list",
                                 welcome ? key : "",
                                 ""};
    for (std::size_t i = 0; i < std::size(reply); ++i)
      socket_.send(zmq::buffer(reply[i]),
                   i + 1 < std::size(reply) ? zmq::send_flags::sndmore : zmq::send_flags::none);
  }

  static std::string z85(const std::string& raw) {
    std::array<char, kKeyLength + 1> text{};
    if (raw.size() != 32) return {};
    zmq_z85_encode(text.data(), reinterpret_cast<const std::uint8_t*>(raw.data()), raw.size());
    return text.data();
  }

  void complain(const std::string& address, const std::string& key) {
    ++refused_;
    strangers_->tell(Offence::kKey, address, "key " + key + " is not on the allow-list");
  }

  zmq::socket_t socket_;
  const std::optional<std::set<std::string>> allowed_;
  const std::shared_ptr<Strangers> strangers_;
  Wakeup wakeup_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> refused_{0};
  std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<Gatekeeper>> Gatekeeper::create(zmq::context_t& context,
                                                       std::optional<std::set<std::string>> allowed,
                                                       std::shared_ptr<Strangers> strangers) {
  try {
    zmq::socket_t socket(context, zmq::socket_type::rep);
    socket.set(zmq::sockopt::linger, 0);
    socket.bind("inproc://zeromq.zap.01");
    return std::make_unique<GatekeeperThread>(std::move(socket), std::move(allowed), std::move(strangers));
  } catch (const zmq::error_t& error) {
    return fail(ErrorCode::kInternal,
                std::string("cannot start the gatekeeper of CURVE sockets: ") + error.what());
  }
}

}  // namespace evograsp
