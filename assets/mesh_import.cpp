#include "assets/mesh_import.h"

#include <assimp/BaseImporter.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <memory>
#include <set>
#include <vector>

#include "assets/contained.h"
#include "assets/mesh_mend.h"
#include "assets/ply.h"
#include "assets/text.h"

namespace evograsp::assets {
namespace {

namespace fs = std::filesystem;
constexpr const char* kFormats[] = {"obj", "stl", "ply", "dae", "gltf", "glb"};
constexpr int kMaxNodes = 100'000;
constexpr double kWeld = 1e-7;           // m
constexpr double kBytesPerSecond = 2e6;  // what a reader must manage

std::string extension_of(const fs::path& path) {
  std::string e = path.extension().string();
  if (!e.empty()) e.erase(0, 1);
  for (char& c : e) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return e;
}

// All that assimp may see: the file itself, from memory, and *.bin files beside it.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(std::string_view bytes, std::string name, fs::path folder)
      : bytes_(bytes), name_(std::move(name)), folder_(std::move(folder)) {}

  bool Exists(const char* file) const override { return is_main(file) || !companion(file).empty(); }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (std::string_view(mode).find('w') != std::string_view::npos) return nullptr;
    if (is_main(file)) return stream(bytes_);
    const fs::path path = companion(file);
    if (path.empty()) return nullptr;
    Result<std::string> read = read_file(path, kMaxMeshFile);
    if (!read) return nullptr;
    held_.push_back(std::make_unique<std::string>(std::move(*read)));
    return stream(*held_.back());
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  static Assimp::IOStream* stream(std::string_view bytes) {
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  bool is_main(const char* file) const { return name_ == file; }
  fs::path companion(const char* file) const {
    const fs::path name = fs::path(file).filename();
    const bool plain = name == fs::path(file) || "./" + name.string() == file;
    if (!plain || folder_.empty() || extension_of(name) != "bin") return {};
    std::error_code error;
    const fs::path path = folder_ / name;
    return fs::is_regular_file(fs::symlink_status(path, error)) ? path : fs::path();
  }

  std::string_view bytes_;
  std::string name_;
  fs::path folder_;
  std::vector<std::unique_ptr<std::string>> held_;
};

// Assimp guesses formats by content too: leave it only those that are promised.
void keep_formats(Assimp::Importer& importer) {
  std::vector<Assimp::BaseImporter*> unwanted;
  for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
    std::set<std::string> extensions;
    importer.GetImporter(i)->GetExtensionList(extensions);
    const bool keep = std::any_of(std::begin(kFormats), std::end(kFormats),
                                  [&](const char* format) { return extensions.count(format) > 0; });
    if (!keep) unwanted.push_back(importer.GetImporter(i));
  }
  for (Assimp::BaseImporter* loader : unwanted) importer.UnregisterLoader(loader);
}

// Adds a node's meshes; false when a bound is passed.
bool add_meshes(const aiScene& scene, const aiNode& node, const aiMatrix4x4& X, Mesh& out) {
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    if (out.vertices.size() + mesh.mNumVertices > kMaxMeshVertices) return false;
    if (out.triangles.size() + mesh.mNumFaces > kMaxMeshTriangles) return false;
    const auto base = static_cast<std::uint32_t>(out.vertices.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D p = X * mesh.mVertices[v];
      out.vertices.emplace_back(p.x, p.y, p.z);
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      const unsigned* i = face.mIndices;
      if (std::max({i[0], i[1], i[2]}) >= mesh.mNumVertices) continue;
      out.triangles.push_back({base + i[0], base + i[1], base + i[2]});
    }
  }
  return true;
}

Result<Mesh> flatten(const aiScene& scene) {
  Mesh out;
  std::vector<std::pair<const aiNode*, aiMatrix4x4>> stack{{scene.mRootNode, aiMatrix4x4()}};
  for (int visited = 0; !stack.empty(); ++visited) {
    if (visited > kMaxNodes)
      return fail(ErrorCode::kInvalid, "more than " + std::to_string(kMaxNodes) + " nodes");
    const auto [node, parent] = stack.back();
    stack.pop_back();
    const aiMatrix4x4 X = parent * node->mTransformation;
    if (!add_meshes(scene, *node, X, out)) {
      return fail(ErrorCode::kInvalid, "more than " + std::to_string(kMaxMeshVertices) + " vertices or " +
                                           std::to_string(kMaxMeshTriangles) + " triangles");
    }
    for (unsigned c = node->mNumChildren; c > 0; --c) stack.emplace_back(node->mChildren[c - 1], X);
  }
  return out;
}

