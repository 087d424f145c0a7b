// Content hashes and bytes that do not depend on map order.
#pragma once

#include <google/protobuf/message_lite.h>

#include <string>
#include <string_view>

namespace evograsp {

// Lower-case hex SHA-256.
std::string sha256_hex(std::string_view bytes);
// The deterministic serialisation of a message.
std::string deterministic_bytes(const google::protobuf::MessageLite& message);

}  // namespace evograsp
