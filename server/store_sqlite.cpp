#include "server/store_sqlite.h"

#include <sodium.h>
#include <sqlite3.h>

#include <cctype>
#include <cmath>
#include <cstring>
#include <system_error>

namespace evograsp::server {
namespace {

constexpr std::size_t kLargeColumn = 4096;  // hashed in place instead of copied
constexpr int kBusyMilliseconds = 5000;     // how long a writer waits for a reader's short lock

std::string hash(std::string_view value) {
  std::string digest(Seal::kBytes, '\0');
  crypto_generichash(reinterpret_cast<unsigned char*>(digest.data()), digest.size(),
                     reinterpret_cast<const unsigned char*>(value.data()), value.size(), nullptr, 0);
  return digest;
}

void append_u64(std::string& out, std::uint64_t value) {
  for (int i = 0; i < 8; ++i) out.push_back(static_cast<char>(value >> (8 * i)));
}

}  // namespace

// ---- Seal ----

Seal::Seal() {
  buffer_.reserve(256);
}

void Seal::add(std::int64_t value) {
  buffer_.push_back('i');
  append_u64(buffer_, static_cast<std::uint64_t>(value));
}

void Seal::add(double value) {
  if (std::isnan(value)) return add_null();
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  buffer_.push_back('d');
  append_u64(buffer_, bits);
}

void Seal::add_text(std::string_view value) {
  bytes('t', value);
}
void Seal::add_blob(std::string_view value) {
  bytes('b', value);
}
void Seal::add_null() {
  buffer_.push_back('n');
}

void Seal::bytes(char tag, std::string_view value) {
  buffer_.push_back(tag);
  append_u64(buffer_, value.size());
  if (value.size() < kLargeColumn) {
    buffer_.append(value);
  } else {
    buffer_.append(hash(value));
  }
}

std::string Seal::finish() {
  std::string seal = hash(buffer_);
  buffer_.clear();
  return seal;
}

// ---- Statement ----

void Statement::Finalize::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

Statement::Statement(Database* database, sqlite3_stmt* statement)
    : database_(database), statement_(statement) {}

void Statement::check_bind(int code) {
  if (code != SQLITE_OK && bind_error_ == 0) bind_error_ = code;
}

Statement& Statement::bind(std::int64_t value) {
  check_bind(sqlite3_bind_int64(statement_.get(), ++bound_, value));
  seal_.add(value);
  return *this;
}

Statement& Statement::bind(double value) {
  check_bind(sqlite3_bind_double(statement_.get(), ++bound_, value));
  seal_.add(value);
  return *this;
}

Statement& Statement::bind_text(std::string_view value) {
  check_bind(sqlite3_bind_text64(statement_.get(), ++bound_, value.data() == nullptr ? "" : value.data(),
                                 value.size(), SQLITE_STATIC, SQLITE_UTF8));
  seal_.add_text(value);
  return *this;
}

Statement& Statement::bind_blob(std::string_view value) {
  check_bind(sqlite3_bind_blob64(statement_.get(), ++bound_, value.data() == nullptr ? "" : value.data(),
                                 value.size(), SQLITE_STATIC));
  seal_.add_blob(value);
  return *this;
}

Statement& Statement::bind_seal() {
  const std::string seal = seal_.finish();
  check_bind(sqlite3_bind_blob64(statement_.get(), ++bound_, seal.data(), seal.size(), SQLITE_TRANSIENT));
  return *this;
}

Result<bool> Statement::step() {
  int code = bind_error_;
  if (code == 0) code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) {
    column_ = 0;
    seal_.clear();
    return true;
  }
  if (code != SQLITE_DONE) {
    const Error error = database_->error(code);
    reset();
    return tl::unexpected<Error>(error);
  }
  reset();
  return false;
}

Status Statement::run() {
  const Result<bool> row = step();
  if (!row) return tl::unexpected<Error>(row.error());
  reset();
  return {};
}

void Statement::reset() {
  sqlite3_reset(statement_.get());
  seal_.clear();
  bound_ = 0;
  bind_error_ = 0;
}

std::int64_t Statement::integer() {
  const std::int64_t value = sqlite3_column_int64(statement_.get(), column_++);
  seal_.add(value);
  return value;
}

double Statement::real() {
  const bool null = sqlite3_column_type(statement_.get(), column_) == SQLITE_NULL;
  const double value = null ? std::nan("") : sqlite3_column_double(statement_.get(), column_);
  ++column_;
  seal_.add(value);
  return value;
}

std::string Statement::text() {
  const auto* data = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column_));
  const int size = sqlite3_column_bytes(statement_.get(), column_++);
  std::string value(data == nullptr ? "" : data, static_cast<std::size_t>(size));
  seal_.add_text(value);
  return value;
}

std::string Statement::blob() {
  const auto* data = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column_));
  const int size = sqlite3_column_bytes(statement_.get(), column_++);
  std::string value(data == nullptr ? "" : data, static_cast<std::size_t>(size));
  seal_.add_blob(value);
  return value;
}