// Assimp hands the text of any exception on.
std::string in_words(const std::string& why) {
  if (why.empty()) return "not a readable mesh";
  if (why.find("std::bad_alloc") != std::string::npos) return "needs more memory than allowed";
  return "not a readable mesh: " + why;
}

Result<Mesh> read_by_assimp(std::string_view bytes, const std::string& extension, const fs::path& folder) {
  const Result<std::string> good = mended(bytes, extension);
  if (!good) return tl::unexpected(good.error());
  Assimp::Importer importer;
  keep_formats(importer);
  const std::string name = "mesh." + extension;
  importer.SetIOHandler(new OneFile(*good, name, folder));
  const aiScene* scene = importer.ReadFile(name, aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr)
    return fail(ErrorCode::kInvalid, in_words(importer.GetErrorString()));
  return flatten(*scene);
}

// In the child: the file's triangles as an encoded mesh.
Result<std::string> parse(std::string_view bytes, const std::string& extension, const fs::path& folder) {
  const Result<Mesh> mesh = extension == "ply" ? read_ply(bytes) : read_by_assimp(bytes, extension, folder);
  if (!mesh) return tl::unexpected(mesh.error());
  return encode(*mesh);
}

std::string sizes(const Vec3& extent) {
  char text[96];
  std::snprintf(text, sizeof text, "%.4g x %.4g x %.4g m", extent.x(), extent.y(), extent.z());
  return text;
}

// Scale, up axis and every check that needs no library.
Status clean(Mesh& mesh, const std::string& extension, double scale) {
  if (mesh.triangles.empty()) return fail(ErrorCode::kInvalid, "no triangles in it");
  const bool y_up = extension == "dae" || extension == "gltf" || extension == "glb";
  for (Vec3& v : mesh.vertices) {
    if (y_up) v = Vec3(v.x(), -v.z(), v.y());
    v *= scale;
  }
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) {
      if (!is_finite(mesh.vertices[v])) return fail(ErrorCode::kInvalid, "a vertex is not finite");
    }
  }
  for (Vec3& v : mesh.vertices) {
    if (!is_finite(v)) v = Vec3::Zero();  // used by no triangle
  }
  weld(mesh, kWeld);
  if (mesh.triangles.empty()) return fail(ErrorCode::kInvalid, "no triangle has an area (scale?)");
  const Vec3 extent = bounds_of(mesh).extent();
  if (extent.maxCoeff() < kMinMeshSize || extent.maxCoeff() > kMaxMeshSize) {
    const bool big = extent.maxCoeff() > kMaxMeshSize;
    return fail(ErrorCode::kInvalid,
                sizes(extent) + (big ? ": too big to grasp" : ": too small to grasp") +
                    " (the longest side must be within 2 mm and 2 m); is it in other units? "
                    "Set scale, e.g. 0.001 for millimetres");
  }
  orient_outward(mesh);
  return {};
}

Result<Mesh> import_from(std::string_view bytes, const std::string& name, const fs::path& folder,
                         double scale) {
  const auto named = [&](const Error& e) { return fail(e.code, name + ": " + e.message); };
  const std::string extension = extension_of(name);
  if (!is_mesh_file(name))
    return named({ErrorCode::kInvalid, "not a mesh format (obj, stl, ply, dae, gltf, glb)"});
  if (!(scale > 0) || !std::isfinite(scale)) return named({ErrorCode::kInvalid, "scale must be above 0"});
  if (bytes.empty()) return named({ErrorCode::kInvalid, "the file is empty"});
  Containment limits;  // assimp reads tens of megabytes a second, unless damage sends it round in circles
  limits.seconds = 1 + static_cast<double>(bytes.size()) / kBytesPerSecond;
  const Result<std::string> encoded = run_contained([&] { return parse(bytes, extension, folder); }, limits);
  if (!encoded) return named(encoded.error());
  Result<Mesh> mesh = decode(*encoded);
  if (!mesh) return named(mesh.error());
  if (const Status ok = clean(*mesh, extension, scale); !ok) return named(ok.error());
  return mesh;
}

}  // namespace

bool is_mesh_file(const fs::path& path) {
  const std::string extension = extension_of(path);
  return std::any_of(std::begin(kFormats), std::end(kFormats), [&](const char* f) { return extension == f; });
}

Result<Mesh> import_mesh(const fs::path& path, double scale) {
  if (!is_mesh_file(path)) return import_from("", path.string(), {}, scale);
  const Result<std::string> bytes = read_file(path, kMaxMeshFile);
  if (!bytes) return tl::unexpected(bytes.error());
  return import_from(*bytes, path.string(), fs::absolute(path).parent_path(), scale);
}

Result<Mesh> import_mesh_bytes(std::string_view bytes, const std::string& name, double scale) {
  return import_from(bytes, name, {}, scale);
}

}  // namespace evograsp::assets
