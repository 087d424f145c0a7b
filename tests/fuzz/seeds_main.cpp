// fuzz_seeds FOLDER: writes the corpus of every target to FOLDER/TARGET/, from what ships with the program
// alone.
#include <algorithm>
#include <cstring>

#include "assets/mesh.h"
#include "assets/mesh_import.h"
#include "common/config.h"
#include "common/digest.h"
#include "common/network.h"
#include "common/network_pack.h"
#include "server/store_records.h"
#include "sim/png.h"
#include "tests/fuzz/peer.h"
#include "tests/fuzz/run_db.h"
#include "tests/fuzz/seeds.h"
#include "tests/fuzz/simulate.h"

namespace {

using namespace evograsp;
using namespace evograsp::fuzz;
namespace fs = std::filesystem;

void texts() {
  const fs::path configs = fs::path(EVOGRASP_SOURCE_DIR) / "configs";
  for (const auto& entry : fs::directory_iterator(configs))
    if (entry.path().extension() == ".txtpb") write("config", entry.path().stem(), file(entry.path()));
  for (const auto& entry : fs::directory_iterator(configs / "objects"))
    if (entry.path().extension() == ".txtpb") write("object", entry.path().stem(), file(entry.path()));
  write("object", "box",
        "cuboid { size { x: 0.05 y: 0.04 z: 0.1 } } mass: 0.2 resting_down { x: 0 y: 0 z: -1 }");
  for (const char* hand : {"parallel_jaw", "barrett"}) {
    const std::string urdf = file(configs / "hands" / (std::string(hand) + ".urdf"));
    write("hand", std::string(hand) + "_urdf", urdf);
    std::string text = file(configs / "hands" / (std::string(hand) + ".txtpb"));
    const std::size_t at = text.find(std::string(hand) + ".urdf");
    if (at != text.npos) text.replace(at, std::strlen(hand) + 5, "hand.urdf");
    write("hand", hand, text + "\n%%\n" + urdf);
  }
}

// ---- meshes: a tetrahedron in every format ----

std::string gltf(const std::string& buffer, bool as_text) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{)" +
         (as_text ? "\"uri\":\"data:application/octet-stream;base64," + buffer + "\"," : std::string()) +
         R"("byteLength":72}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},)"
         R"({"buffer":0,"byteOffset":48,"byteLength":24}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,)"
         R"("type":"VEC3","min":[0,0,0],"max":[0.05,0.05,0.05]},)"
         R"({"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]})";
}

template <class T>
void append(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[group >> shift & 63];
  }
  return text;
}

