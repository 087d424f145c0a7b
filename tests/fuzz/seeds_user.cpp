#include <array>
#include <vector>

#include "common/digest.h"
#include "tests/fuzz/seeds.h"

namespace evograsp::fuzz {
namespace {

// What a user writes or is given, small: see files_fuzz.cpp.
void small_files() {
  const std::string a = "Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV{hID",
                    b = "D:)Q[IlAW!ahhC2ac:9*A}h:p?([4%wOTJ%JR%cs";
  const std::string pair = "public-key = " + a + "\nsecret-key = " + b + "\n";
  write("files", "keys", letter(0) + "# a pair\n" + pair);
  write("files", "keys_of_worker", letter(0) + pair + "server-key = " + a + "\n");
  write("files", "allowed", letter(1) + "# workers\n" + a + " node 1\n" + b + "\n");
  write("files", "token", letter(2) + "0123456789abcdef\r\n");
  write("files", "rendezvous", letter(3) + "connect = tcp://node17:40213\nhttp = http://node17:40871\n");
  write("files", "over", letter(3) + "over = the run is finished\n");
  write("files", "camera",
        letter(4) + R"({"fx": 20.5, "fy": 20, "cx": 12, "cy": 9, "units_per_metre": 1000, "invalid": 0,)" +
            R"( "width": 24, "height": 18, "note": "of the lab"})");
}

// The documents of docs/API.md: see answers_fuzz.cpp for the numbers of its commands.
void server_answers() {
  const auto ok = [](const std::string& body) { return letter(0) + piece(body); };
  const std::string run = ok(
      R"({"name": "a", "state": "running", "phase": "evolving", "committed": 1, "generation": 1, "generations": 9,)"
      R"( "fitness": {"best": 1, "mean": 0.5, "best_ever": 1}, "species": {"count": 2, "threshold": 3},)"
      R"( "evaluations": {"done": 1, "total": 2}, "workers": {"active": 1, "slots": 2, "busy": 2,)"
      R"( "slots_wanted": 4}, "trials": 7, "seconds": 2, "trials_per_second": 3.5, "seconds_left": 60,)"
      R"( "champion": {"available": true, "chosen": false}, "folder": "runs/a", "error": ""})");
  const std::string generations = ok(
      R"({"generations": [{"generation": 0, "best": 1, "mean": 0.5, "deviation": 0.1, "species": 2, "links": 9,)"
      R"( "threshold": 3, "trials": 7, "seconds": 2}], "next": null})");
  const std::string workers = ok(
      R"({"workers": [{"identity": "w", "host": "h", "build": "1", "state": "active", "slots": 2, "busy": 2,)"
      R"( "tasks": 1, "trials": 7, "trials_per_second": 3.5, "silent_seconds": 0.5}]})");
  const std::string events =
      ok(R"({"events": [{"time": 1.7e9, "severity": "info", "kind": "resume", "text": "of the run"}]})");
  const std::string axis =
      R"({"measure": "HEIGHT", "words": "height", "unit": "m", "low": 0, "high": 1, "bins": 2})";
  write("answers", "status", letter(0) + run + generations);
  write("answers", "watch", letter(2) + run + generations + workers + events);
  write("answers", "workers", letter(4) + workers);
  write("answers", "generations", letter(5) + run + generations);
  write("answers", "species",
        letter(7) + ok(R"({"generation": 3, "species": [{"id": 1, "size": 2, "age": 3}]})"));
  write("answers", "events_json", letter(9) + events);
  write("answers", "history_csv", letter(11) + generations);
  write("answers", "archive",
        letter(16) + ok(R"({"x": )" + axis + R"(, "y": )" + axis + R"(, "cells": 4, "elites": [)" +
                        R"({"x": 1, "y": 0, "fitness": 1, "judged": 2, "x_value": 0.7}]})"));
  write("answers", "refused",
        letter(19) + letter(7) + piece(R"({"error": {"code": "x", "message": "a token"}})"));
  write("answers", "drained", letter(22) + ok(R"({"workers": 2})"));
  proto::Champion champion;
  *champion.mutable_network() = network_of(2, 1);
  write("answers", "champion", letter(12) + ok(deterministic_bytes(champion)));
}

// Meshes in tenths of millimetres: see decompose_fuzz.cpp.
void small_meshes() {
  const auto settings = [](int kind, int min_parts, int concavity) {
    return letter(kind) + letter(min_parts - 1) + letter(11) + letter(44) + letter(concavity);
  };
  const auto mesh = [](const std::vector<std::array<int, 3>>& vertices, const std::vector<int>& triangles) {
    std::string out = letter(static_cast<int>(vertices.size()) - 3);
    for (const auto& v : vertices)
      for (const int x : v) out += number(static_cast<std::size_t>(x));
    out += letter(static_cast<int>(triangles.size() / 3));
    for (const int i : triangles) out += letter(i);
    return out;
  };
  const std::string tetrahedron =
      mesh({{0, 0, 0}, {500, 0, 0}, {0, 500, 0}, {0, 0, 500}}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
  // An L, extruded: two boxes that share a wall.
  const std::vector<std::array<int, 2>> outline = {{0, 0},     {600, 0},   {600, 200},
                                                   {200, 200}, {200, 600}, {0, 600}};
  std::vector<std::array<int, 3>> vertices;
  for (const int z : {0, 300})
    for (const auto& p : outline) vertices.push_back({p[0], p[1], z});
  std::vector<int> triangles = {0, 3, 1, 1, 3, 2, 0, 5, 3, 3, 5, 4, 6, 7, 9, 7, 8, 9, 6, 9, 11, 9, 10, 11};
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    triangles.insert(triangles.end(), {i, j, j + 6, i, j + 6, i + 6});
  }
  const std::string tie = mesh({{-500, -500, 0}, {400, 400, 0}, {400, -400, 0}, {-500, 500, 0}, {0, 0, 300}},
                               {0, 2, 1, 0, 3, 2, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4});
  const std::string corner = mesh(vertices, triangles);
  write("decompose", "tetrahedron", settings(2, 1, 20) + tetrahedron);
  write("decompose", "tetrahedron_whole", settings(0, 1, 20) + tetrahedron);
  write("decompose", "corner", settings(2, 1, 20) + corner + letter(96) + letter(1));
  write("decompose", "corner_in_three",
        settings(2, 3, 5) + corner + letter(96) + letter(2) + std::string("\0\1\2\0\1\2\0\1\2", 9));
  write("decompose", "corner_whole", settings(0, 1, 20) + corner);
  write("decompose", "tie", settings(0, 1, 20) + tie);
  write("decompose", "flat", settings(0, 1, 20) + mesh({{0, 0, 0}, {500, 0, 0}, {0, 500, 0}}, {0, 1, 2}));
}

}  // namespace

void write_user_seeds() {
  small_files();
  server_answers();
  small_meshes();
}

}  // namespace evograsp::fuzz