Status Statement::check_seal(std::string_view table) {
  const std::string expected = seal_.finish();
  const auto* data = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column_));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column_++));
  if (data != nullptr && std::string_view(data, size) == expected) return {};
  return fail(ErrorCode::kInvalid, database_->file().string() + ": damaged: a row of table " +
                                       std::string(table) +
                                       " does not match its seal; restore a copy of the run");
}

// ---- Database ----

void Database::Close::operator()(sqlite3* handle) const {
  sqlite3_close_v2(handle);
}

Result<std::unique_ptr<Database>> Database::open(const std::filesystem::path& file, Mode mode) {
  if (sodium_init() < 0) return fail(ErrorCode::kInternal, "libsodium does not start");
  std::error_code ignored;
  if (mode != Mode::kCreate && !std::filesystem::exists(file, ignored))
    return fail(ErrorCode::kNotFound,
                file.string() + ": no such file; a run folder holds one made by a server");
  // Opening a pipe waits for who writes it.
  if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored))
    return fail(ErrorCode::kInvalid, file.string() + ": is no file");
  const auto attempt = [&](const std::string& name, int flags) -> Result<std::unique_ptr<Database>> {
    std::unique_ptr<Database> database(new Database);
    database->file_ = file;
    sqlite3* handle = nullptr;
    int code =
        sqlite3_open_v2(name.c_str(), &handle, flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE, nullptr);
    database->handle_.reset(handle);
    if (handle != nullptr) sqlite3_busy_timeout(handle, kBusyMilliseconds);
    // Opening is lazy: the first read tells whether the file can be used.
    if (code == SQLITE_OK) code = sqlite3_exec(handle, "PRAGMA schema_version", nullptr, nullptr, nullptr);
    if (code != SQLITE_OK) return database->failure(code);
    return database;
  };
  if (mode == Mode::kReadWrite) return attempt(file.string(), SQLITE_OPEN_READWRITE);
  if (mode == Mode::kCreate) return attempt(file.string(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  auto database = attempt(file.string(), SQLITE_OPEN_READONLY);
  if (database) return database;
  // A WAL file in a folder that cannot be written has nowhere to keep its index. With no log beside it,
  // nobody writes it and it may be read as it stands.
  const std::filesystem::path log = file.string() + "-wal";
  if (std::filesystem::exists(log, ignored) && std::filesystem::file_size(log, ignored) > 0) return database;
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    constexpr char kHex[] = "0123456789abcdef";
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("/._-", c) != nullptr;
    if (plain) {
      uri.push_back(c);
    } else {
      uri.append({'%', kHex[static_cast<unsigned char>(c) >> 4], kHex[c & 15]});
    }
  }
  return attempt(uri + "?immutable=1", SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
}

Status Database::exec(const std::string& sql) {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return failure(code);
  return {};
}

Result<Statement> Database::prepare(std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v3(handle_.get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (code != SQLITE_OK) return failure(code);
  return Statement(this, statement);
}

Result<std::int64_t> Database::integer(std::string_view sql) {
  auto statement = prepare(sql);
  if (!statement) return tl::unexpected<Error>(statement.error());
  const auto row = statement->step();
  if (!row) return tl::unexpected<Error>(row.error());
  return *row ? statement->integer() : 0;
}

Result<std::string> Database::text(std::string_view sql) {
  auto statement = prepare(sql);
  if (!statement) return tl::unexpected<Error>(statement.error());
  const auto row = statement->step();
  if (!row) return tl::unexpected<Error>(row.error());
  return *row ? statement->text() : std::string();
}

bool Database::in_transaction() const {
  return sqlite3_get_autocommit(handle_.get()) == 0;
}

Error Database::error(int code) const {
  const std::string name = file_.string();
  const std::string detail = handle_ == nullptr ? sqlite3_errstr(code) : sqlite3_errmsg(handle_.get());
  switch (code & 0xff) {
    case SQLITE_FULL:
      return {ErrorCode::kIo,
              name + ": the disk is full; what was committed is safe: free space, then resume"};
    case SQLITE_READONLY:
      return {ErrorCode::kIo, name + ": cannot be written (read-only file, folder or file system)"};
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return {ErrorCode::kIo,
              name + ": cannot be opened (" + detail + "); check the folder and its permissions"};
    case SQLITE_CORRUPT:
      return {ErrorCode::kInvalid, name + ": damaged (" + detail + ")"};
    case SQLITE_NOTADB:
      return {ErrorCode::kInvalid, name + ": not a run: " + detail};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorCode::kUnavailable, name + ": locked by another program (" + detail + ")"};
    default:
      return {ErrorCode::kIo, name + ": " + detail + " (SQLite code " + std::to_string(code) + ")"};
  }
}

}  // namespace evograsp::server
