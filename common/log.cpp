#include "common/log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/ansicolor_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <unistd.h>

#include <algorithm>
#include <memory>

namespace evograsp {

namespace {

// A message as a JSON string; spdlog's patterns do not escape.
class JsonFormatter : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    spdlog::memory_buf_t head;
    head_.format(message, head);
    while (head.size() > 0 && head[head.size() - 1] == '\n') head.resize(head.size() - 1);
    append(out, std::string_view(head.data(), head.size()));
    for (const char c : message.payload) escape(static_cast<unsigned char>(c), out);
    append(out, "\"}\n");
  }
  std::unique_ptr<formatter> clone() const override { return std::make_unique<JsonFormatter>(); }

 private:
  static void append(spdlog::memory_buf_t& out, std::string_view text) {
    out.append(text.data(), text.data() + text.size());
  }
  static void escape(unsigned char c, spdlog::memory_buf_t& out) {
    static constexpr char kDigits[] = "0123456789abcdef";
    if (c == '"' || c == '\\') {
      const char text[2] = {'\\', static_cast<char>(c)};
      append(out, {text, 2});
    } else if (c < 0x20) {
      const char text[6] = {'\\', 'u', '0', '0', kDigits[c >> 4], kDigits[c & 15]};
      append(out, {text, 6});
    } else {
      out.push_back(static_cast<char>(c));
    }
  }

  spdlog::pattern_formatter head_{R"({"time":"%Y-%m-%dT%H:%M:%S.%e%z","level":"%l","pid":%P,"message":")"};
};

}  // namespace

void set_up_logging(const LogOptions& options) {
  spdlog::drop("evograsp");
  auto logger = spdlog::stderr_color_mt("evograsp");
  if (options.json)
    logger->set_formatter(std::make_unique<JsonFormatter>());
  else
    logger->set_pattern("%H:%M:%S.%e %^%-7l%$ %v");
  logger->set_level(options.level);
  spdlog::set_default_logger(std::move(logger));
}

bool set_log_level(const std::string& name) {
  const auto level = spdlog::level::from_str(name);
  if (level == spdlog::level::off && name != "off") return false;
  spdlog::set_level(level);
  return true;
}

std::string log_level() {
  const auto name = spdlog::level::to_string_view(spdlog::get_level());
  return std::string(name.data(), name.size());
}

bool LogLimiter::allow(double now_seconds) {
  tokens_ = std::min(burst_, tokens_ + (now_seconds - last_) / seconds_);
  last_ = now_seconds;
  if (tokens_ < 1) {
    ++held_back_;
    return false;
  }
  tokens_ -= 1;
  return true;
}

}  // namespace evograsp
