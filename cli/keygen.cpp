// `evograsp keygen`: key pairs for connections beyond the own machine.
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "cli/cli.h"
#include "cli/output.h"
#include "cli/report.h"
#include "common/zap.h"

namespace evograsp::cli {
namespace {

struct KeygenOptions {
  std::string file, server, allow;
  bool force = false;
  bool json = false;
};

// One more line of an allow-list.
Status allow(const std::string& list, const CurveKeys& keys, const std::string& comment) {
  const std::string line = keys.public_key + " " + comment + "\n";
  const int fd = open(list.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  const bool written = fd >= 0 && write(fd, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const int problem = errno;
  if (fd >= 0) close(fd);
  if (written) return {};
  return fail(ErrorCode::kIo, list + ": cannot be written: " + std::strerror(problem));
}

// With --force the old pair stays until the new one is on the disk.
Result<CurveKeys> make(const KeygenOptions& options, const std::string& server_key) {
  std::error_code error;
  if (!std::filesystem::exists(options.file, error)) return generate_keys(options.file, server_key);
  if (!options.force)
    return fail(ErrorCode::kInvalid, options.file +
                                         ": is there already; --force replaces it, and whoever knows "
                                         "the old public key has to be told the new one");
  const std::string fresh = options.file + ".new";
  std::filesystem::remove(fresh, error);
  auto keys = generate_keys(fresh, server_key);
  if (!keys) return keys;
  std::filesystem::rename(fresh, options.file, error);
  if (error) return fail(ErrorCode::kIo, options.file + ": cannot be replaced: " + error.message());
  return keys;
}

int keygen(const KeygenOptions& options) {
  std::string server_key;
  if (!options.server.empty()) {
    const auto server = load_keys(options.server);
    if (!server) return report(server.error());
    server_key = server->public_key;
  }
  const auto keys = make(options, server_key);
  if (!keys) return report(keys.error());
  if (!options.allow.empty())
    if (const Status status = allow(options.allow, *keys, options.file); !status)
      return report(status.error());
  if (options.json) {
    print_json(nlohmann::json{{"file", options.file}, {"public_key", keys->public_key}});
  } else {
    print(keys->public_key + "\n");
  }
  return kExitOk;
}

}  // namespace

void add_keygen(CLI::App& app, Outcome& outcome) {
  const auto options = std::make_shared<KeygenOptions>();
  CLI::App* sub = app.add_subcommand("keygen", "make a key pair for connections beyond this machine");
  sub->add_option("file", options->file, "where the pair goes (mode 0600)")->required()->type_name("FILE");
  sub->add_option("--server", options->server,
                  "for a worker: the server's key file, whose public key it expects");
  sub->add_option("--allow", options->allow,
                  "list of those who may connect, to which the new public key is added");
  sub->add_flag("--force", options->force, "replace a file that is there");
  sub->add_flag("--json", options->json, "answer as JSON");
  sub->footer(
      "Prints the public key. The secret never leaves the file.\n\n"
      "Examples:\n"
      "  evograsp keygen server.key\n"
      "  evograsp keygen worker.key --server server.key --allow workers.allow\n"
      "  evograsp-server --config cube --listen 'tcp://*:5555' --set net.curve_secret_key_file=server.key "
      "\\\n"
      "                  --set net.curve_allow_file=workers.allow\n"
      "  evograsp-worker --connect tcp://master:5555 --curve-key-file worker.key");
  sub->callback([options, &outcome] { outcome.exit_code = keygen(*options); });
}

}  // namespace evograsp::cli
