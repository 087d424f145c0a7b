// Messages that came as bytes, held to what files people write are held to.
#pragma once

#include <google/protobuf/message.h>

#include <string>

#include "common/result.h"

namespace evograsp {

// The first thing that parse_text() would say of the message written as text: a value out of the range that
// proto/options.proto's annotations give, a number that is not finite, text that is not UTF-8, or more than
// fits a file (1 MiB). `name` begins the error (kInvalid). Fields this version does not know are passed over.
// Thread-safe.
Status check_message(const google::protobuf::Message& message, const std::string& name);

}  // namespace evograsp
