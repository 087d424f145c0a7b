// The tables of run.db and how a file is recognised as one.
#pragma once

#include <string_view>

#include "common/result.h"
#include "server/store_sqlite.h"

namespace evograsp::server {

inline constexpr int kSchemaVersion = 2;                    // PRAGMA user_version
inline constexpr std::int64_t kApplicationId = 0x45564f47;  // PRAGMA application_id: "EVOG"

// The statements that make an empty file a run.db. What it says is part of the product:
// tests/golden/store_schema.sql.
std::string_view schema_sql();

Status create_schema(Database& database);
// kInvalid for a file that is no run.db; kUnsupported for another version, saying which program reads it.
Status check_schema(Database& database);

}  // namespace evograsp::server
