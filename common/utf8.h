// Text or not?
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace evograsp {

// Where the first thing stands that is no text: a malformed UTF-8 sequence or a NUL. Overlong forms pass.
std::optional<std::size_t> first_non_text(std::string_view s);

// Something that would steer a terminal or end a line: U+0000 to U+001F, U+007F, and U+0080 to U+009F as
// UTF-8 writes them.
bool has_control(std::string_view s);

}  // namespace evograsp