void meshes() {
  const float v[4][3] = {{0, 0, 0}, {0.05f, 0, 0}, {0, 0.05f, 0}, {0, 0, 0.05f}};
  const int f[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  std::string obj = "# tetrahedron\no t\n", ply_rows, stl_text = "solid t\n", stl(80, ' '), binary, indices,
              dae_v, dae_f;
  append(stl, 4u);
  for (const auto& p : v) {
    const std::string row = std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]);
    obj += "v " + row + "\n", ply_rows += row + "\n", dae_v += row + " ";
    for (const float x : p) append(binary, x);
  }
  for (const auto& t : f) {
    stl_text += "facet normal 0 0 0\nouter loop\n", ply_rows += "3", obj += "f", stl.append(12, '\0');
    for (const int i : t) {
      obj += " " + std::to_string(i + 1), ply_rows += " " + std::to_string(i),
          dae_f += std::to_string(i) + " ";
      append(indices, static_cast<std::uint16_t>(i));
      stl_text += "vertex";
      for (const float x : v[i]) append(stl, x), stl_text += " " + std::to_string(x);
      stl_text += "\n";
    }
    stl_text += "endloop\nendfacet\n", ply_rows += "\n", obj += "\n", stl.append(2, '\0');
  }
  const std::string buffer = binary + indices;
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 4\nproperty list uchar int vertex_indices\nend_header\n" +
      ply_rows;
  const std::string dae =
      "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
      "version=\"1.4.1\"><asset>"
      "<unit meter=\"1\"/><up_axis>Z_UP</up_axis></asset><library_geometries><geometry "
      "id=\"g\"><mesh><source id=\"p\">"
      "<float_array id=\"a\" count=\"12\">" +
      dae_v +
      "</float_array><technique_common><accessor source=\"#a\" count=\"4\" "
      "stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" "
      "type=\"float\"/>"
      "</accessor></technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
      "source=\"#p\"/></vertices>"
      "<triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>" +
      dae_f +
      "</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene "
      "id=\"s\"><node>"
      "<instance_geometry "
      "url=\"#g\"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene "
      "url=\"#s\"/></scene></COLLADA>";
  std::string json = gltf("", false);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string glb = "glTF";
  append(glb, 2u);
  append(glb, static_cast<std::uint32_t>(28 + json.size() + buffer.size()));
  append(glb, static_cast<std::uint32_t>(json.size()));
  glb += "JSON" + json;
  append(glb, static_cast<std::uint32_t>(buffer.size()));
  glb += std::string("BIN\0", 4) + buffer;

  const std::pair<const char*, std::string> all[] = {
      {"obj", letter(0) + obj}, {"stl", letter(1) + stl}, {"stl_text", letter(1) + stl_text + "endsolid t\n"},
      {"ply", letter(2) + ply}, {"dae", letter(3) + dae}, {"gltf", letter(4) + gltf(base64(buffer), true)},
      {"glb", letter(5) + glb}};
  for (const auto& [name, bytes] : all) write("mesh", name, bytes);
  const auto mesh = assets::import_mesh_bytes(stl, "t.stl", 1);
  if (mesh) write("mesh", "encoded", letter(6) + assets::encode(*mesh));
}

void images() {
  sim::GreyImage image{24, 18, {}};
  for (int i = 0; i < 24 * 18; ++i)
    image.value.push_back(static_cast<std::uint16_t>(i % 7 == 0 ? 0 : 800 + i));
  write("depth", "png", *sim::encode_png(image));
  std::string pgm = "P5\n# depth\n24 18\n65535\n";
  for (const std::uint16_t value : image.value) {
    pgm += static_cast<char>(value >> 8);
    pgm += static_cast<char>(value & 255);
  }
  write("depth", "pgm", pgm);
}

// ---- evolution ----

void evolution() {
  for (int kind = 0; kind < 3; ++kind) {
    proto::NeatConfig config;
    config.set_population(6);
    config.set_add_node(1);
    if (kind == 1) config.set_recurrent(true);
    if (kind == 2) {
      config.mutable_hyperneat()->set_input_columns(2);
      config.mutable_hyperneat()->set_input_rows(2);
      auto& sheet = *config.mutable_hyperneat()->add_hidden_sheet();
      sheet.set_columns(2);
      sheet.set_rows(2);
    }
    auto population = neat::Population::create(config, kind == 2 ? 8 : 3, kind == 2 ? 7 : 2, 1);
    if (!population) continue;
    for (int g = 0; g < 3; ++g) {
      population->tell(std::vector<double>{1, 2, 3, 4, 5, 6});
    }
    write("population", "kind" + std::to_string(kind), letter(kind) + population->save());
  }
  proto::Champion champion;
  *champion.mutable_network() = network_of(16, 7);
  *champion.mutable_experiment() = fuzz::small_config();
  write("champion", "small", deterministic_bytes(champion));
  champion.mutable_network()->set_recurrent(true);
  write("champion", "recurrent", deterministic_bytes(champion));
}

// ---- the wire ----

std::string envelope(const std::function<void(proto::Envelope&)>& fill, int flags = 3) {
  proto::Envelope e = make_envelope({7, 1});
  fill(e);
  return letter(flags) + piece(e.SerializeAsString());
}

