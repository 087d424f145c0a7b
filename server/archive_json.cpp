#include "server/archive_json.h"

#include <algorithm>

#include "common/digest.h"
#include "score/grasp_measure.h"

namespace evograsp::server {
namespace {

using nlohmann::json;

struct Map {
  RunInfo info;
  std::vector<EliteRecord> elites;
};

Result<Map> read(StoreReader& reader) {
  auto info = reader.run();
  if (!info) return tl::unexpected<Error>(info.error());
  if (!info->config.neat().has_archive())
    return fail(ErrorCode::kNotFound,
                "this run keeps no map of grasps; a run with one: evograsp train --set neat.archive={}");
  auto elites = reader.elites();
  if (!elites) return tl::unexpected<Error>(elites.error());
  return Map{std::move(*info), std::move(*elites)};
}

json axis_json(const proto::ArchiveAxis& axis) {
  const score::MeasureRange range = score::range_of(axis);
  return {{"measure", proto::GraspMeasure_Name(axis.of())},
          {"words", score::words_of(axis.of())},
          {"unit", score::is_angle(axis.of()) ? "degrees" : "m"},
          {"bins", axis.bins()},
          {"low", range.low},
          {"high", range.high}};
}

json elite_json(const EliteRecord& e) {
  return {{"x", e.x},
          {"y", e.y},
          {"x_value", e.x_value},
          {"y_value", e.y_value},
          {"fitness", e.fitness},
          {"judged", e.judged},
          {"genome", e.genome},
          {"generation", e.generation},
          {"updated", e.updated}};
}

}  // namespace

Result<json> archive_json(StoreReader& reader) {
  const auto map = read(reader);
  if (!map) return tl::unexpected<Error>(map.error());
  const proto::ArchiveConfig& config = map->info.config.neat().archive();
  json elites = json::array();
  for (const EliteRecord& e : map->elites) elites.push_back(elite_json(e));
  return json{{"kind", proto::ArchiveKind_Name(config.kind())},
              {"x", axis_json(config.x())},
              {"y", axis_json(config.y())},
              {"cells", config.x().bins() * config.y().bins()},
              {"elites", std::move(elites)}};
}

Result<std::string> elite_of(StoreReader& reader, std::uint32_t x, std::uint32_t y) {
  const auto map = read(reader);
  if (!map) return tl::unexpected<Error>(map.error());
  const auto found = std::find_if(map->elites.begin(), map->elites.end(),
                                  [&](const EliteRecord& e) { return e.x == x && e.y == y; });
  if (found == map->elites.end())
    return fail(ErrorCode::kNotFound, "cell " + std::to_string(x) + "," + std::to_string(y) +
                                          " of the map is empty; see evograsp archive");
  const BestRecord best{found->generation, found->genome, found->fitness, found->genotype, found->network};
  const auto champion =
      make_champion(map->info.config, map->info.experiment.fingerprint(), best, std::nullopt);
  if (!champion) return tl::unexpected<Error>(champion.error());
  return deterministic_bytes(*champion);
}

}  // namespace evograsp::server
