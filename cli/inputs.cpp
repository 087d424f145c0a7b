#include "cli/inputs.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "cli/report.h"
#include "cli/stop_signals.h"
#include "common/message_check.h"
#include "common/network.h"
#include "neat/genome.h"

namespace evograsp::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLargestChampion = 256u << 20;
constexpr std::size_t kMostObjects = 1000;

Status write_all(int file, std::string_view data, const fs::path& path) {
  while (!data.empty()) {
    const ssize_t written = ::write(file, data.data(), data.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return fail(ErrorCode::kIo, path.string() + ": writing failed: " + std::strerror(errno));
    data.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::fsync(file) != 0)
    return fail(ErrorCode::kIo, path.string() + ": writing failed: " + std::strerror(errno));
  return {};
}

}  // namespace

KnownNames known_names() {
  return {{"scene.object", assets::object_names()}, {"grasp.hand", assets::builtin_hands()}};
}

Result<proto::Champion> read_champion(const fs::path& path) {
  std::error_code error;
  const fs::path file = fs::is_directory(path, error) ? path / "champion.pb" : path;
  auto data = read_file(file, kLargestChampion);
  if (!data) return tl::unexpected(data.error());
  proto::Champion champion;
  if (!champion.ParseFromString(*data) || !champion.has_network() || !champion.has_experiment()) {
    return fail(ErrorCode::kInvalid,
                file.string() + ": is not a champion (evograsp train writes champion.pb)");
  }
  if (champion.version() != 1) {
    return fail(ErrorCode::kUnsupported, file.string() + ": champion format " +
                                             std::to_string(champion.version()) + ", this version reads 1");
  }
  const auto network = Network::from_proto(champion.network());
  if (!network) return fail(network.error().code, file.string() + ": " + network.error().message);
  if (champion.has_genome()) {
    // A substrate's network is feed-forward, as its CPPN must be.
    const auto genome = neat::from_proto(champion.genome(), champion.network().recurrent());
    if (!genome) return fail(genome.error().code, file.string() + ": " + genome.error().message);
  }
  if (Status ok = check_message(champion.experiment(), file.string()); !ok) return tl::unexpected(ok.error());
  write_defaults(*champion.mutable_experiment());
  return champion;
}

Result<proto::HandBundle> load_hand(const std::string& name_or_path) {
  auto loaded = assets::load_hand(name_or_path, {});
  if (!loaded) return tl::unexpected(loaded.error());
  for (const std::string& warning : loaded->warnings) warn(warning);
  return std::move(loaded->bundle);
}

Status write_file(const fs::path& path, std::string_view data) {
  const fs::path temporary = path.string() + ".part";
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return fail(ErrorCode::kIo, path.string() + ": cannot be written: " + std::strerror(errno));
  const UnfinishedFile unfinished(temporary);
  Status status = write_all(file, data, path);
  ::close(file);
  if (status && std::rename(temporary.c_str(), path.c_str()) != 0) {
    status = fail(ErrorCode::kIo, path.string() + ": cannot be replaced: " + std::strerror(errno));
  }
  if (!status) ::unlink(temporary.c_str());
  return status;
}

bool is_mesh_file(const fs::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  static const std::vector<std::string> kMeshes = {".obj", ".stl", ".ply", ".dae", ".gltf", ".glb"};
  return std::ranges::find(kMeshes, extension) != kMeshes.end();
}

Result<std::vector<std::string>> objects_in(const fs::path& folder) {
  std::error_code error;
  fs::directory_iterator it(folder, error);
  if (error) return fail(ErrorCode::kNotFound, folder.string() + ": no such folder");
  std::vector<std::string> found;
  for (; it != fs::directory_iterator(); it.increment(error)) {
    if (error) return fail(ErrorCode::kIo, folder.string() + ": " + error.message());
    const fs::path& path = it->path();
    if (is_mesh_file(path) || path.extension() == ".txtpb") found.push_back(path.string());
    if (found.size() > kMostObjects) {
      return fail(ErrorCode::kInvalid,
                  folder.string() + ": more than " + std::to_string(kMostObjects) + " objects");
    }
  }
  if (found.empty())
    return fail(ErrorCode::kNotFound, folder.string() + ": no mesh and no object file in this folder");
  std::ranges::sort(found);
  return found;
}

}  // namespace evograsp::cli