void wire() {
  const auto hello = [](const char* name) {
    return envelope([&](proto::Envelope& e) {
      e.mutable_hello()->set_identity(name);
      e.mutable_hello()->set_host("h");
      e.mutable_hello()->set_slots(2);
      e.mutable_hello()->set_pid(1);
    });
  };
  const std::string ready = envelope([](proto::Envelope& e) { e.mutable_ready(); });
  const std::string started = envelope([](proto::Envelope& e) { e.mutable_started()->set_id(0); });
  const std::string result = envelope([](proto::Envelope& e) { e.mutable_result()->set_id(0); });
  const std::string failed = envelope([](proto::Envelope& e) {
    e.mutable_result()->set_id(0);
    e.mutable_result()->set_error("cannot");
  });
  const std::string heartbeat = envelope([](proto::Envelope& e) { e.mutable_heartbeat()->set_sequence(1); });
  const std::string goodbye = envelope([](proto::Envelope& e) { e.mutable_goodbye()->add_unfinished(1); });
  const std::string drain = envelope([](proto::Envelope& e) { e.mutable_drain(); });
  const std::string asset = envelope([](proto::Envelope& e) { e.mutable_asset_request()->set_id("a"); });
  const std::string client = envelope([](proto::Envelope& e) { e.mutable_hello()->set_stepwise(true); });
  const std::string step =
      envelope([](proto::Envelope& e) { e.mutable_step_request()->mutable_shuffle()->set_seed(1); });
  const std::string reply = envelope([](proto::Envelope& e) {
    e.mutable_step_reply()->set_client(1);
    e.mutable_step_reply()->mutable_placements();
  });
  const std::string p0 = letter(0), p1 = letter(1), p2 = letter(2), tick = letter(0xf5);
  std::string work = p0 + hello("a") + p0 + asset + p0 + ready;
  write("master", "join", work);
  for (int i = 0; i < 8; ++i) work += p0 + started + p0 + result + tick;
  write("master", "work", work + letter(0xf0) + p0 + result + p0 + heartbeat + p0 + goodbye);
  write("master", "fail",
        p0 + hello("a") + p0 + ready + p1 + hello("b") + p1 + ready + p0 + failed + p1 + failed + p0 +
            failed + p1 + failed + letter(0xf4) + letter(0) + p0 + hello("a") + tick);
  write("master", "same_name", p0 + hello("a") + p1 + hello("a") + p2 + hello("a") + p0 + drain + p1 + ready);
  write("master", "steps",
        p0 + hello("a") + p0 + ready + p1 + client + p1 + step + p0 + reply + p1 + step + p0 + goodbye);
  write("master", "garbage", p0 + letter(0) + piece("garbage") + p0 + letter(12) + piece("") + piece("x"));
}

void master_to_worker() {
  const auto say = [](const std::function<void(proto::Envelope&)>& fill, int bodies = 0,
                      const std::string& body = "") {
    std::string text = letter(0) + envelope(fill, 3 | bodies << 2);
    for (int i = 0; i < bodies; ++i) text += piece(body);
    return text;
  };
  const std::string welcome = say([](proto::Envelope& e) { e.mutable_welcome()->set_silence_seconds(100); });
  const std::string task = say(
      [](proto::Envelope& e) {
        e.mutable_task()->set_id(1);
        e.mutable_task()->add_network(1);
        e.mutable_task()->add_trial();
        e.mutable_task()->set_trials(1);
      },
      1, "network");
  const std::string cancel = say([](proto::Envelope& e) { e.mutable_cancel()->add_id(1); });
  const std::string cancel_all = say([](proto::Envelope& e) { e.mutable_cancel(); });
  const std::string heartbeat = say([](proto::Envelope& e) { e.mutable_heartbeat()->set_sequence(1); });
  const std::string drain = say([](proto::Envelope& e) { e.mutable_drain()->set_reason("done"); });
  const std::string refusal = say([](proto::Envelope& e) { e.mutable_refusal()->set_retry(true); });
  write("worker", "noop", welcome + task + heartbeat + cancel + task + cancel_all + drain);
  write("worker", "refused", refusal);
  write("worker", "order", welcome + task + letter(15) + letter(1) + envelope([](proto::Envelope& e) {
                             e.mutable_heartbeat();
                           }));
  const auto& built_in = fuzz::small_experiment();
  const std::string loading = say([&](proto::Envelope& e) {
    *e.mutable_welcome()->mutable_experiment() = built_in.experiment;
    e.mutable_welcome()->set_silence_seconds(100);
  });
  const std::string reply = say(
      [&](proto::Envelope& e) {
        e.mutable_asset_reply()->set_id(built_in.experiment.hand_id());
        e.mutable_asset_reply()->set_found(true);
      },
      1, assets::pack_bundle(built_in.hand));
  const std::string object = say(
      [&](proto::Envelope& e) {
        e.mutable_asset_reply()->set_id(built_in.experiment.object_id(0));
        e.mutable_asset_reply()->set_found(true);
      },
      1, assets::pack_bundle(built_in.objects[0]));
  write("worker", "assets", loading + reply + object + heartbeat);
}

