#include "assets/ply.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "assets/mesh_import.h"
#include "assets/polygon.h"

namespace evograsp::assets {
namespace {

constexpr std::size_t kMaxProperties = 1000;

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
enum class Format { kAscii, kLittle, kBig };

struct Property {
  std::string name;
  Type type = Type::kFloat;
  std::optional<Type> length;  // of a list: the type of its length
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Format format = Format::kAscii;
  std::vector<Element> elements;
};

tl::unexpected<Error> refuse(const std::string& why) {
  return fail(ErrorCode::kInvalid, why);
}

std::optional<Type> type_named(std::string_view name) {
  struct Names {
    std::string_view old, exact;
    Type type;
  };
  static constexpr Names kNames[] = {
      {"char", "int8", Type::kInt8},      {"uchar", "uint8", Type::kUint8},
      {"short", "int16", Type::kInt16},   {"ushort", "uint16", Type::kUint16},
      {"int", "int32", Type::kInt32},     {"uint", "uint32", Type::kUint32},
      {"float", "float32", Type::kFloat}, {"double", "float64", Type::kDouble},
  };
  for (const Names& n : kNames) {
    if (name == n.old || name == n.exact) return n.type;
  }
  return {};
}

std::size_t size_of(Type type) {
  static constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<int>(type)];
}

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const auto first = std::find_if_not(line.begin(), line.end(), is_space);
    line.remove_prefix(static_cast<std::size_t>(first - line.begin()));
    if (line.empty()) return words;
    const auto end =
        static_cast<std::size_t>(std::find_if(line.begin(), line.end(), is_space) - line.begin());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

// Takes the first line, which ends with LF, CR LF or CR; nothing when no line ends.
std::optional<std::string_view> take_line(std::string_view& bytes) {
  const std::size_t end = bytes.find_first_of("\r\n");
  if (end == std::string_view::npos) return {};
  const std::string_view line = bytes.substr(0, end);
  const bool two = bytes[end] == '\r' && end + 1 < bytes.size() && bytes[end + 1] == '\n';
  bytes.remove_prefix(end + (two ? 2 : 1));
  return line;
}

using Words = std::vector<std::string_view>;

Status add_element(const Words& words, Header& header) {
  Element element;
  if (words.size() != 3) return refuse("an element line needs a name and a count");
  element.name = words[1];
  const auto [end, error] =
      std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
  if (error != std::errc() || end != words[2].data() + words[2].size())
    return refuse("'" + std::string(words[2]) + "' is no count");
  if (element.name == "vertex" && element.count > kMaxMeshVertices)
    return refuse("more than " + std::to_string(kMaxMeshVertices) + " vertices");
  if (element.name == "face" && element.count > kMaxMeshTriangles)
    return refuse("more than " + std::to_string(kMaxMeshTriangles) + " triangles");
  header.elements.push_back(std::move(element));
  return {};
}

Status add_property(const Words& words, Header& header) {
  if (header.elements.empty()) return refuse("a property before any element");
  const bool list = words.size() == 5 && words[1] == "list";
  if (!list && words.size() != 3) return refuse("a property line needs a type and a name");
  Property property;
  property.name = words.back();
  const auto type = type_named(words[list ? 3 : 1]);
  if (list) property.length = type_named(words[2]);
  if (!type || (list && !property.length))
    return refuse("property '" + property.name + "' has an unknown type");
  property.type = *type;
  header.elements.back().properties.push_back(std::move(property));
  if (header.elements.back().properties.size() > kMaxProperties) return refuse("too many properties");
  return {};
}

Status add_format(const Words& words, Header& header) {
  const std::string_view name = words.size() > 1 ? words[1] : "";
  if (name == "ascii") {
    header.format = Format::kAscii;
  } else if (name == "binary_little_endian") {
    header.format = Format::kLittle;
  } else if (name == "binary_big_endian") {
    header.format = Format::kBig;
  } else {
    return refuse("unknown format '" + std::string(name) + "'");
  }
  return {};
}

// Takes the header off `bytes`.
Result<Header> take_header(std::string_view& bytes) {
  if (const auto first = take_line(bytes); !first || words_of(*first) != Words{"ply"})
    return refuse("no PLY file: its first line is not 'ply'");
  Header header;
  while (true) {
    const auto line = take_line(bytes);
    if (!line) return refuse("cut short: its header does not end");
    const Words words = words_of(*line);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") return header;
    Status ok;
    if (words[0] == "format") {
      ok = add_format(words, header);
    } else if (words[0] == "element") {
      ok = add_element(words, header);
    } else if (words[0] == "property") {
      ok = add_property(words, header);
    } else {
      ok = refuse("unknown header line '" + std::string(words[0]).substr(0, 40) + "'");
    }
    if (!ok) return tl::unexpected(ok.error());
    if (header.elements.size() > kMaxProperties) return refuse("too many elements");
  }
}

// The numbers of the body, one after the other.
class Numbers {
 public:
  enum class State { kGood, kEnd, kNoNumber };

  Numbers(std::string_view bytes, Format format) : bytes_(bytes), format_(format) {}

  State next(Type type, double& value) {
    return format_ == Format::kAscii ? text(value) : binary(type, value);
  }

