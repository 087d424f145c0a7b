// A config file from a stranger: what `evograsp validate` and every program that takes --config does with it.
#include <google/protobuf/text_format.h>

#include "assets/assets.h"
#include "common/config.h"
#include "common/digest.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace evograsp;

// What has been accepted, written out and read again, is the same.
void check_round_trip(const proto::Config& config) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(config, &text);
  proto::Config again;
  fuzz::require(parse_text(text, "again", again).empty(), "an accepted config is accepted again");
  fuzz::require(deterministic_bytes(again) == deterministic_bytes(config), "a config survives being written");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  proto::Config config;
  if (parse_text(text, "config", config).empty()) check_round_trip(config);
  static const KnownNames names{{"scene.object", assets::object_names()},
                                {"grasp.hand", assets::builtin_hands()}};
  const auto loaded = load_config(folder.write("config.txtpb", text), {}, names);
  if (loaded)
    flatten(loaded->config);
  else
    fuzz::require(!loaded.error().empty() && !loaded.error().front().message.empty(),
                  "a refusal has a reason");
  return 0;
}
