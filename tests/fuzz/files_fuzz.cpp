// The small files that a user hands over, told by the first byte: keys, the list of those allowed in, a
// bearer token, a rendezvous, the camera of a depth image. A refusal names the file; what is accepted is what
// the headers say.
#include <sys/stat.h>

#include <cmath>
#include <cstring>

#include "cli/camera_file.h"
#include "common/rendezvous.h"
#include "common/zap.h"
#include "server/api.h"
#include "tests/fuzz/capture.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace evograsp;

void check_refusal(const Error& error, const std::string& file) {
  fuzz::require(error.message.starts_with(file + ":"), "a refusal begins with the file's name");
  fuzz::require(error.message.size() > file.size() + 2, "and gives a reason");
}

void check_key(const std::string& key) {
  constexpr const char* kZ85 =
      "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#";
  fuzz::require(key.size() == 40, "a key has 40 characters");
  for (const char c : key) fuzz::require(c != '\0' && std::strchr(kZ85, c) != nullptr, "of Z85");
}

void keys(const std::string& file) {
  chmod(file.c_str(), 0600);
  const auto read = load_keys(file);
  if (!read) {
    fuzz::require(fuzz::is_harmless(read.error().message, false), "a refusal is a line of text");
    return check_refusal(read.error(), file);
  }
  check_key(read->public_key);
  check_key(read->secret_key);
  if (!read->server_key.empty()) check_key(read->server_key);
}

void allow_list(const std::string& file) {
  const auto read = load_allow_list(file);
  if (!read) return check_refusal(read.error(), file);
  for (const std::string& key : *read) check_key(key);
}

void token(const std::string& file) {
  const auto read = server::load_token(file);
  if (!read) return check_refusal(read.error(), file);
  fuzz::require(read->size() >= 16 && read->size() <= 4096, "a token has 16 to 4096 characters");
  fuzz::require(fuzz::is_harmless(*read, false), "that a header can carry");
}

void check_address(const std::string& address) {
  fuzz::require(address.find("://") != std::string::npos, "an address has a scheme");
  fuzz::require(address.find(' ') == std::string::npos, "and no spaces");
}

void rendezvous(const std::string& file) {
  const auto read = read_rendezvous(file);
  if (!read) return check_refusal(read.error(), file);
  fuzz::require(!read->connect.empty() || !read->over.empty(), "it says where, or that the run is over");
  if (!read->connect.empty()) check_address(read->connect);
  if (!read->http.empty()) check_address(read->http);
  fuzz::require(fuzz::is_harmless(read->connect + read->http + read->over, false), "in text");
  fuzz::require(write_rendezvous(file, *read).has_value(), "it can be written");
  const auto again = read_rendezvous(file);
  fuzz::require(
      again && again->connect == read->connect && again->http == read->http && again->over == read->over,
      "and says the same again");
}

void camera(const std::string& file) {
  static const sim::GreyImage image{24, 18, std::vector<std::uint16_t>(24 * 18, 1000)};
  fuzz::Caught told(stderr);
  const auto read = cli::read_camera(file, image);
  fuzz::require(fuzz::is_harmless(told.end(), true), "warnings are lines of text");
  if (!read) return check_refusal(read.error(), file);
  for (const auto& [f, c, pixels] : {std::tuple{read->fx, read->cx, 24}, {read->fy, read->cy, 18}})
    fuzz::require(f >= 0.05 * pixels && f <= 100.0 * pixels && std::abs(c) <= 3.0 * pixels,
                  "a camera can be so");
  fuzz::require(sim::DepthImage::create(image, *read).has_value(), "it makes an image");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  fuzz::Pieces pieces(data, size);
  constexpr void (*kDoors[])(const std::string&) = {keys, allow_list, token, rendezvous, camera};
  const auto door = kDoors[pieces.byte() % std::size(kDoors)];
  door(folder.write("file", pieces.rest()));
  return 0;
}
