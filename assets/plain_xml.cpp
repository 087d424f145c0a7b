#include "assets/plain_xml.h"

#include <algorithm>

namespace evograsp::assets {
namespace {

bool begins_name(char c) {
  const auto u = static_cast<unsigned char>(c);
  return (u >= 'a' && u <= 'z') || (u >= 'A' && u <= 'Z') || u == '_' || u >= 128;
}

class Reducer {
 public:
  explicit Reducer(std::string_view xml) : xml_(xml.substr(0, xml.find('\0'))) {
    constexpr std::string_view kMark = "\xEF\xBB\xBF";
    if (xml_.starts_with(kMark)) at_ = kMark.size();
  }

  Result<std::string> run() {
    while (at_ < xml_.size()) {
      const std::size_t tag = std::min(xml_.find('<', at_), xml_.size());
      out_.append(xml_.substr(at_, tag - at_));
      at_ = tag;
      if (at_ < xml_.size())
        if (const Status ok = construct(); !ok) return tl::unexpected(ok.error());
    }
    return std::move(out_);
  }

 private:
  Status construct() {
    const std::string_view rest = xml_.substr(at_);
    if (rest.starts_with("<!--")) return leave_out(4, "-->", "a comment");
    if (rest.starts_with("<?")) return leave_out(2, "?>", "a processing instruction");
    if (rest.starts_with("<!DOCTYPE") && depth_ == 0) return doctype();
    if (rest.starts_with("</")) return closing();
    if (rest.size() < 2 || !begins_name(rest[1])) return bad("'<' does not begin an element");
    return opening();
  }

  // Whatever stands in it never reaches the parser.
  Status leave_out(std::size_t begin, std::string_view end, const char* what) {
    const std::size_t last = xml_.find(end, at_ + begin);
    if (last == std::string_view::npos) return bad(std::string(what) + " that does not end");
    at_ = last + end.size();
    return {};
  }

  Status doctype() {
    const std::size_t end = xml_.find('>', at_);
    if (end == std::string_view::npos) return bad("a DOCTYPE that does not end");
    const std::string_view text = xml_.substr(at_, end - at_);
    if (text.find('[') != std::string_view::npos) return bad("a DOCTYPE with definitions is not supported");
    at_ = end + 1;
    return {};
  }

  Status closing() {
    const std::size_t end = xml_.find('>', at_);
    if (end == std::string_view::npos) return bad("a tag that does not end");
    if (--depth_ < 0) return bad("closes an element that is not open");
    return keep(end);
  }

  Status opening() {
    char quote = 0;
    int attributes = 0;
    std::size_t end = at_ + 1;
    for (; end < xml_.size(); ++end) {
      const char c = xml_[end];
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if (c == '"' || c == '\'') {
        quote = c;
      } else if (c == '=') {
        ++attributes;
      } else if (c == '<') {
        return bad("'<' within a tag");
      } else if (c == '>') {
        break;
      }
    }
    if (end == xml_.size()) return bad("a tag that does not end");
    if (attributes > kMaxXmlAttributes)
      return bad("more than " + std::to_string(kMaxXmlAttributes) + " attributes");
    if (++elements_ > kMaxXmlElements)
      return bad("more than " + std::to_string(kMaxXmlElements) + " elements");
    if (xml_[end - 1] != '/' && ++depth_ > kMaxXmlDepth)
      return bad("elements nested deeper than " + std::to_string(kMaxXmlDepth));
    return keep(end);
  }

  // Copies the tag that ends at `end`.
  Status keep(std::size_t end) {
    out_.append(xml_.substr(at_, end + 1 - at_));
    at_ = end + 1;
    return {};
  }

  Status bad(const std::string& what) const {
    const auto line = 1 + std::count(xml_.begin(), xml_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    return fail(ErrorCode::kInvalid, "line " + std::to_string(line) + ": " + what);
  }

  std::string_view xml_;
  std::size_t at_ = 0;
  int depth_ = 0, elements_ = 0;
  std::string out_;
};

}  // namespace

Result<std::string> plain_xml(std::string_view xml) {
  return Reducer(xml).run();
}

}  // namespace evograsp::assets
