// What the command line prints, while an object of this lives: caught in memory, so that a search can look at
// it.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace evograsp::fuzz {

// No control character but, where asked for, the ends of lines. Two bytes of UTF-8 can be one as well.
inline bool is_harmless(std::string_view text, bool several_lines) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c == '\n' && several_lines) continue;
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0;
    if (c < 0x20 || c == 0x7f || (c == 0xc2 && next >= 0x80 && next < 0xa0)) return false;
  }
  return true;
}

// One of the two standard streams in the C library's sense; the descriptor stays as it is, for the
// sanitizers.
class Caught {
 public:
  explicit Caught(std::FILE*& stream) : stream_(stream), kept_(stream) {
    stream_ = ::open_memstream(&bytes_, &size_);
    if (stream_ == nullptr) std::abort();
  }
  ~Caught() {
    end();
    std::free(bytes_);
  }
  Caught(const Caught&) = delete;
  Caught& operator=(const Caught&) = delete;

  // Gives the stream back; what was written to it.
  std::string_view end() {
    if (stream_ != kept_) {
      std::fclose(stream_);
      stream_ = kept_;
    }
    return {bytes_, size_};
  }

 private:
  std::FILE*& stream_;
  std::FILE* const kept_;
  char* bytes_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace evograsp::fuzz
