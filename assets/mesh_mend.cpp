#include "assets/mesh_mend.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

namespace evograsp::assets {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;
constexpr std::size_t kGlbHeader = 20;  // the file's and the first chunk's

tl::unexpected<Error> refuse(const std::string& why) {
  return fail(ErrorCode::kInvalid, why);
}

std::uint32_t little32(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

std::size_t words_in(std::string_view line) {
  std::size_t words = 0;
  for (std::size_t i = 0; i < line.size(); ++i)
    words += !is_blank(line[i]) && (i == 0 || is_blank(line[i - 1]));
  return words;
}

// A whole face without a line's end behind it is a face: only a remainder gives itself away.
Status check_last_face(std::string_view text) {
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  const std::size_t end = text.find_last_of('\n');
  const std::string_view line = end == std::string_view::npos ? text : text.substr(end + 1);
  const std::size_t words = words_in(line);
  if (line.starts_with("f") && (line.size() == 1 || is_blank(line[1])) && words < 4)
    return refuse("cut short: its last face has " + std::to_string(words - 1) + " corners");
  return {};
}

Result<std::string> mended_obj(std::string_view text) {
  if (const Status ok = check_last_face(text); !ok) return tl::unexpected(ok.error());
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool opens = i > 0 && (is_blank(text[i - 1]) || text[i - 1] == '-' || text[i - 1] == '+');
    if (text[i] == '.' && opens && i + 1 < text.size() && is_digit(text[i + 1])) out.push_back('0');
    out.push_back(text[i]);
  }
  return out;
}

bool is_ascii_stl(std::string_view bytes) {
  const std::string_view first = bytes.substr(0, kStlHeader + kStlTriangle);
  return bytes.starts_with("solid") && first.find('\0') == std::string_view::npos;
}

Result<std::string> mended_stl(std::string_view bytes) {
  if (is_ascii_stl(bytes)) {
    if (bytes.find("endsolid") == std::string_view::npos) return refuse("cut short: no 'endsolid' ends it");
    return std::string(bytes);
  }
  if (bytes.size() < kStlHeader) return refuse("cut short: a binary STL begins with 84 bytes");
  const std::size_t count = little32(bytes, kStlHeader - 4);
  const std::size_t whole = kStlHeader + kStlTriangle * count;
  if (bytes.size() < whole) {
    return refuse("cut short: its header announces " + std::to_string(count) + " triangles, only " +
                  std::to_string((bytes.size() - kStlHeader) / kStlTriangle) + " are there");
  }
  return std::string(bytes.substr(0, whole));
}

bool is_index(const Json& value, std::size_t count) {
  return value.is_number_unsigned() && value.get<std::uint64_t>() < count;
}

// An empty list where there is none.
const Json& list_in(const Json& object, const char* key) {
  static const Json kNone = Json::array();
  const auto found = object.is_object() ? object.find(key) : object.end();
  return found != object.end() && found->is_array() ? *found : kNone;
}

Status check_nodes(const Json& gltf) {
  const Json& nodes = list_in(gltf, "nodes");
  std::vector<bool> has_parent(nodes.size());
  for (const Json& node : nodes) {
    for (const Json& child : list_in(node, "children")) {
      if (!is_index(child, nodes.size())) return refuse("a node's child does not exist");
      const auto c = child.get<std::size_t>();
      if (has_parent[c])
        return refuse("node " + std::to_string(c) + " has two parents: glTF nodes are trees");
      has_parent[c] = true;
    }
  }
  for (const Json& scene : list_in(gltf, "scenes")) {
    for (const Json& root : list_in(scene, "nodes")) {
      if (!is_index(root, nodes.size())) return refuse("a scene's node does not exist");
      if (has_parent[root.get<std::size_t>()])
        return refuse("node " + root.dump() + " is a scene's root and another's child: glTF nodes are trees");
    }
  }
  return {};
}

Status check_gltf(std::string_view text) {
  const Json gltf = Json::parse(text, nullptr, false);
  if (gltf.is_discarded()) return refuse("not JSON: cut short or damaged");
  return check_nodes(gltf);
}

Status check_glb(std::string_view bytes) {
  if (!bytes.starts_with("glTF")) return refuse("no GLB file: it does not begin with 'glTF'");
  if (bytes.size() < kGlbHeader) return refuse("cut short: a GLB begins with 20 bytes");
  const std::size_t whole = little32(bytes, 8), json = little32(bytes, 12);
  if (bytes.size() < whole || bytes.size() - kGlbHeader < json) {
    return refuse("cut short: its header announces " + std::to_string(std::max(whole, kGlbHeader + json)) +
                  " bytes, only " + std::to_string(bytes.size()) + " are there");
  }
  return check_gltf(bytes.substr(kGlbHeader, json));
}

}  // namespace

Result<std::string> mended(std::string_view bytes, const std::string& extension) {
  if (extension == "obj") return mended_obj(bytes);
  if (extension == "stl") return mended_stl(bytes);
  Status ok;
  if (extension == "gltf") ok = check_gltf(bytes);
  if (extension == "glb") ok = check_glb(bytes);
  if (!ok) return tl::unexpected(ok.error());
  return std::string(bytes);
}

}  // namespace evograsp::assets
