// What makers of corpora share: files of a folder, and inputs as fuzz::Pieces takes them apart.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "neat/population.h"

namespace evograsp::fuzz {

// Given on the command line; inputs go to its folder of the target's name.
inline std::filesystem::path& seeds_folder() {
  static std::filesystem::path folder;
  return folder;
}

inline void write(const std::string& target, const std::string& name, const std::string& bytes) {
  std::filesystem::create_directories(seeds_folder() / target);
  std::ofstream(seeds_folder() / target / name, std::ios::binary) << bytes;
}

inline std::string file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string((std::istreambuf_iterator<char>(in)), {});
}

// As fuzz::Pieces reads them.
inline std::string number(std::size_t value) {
  return {static_cast<char>(value & 255), static_cast<char>(value >> 8 & 255)};
}
inline std::string piece(const std::string& bytes) {
  return number(bytes.size()) + bytes;
}
inline std::string letter(int value) {
  return std::string(1, static_cast<char>(value));
}

inline proto::Network network_of(int inputs, int outputs) {
  proto::NeatConfig config;
  config.set_population(2);
  const auto population = neat::Population::create(config, inputs, outputs, 1);
  return neat::express_proto(population->ask()[0], config);
}

// What users and those they talk to hand to the command line: seeds_user.cpp.
void write_user_seeds();

}  // namespace evograsp::fuzz
