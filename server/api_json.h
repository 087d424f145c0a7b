// The documents of the HTTP API (docs/API.md), made from a living run's snapshot or from run.db: `evograsp
// status` shows the same for a server and for a run folder.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/result.h"
#include "server/run_control.h"
#include "server/store_reader.h"

namespace evograsp::server {

const char* to_string(RunState state);

nlohmann::json run_json(const RunSnapshot& snapshot);
nlohmann::json workers_json(const RunSnapshot& snapshot);
nlohmann::json species_json(std::uint32_t generation, const std::vector<neat::SpeciesSummary>& species);
// `next`: where the following page starts; null after the last.
nlohmann::json generations_json(const std::vector<GenerationRecord>& page, bool more);
nlohmann::json events_json(const std::vector<Event>& events, std::int64_t since);
// The champion message as JSON: protobuf's own mapping, field names as in proto/genome.proto.
Result<std::string> champion_json(const std::string& serialised);

// The run document of a folder that may have no server: state `interrupted` for a run whose server died.
Result<nlohmann::json> run_json(const std::filesystem::path& run_dir, StoreReader& reader);
Result<nlohmann::json> workers_json(StoreReader& reader);
// Serialised champion of a folder: the chosen one, else the best so far; kNotFound before the first
// generation.
Result<std::string> champion_of(StoreReader& reader);

// Text with strangers' bytes in it made valid UTF-8; one line, or indented.
std::string dump(const nlohmann::json& document, int indent = -1);

}  // namespace evograsp::server
