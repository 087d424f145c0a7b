// SQLite with Results instead of return codes, and with sealed rows.
//
// Every table of run.db ends in a column `seal`: the BLAKE2b-128 hash of the row's other columns, so that a
// byte that flips on the disk is noticed when the row is read. Encoding, column by column: a tag byte ('i',
// 'd', 't', 'b' or 'n'), then for i and d the 8 bytes of the value (little endian), for t and b the length as
// 8 bytes and the bytes (from 4,096 bytes on, their BLAKE2b-128 hash instead), for n (NULL) nothing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "common/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace evograsp::server {

// Accumulates a row's columns into its seal.
class Seal {
 public:
  static constexpr std::size_t kBytes = 16;
  Seal();
  void add(std::int64_t value);
  void add(double value);  // NaN counts as NULL, as SQLite stores it
  void add_text(std::string_view value);
  void add_blob(std::string_view value);
  void add_null();
  std::string finish();  // kBytes; starts over
  void clear() { buffer_.clear(); }

 private:
  void bytes(char tag, std::string_view value);
  std::string buffer_;
};

class Database;

// One prepared statement, used row by row. Not shared between threads; must not outlive its Database.
class Statement {
 public:
  Statement(Statement&&) noexcept = default;
  Statement& operator=(Statement&&) noexcept = default;

  // Values of the next parameter, left to right. Text and blobs must live until step().
  Statement& bind(std::int64_t value);
  Statement& bind_id(std::uint64_t value) { return bind(static_cast<std::int64_t>(value)); }
  Statement& bind(double value);
  Statement& bind_text(std::string_view value);
  Statement& bind_blob(std::string_view value);
  // The seal of everything bound so far becomes the last parameter.
  Statement& bind_seal();

  // true: a row is there to read. false: done; the statement is ready to be bound again.
  Result<bool> step();
  // Binds nothing more, expects no row.
  Status run();
  void reset();

  // Columns of the current row, left to right.
  std::int64_t integer();
  std::uint64_t id() { return static_cast<std::uint64_t>(integer()); }
  double real();
  std::string text();
  std::string blob();
  // Reads the last column and compares it with the seal of those read. An error names the table.
  Status check_seal(std::string_view table);

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  Statement(Database* database, sqlite3_stmt* statement);
  void check_bind(int code);

  Database* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  Seal seal_;
  int bound_ = 0;
  int column_ = 0;
  int bind_error_ = 0;
};

// One connection. Used by one thread at a time.
class Database {
 public:
  enum class Mode { kCreate, kReadWrite, kReadOnly };
  // kReadOnly also opens files in folders that cannot be written, as long as nobody is writing them.
  static Result<std::unique_ptr<Database>> open(const std::filesystem::path& file, Mode mode);

  Status exec(const std::string& sql);
  Result<Statement> prepare(std::string_view sql);
  Result<std::int64_t> integer(std::string_view sql);  // first column of the first row
  Result<std::string> text(std::string_view sql);
  bool in_transaction() const;
  const std::filesystem::path& file() const { return file_; }

  // The last failure in words: the file, what happened, what to do.
  Error error(int code) const;
  tl::unexpected<Error> failure(int code) const { return tl::unexpected<Error>(error(code)); }

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  Database() = default;
  std::filesystem::path file_;
  std::unique_ptr<sqlite3, Close> handle_;
};

}  // namespace evograsp::server
