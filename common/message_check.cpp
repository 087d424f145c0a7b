#include "common/message_check.h"

#include <google/protobuf/text_format.h>

#include <memory>

#include "common/config.h"

namespace evograsp {

Status check_message(const google::protobuf::Message& message, const std::string& name) {
  constexpr std::size_t kMost = 1 << 20;
  if (message.ByteSizeLong() > kMost) return fail(ErrorCode::kInvalid, name + ": larger than 1 MiB");
  google::protobuf::TextFormat::Printer printer;
  printer.SetHideUnknownFields(true);
  std::string text;
  if (!printer.PrintToString(message, &text)) return fail(ErrorCode::kInvalid, name + ": cannot be read");
  const std::unique_ptr<google::protobuf::Message> scratch(message.New());
  const std::vector<Diagnostic> complaints = parse_text(text, name, *scratch);
  if (complaints.empty()) return {};
  return fail(ErrorCode::kInvalid, name + ": " + complaints.front().message);
}

}  // namespace evograsp