 private:
  State text(double& value) {
    while (at_ < bytes_.size() && is_space(bytes_[at_])) ++at_;
    std::size_t end = at_;
    while (end < bytes_.size() && !is_space(bytes_[end])) ++end;
    if (at_ == end) return State::kEnd;
    const char* first = bytes_.data() + at_ + (bytes_[at_] == '+' ? 1 : 0);
    const char* last = bytes_.data() + end;
    const auto [stop, error] = std::from_chars(first, last, value);
    at_ = end;
    if (error == std::errc::result_out_of_range) value = HUGE_VAL;
    if (stop == last && error != std::errc::invalid_argument) return State::kGood;
    return end == bytes_.size() ? State::kEnd : State::kNoNumber;  // the rest of a number
  }

  State binary(Type type, double& value) {
    const std::size_t size = size_of(type);
    if (bytes_.size() - at_ < size) return State::kEnd;
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t k = format_ == Format::kBig ? i : size - 1 - i;
      bits = bits << 8 | static_cast<unsigned char>(bytes_[at_ + k]);
    }
    at_ += size;
    switch (type) {
      case Type::kInt8:
        value = static_cast<std::int8_t>(bits);
        break;
      case Type::kInt16:
        value = static_cast<std::int16_t>(bits);
        break;
      case Type::kInt32:
        value = static_cast<std::int32_t>(bits);
        break;
      case Type::kFloat:
        value = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
        break;
      case Type::kDouble:
        value = std::bit_cast<double>(bits);
        break;
      default:
        value = static_cast<double>(bits);
    }
    return State::kGood;
  }

  std::string_view bytes_;
  Format format_;
  std::size_t at_ = 0;
};

class Body {
 public:
  Body(std::string_view bytes, Format format) : numbers_(bytes, format) {}

  Status read(const Element& element) {
    if (element.properties.empty()) return {};
    for (row_ = 0; row_ < element.count; ++row_) {
      Vec3 vertex = Vec3::Zero();
      for (const Property& property : element.properties) {
        if (const Status ok = read(element, property, vertex); !ok) return ok;
      }
      if (element.name == "vertex") mesh_.vertices.push_back(vertex);
    }
    return {};
  }

  // The polygons become triangles when every vertex is known.
  Result<Mesh> finish() {
    std::size_t first = 0, face = 0;
    for (const std::size_t end : ends_) {
      ++face;
      const std::span<const std::uint32_t> corners(corners_.data() + first, end - first);
      first = end;
      for (const std::uint32_t v : corners) {
        if (v >= mesh_.vertices.size()) {
          return refuse("face " + std::to_string(face) + " names vertex " + std::to_string(v) + " of " +
                        std::to_string(mesh_.vertices.size()));
        }
      }
      if (corners.size() < 3) continue;
      if (mesh_.triangles.size() + corners.size() - 2 > kMaxMeshTriangles)
        return refuse("more than " + std::to_string(kMaxMeshTriangles) + " triangles");
      add_polygon(corners, mesh_);
    }
    return std::move(mesh_);
  }

 private:
  Status number(const Element& element, Type type, double& value) {
    switch (numbers_.next(type, value)) {
      case Numbers::State::kGood:
        return {};
      case Numbers::State::kEnd:
        return refuse("cut short: its header announces " + std::to_string(element.count) + " of '" +
                      element.name + "', only " + std::to_string(row_) + " are there");
      case Numbers::State::kNoNumber:
        break;
    }
    return refuse("'" + element.name + "' " + std::to_string(row_ + 1) +
                  " holds something that is no number");
  }

  Status read(const Element& element, const Property& property, Vec3& vertex) {
    double value = 0;
    if (property.length) return read_list(element, property);
    if (const Status ok = number(element, property.type, value); !ok) return ok;
    if (element.name != "vertex" || property.name.size() != 1) return {};
    const int axis = property.name[0] - 'x';
    if (axis >= 0 && axis < 3) vertex[axis] = value;
    return {};
  }

  Status read_list(const Element& element, const Property& property) {
    const bool face =
        element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
    double length = 0;
    if (const Status ok = number(element, *property.length, length); !ok) return ok;
    const std::string where = element.name + " " + std::to_string(row_ + 1);
    if (!(length >= 0) || length != std::floor(length))
      return refuse(where + " has a list of no whole length");
    if (face && length > kMaxCorners)
      return refuse(where + " has more than " + std::to_string(kMaxCorners) + " corners");
    for (double i = 0; i < length; ++i) {
      double value = 0;
      if (const Status ok = number(element, property.type, value); !ok) return ok;
      if (!face) continue;
      if (!(value >= 0 && value < 4294967296.0) || value != std::floor(value))
        return refuse(where + " has a corner that is no index");
      corners_.push_back(static_cast<std::uint32_t>(value));
    }
    if (face) ends_.push_back(corners_.size());
    return {};
  }

  Numbers numbers_;
  std::uint64_t row_ = 0;
  Mesh mesh_;
  std::vector<std::uint32_t> corners_;  // of all polygons, one after the other
  std::vector<std::size_t> ends_;       // where each ends among them
};

bool has_position(const Element& vertex) {
  int axes = 0;
  for (const Property& p : vertex.properties)
    axes += !p.length && (p.name == "x" || p.name == "y" || p.name == "z") ? 1 : 0;
  return axes == 3;
}

}  // namespace

Result<Mesh> read_ply(std::string_view bytes) {
  Result<Header> header = take_header(bytes);
  if (!header) return tl::unexpected(header.error());
  Body body(bytes, header->format);
  for (const Element& element : header->elements) {
    if (element.name == "vertex" && !has_position(element)) return refuse("its vertices have no x, y and z");
    if (const Status ok = body.read(element); !ok) return tl::unexpected(ok.error());
  }
  return body.finish();
}

}  // namespace evograsp::assets