void slots() {
  proto::Task task;
  task.set_id(1);
  task.add_network(1);
  task.add_trial()->set_seed(1);
  task.add_trial()->set_seed(2);
  write("task", "trials",
        letter(1) + piece(task.SerializeAsString()) + piece(pack_network(network_of(16, 7))));
  task.set_noop_seconds(0);
  write("task", "noop", letter(3) + piece(task.SerializeAsString()) + piece(""));
  proto::StepRequest request;
  request.set_seed(1);
  request.mutable_get_quality()->mutable_pose();
  write("task", "quality", letter(0) + piece(request.SerializeAsString()));
  request.mutable_get_info()->set_target(0);
  write("task", "info", letter(0) + piece(request.SerializeAsString()));
  request.mutable_shuffle()->set_seed(1);
  write("task", "shuffle", letter(0) + piece(request.SerializeAsString()));
}

void bundles() {
  const auto& built_in = fuzz::small_experiment();
  write("bundle", "object", piece(deterministic_bytes(built_in.objects[0])) + piece("") + piece(""));
  write("bundle", "hand", piece("") + piece(deterministic_bytes(built_in.hand)) + piece(""));
  proto::Experiment change;
  change.mutable_camera()->set_fx(400);
  change.mutable_scene()->set_size_jitter(0.1);
  change.mutable_grasp()->set_cone_edges(4);
  write("bundle", "experiment", piece("") + piece("") + piece(change.SerializeAsString()));
  const auto sphere = assets::load_object("sphere", {});
  if (sphere) write("bundle", "sphere", piece(deterministic_bytes(sphere->bundle)) + piece("") + piece(""));
  const auto mug = assets::load_object("cylinder", {});
  if (mug) write("bundle", "cylinder", piece(deterministic_bytes(mug->bundle)) + piece("") + piece(""));
}

void runs() {
  write("run_db", "flip", letter(1) + std::string("\x00\x20\x00\x55", 4));
  write("run_db", "truncated", letter(0) + std::string("SQLite format 3\0", 16) + std::string(84, '\0'));
  proto::Measurement measurement;
  const std::string best = network_of(2, 1).SerializeAsString();
  const std::string population = fuzz::small_population();
  write("run_db", "sealed",
        letter(2) + piece("") + piece("") + piece(population) + piece("") + piece(best) + piece(population) +
            piece(server::pack_measurements({&measurement, 1})) + piece("text"));
  proto::Config config = fuzz::small_run_config();
  config.mutable_neat()->set_population(2);
  write("run_db", "config", letter(2) + piece(config.SerializeAsString()) + piece(""));
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds FOLDER\n");
    return 2;
  }
  seeds_folder() = arguments[1];
  texts();
  meshes();
  images();
  evolution();
  wire();
  master_to_worker();
  slots();
  bundles();
  runs();
  write_user_seeds();
  return 0;
}
