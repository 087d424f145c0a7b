// The tables of run.db and how a file is recognised as one.
#pragma once

#include <string>

#include "common/result.h"
#include "server/store_sqlite.h"

namespace evograsp::server {

inline constexpr int kSchemaVersion = 3;                    // PRAGMA user_version
inline constexpr int kOldestSchema = 2;                     // that can be read and upgraded
inline constexpr std::int64_t kApplicationId = 0x45564f47;  // PRAGMA application_id: "EVOG"

// The statements that make an empty file a run.db. What it says is part of the product:
// tests/golden/store_schema.sql.
std::string schema_sql();

Status create_schema(Database& database);
// kInvalid for a file that is no run.db; kUnsupported for a version that cannot be read, saying which program
// reads it. Version 2 can: it lacks the tables that version 3 added.
Status check_schema(Database& database);
// Of what check_schema() accepted: adds what is missing, in a transaction of its own.
Status upgrade_schema(Database& database);

}  // namespace evograsp::server
