#include "common/utf8.h"

namespace evograsp {
namespace {

// Bytes of the sequence that this one leads; 0 when it cannot lead any.
std::size_t sequence_length(unsigned char lead) {
  if (lead < 0x80) return lead == 0 ? 0 : 1;
  if (lead >> 5 == 0b110) return 2;
  if (lead >> 4 == 0b1110) return 3;
  return lead >> 3 == 0b11110 ? 4 : 0;
}

}  // namespace

std::optional<std::size_t> first_non_text(std::string_view s) {
  for (std::size_t i = 0; i < s.size();) {
    const std::size_t length = sequence_length(static_cast<unsigned char>(s[i]));
    if (length == 0 || i + length > s.size()) return i;
    for (std::size_t k = 1; k < length; ++k) {
      if (static_cast<unsigned char>(s[i + k]) >> 6 != 0b10) return i;
    }
    i += length;
  }
  return std::nullopt;
}

bool has_control(std::string_view s) {
  for (std::size_t i = 0; i < s.size(); ++i) {
    const auto c = static_cast<unsigned char>(s[i]);
    if (c < 0x20 || c == 0x7f) return true;
    if (c == 0xc2 && i + 1 < s.size() && (static_cast<unsigned char>(s[i + 1]) & 0xe0) == 0x80) return true;
  }
  return false;
}

}  // namespace evograsp
