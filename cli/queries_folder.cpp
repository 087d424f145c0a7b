// A run folder as a source of answers.
#include <filesystem>

#include "cli/queries_source.h"
#include "server/api_json.h"
#include "server/archive_json.h"
#include "server/store_reader.h"

namespace evograsp::cli {
namespace {

using nlohmann::json;

class FolderSource final : public Source {
 public:
  FolderSource(std::filesystem::path folder, std::unique_ptr<server::StoreReader> reader)
      : folder_(std::move(folder)), reader_(std::move(reader)) {}

  Result<json> run() override { return server::run_json(folder_, *reader_); }
  Result<json> workers() override { return server::workers_json(*reader_); }

  Result<json> species(std::optional<std::uint32_t> generation) override {
    const auto last = reader_->last_generation();
    if (!last) return tl::unexpected(last.error());
    if (!*last || generation.value_or(0) > (*last)->generation)
      return fail(ErrorCode::kNotFound, name() + ": that generation has not been judged yet");
    const std::uint32_t wanted = generation.value_or((*last)->generation);
    const auto species = reader_->species(wanted);
    if (!species) return tl::unexpected(species.error());
    return server::species_json(wanted, *species);
  }

  Result<json> generations(std::uint32_t from, std::uint32_t limit) override {
    auto page = reader_->generations(from, limit + 1);
    if (!page) return tl::unexpected(page.error());
    const bool more = page->size() > limit;
    if (more) page->pop_back();
    return server::generations_json(*page, more);
  }

  Result<json> events(std::int64_t since, std::uint32_t limit) override {
    const auto events = reader_->events(since, limit);
    if (!events) return tl::unexpected(events.error());
    return server::events_json(*events, since);
  }

  Result<Champion> champion() override {
    auto bytes = server::champion_of(*reader_);
    if (!bytes) return fail(bytes.error().code, name() + ": " + bytes.error().message);
    const auto chosen = reader_->champion();
    return Champion{std::move(*bytes), chosen && !chosen->empty()};
  }

  Result<json> archive() override {
    auto document = server::archive_json(*reader_);
    if (!document) return fail(document.error().code, name() + ": " + document.error().message);
    return document;
  }
  Result<Champion> elite(std::uint32_t x, std::uint32_t y) override {
    auto bytes = server::elite_of(*reader_, x, y);
    if (!bytes) return fail(bytes.error().code, name() + ": " + bytes.error().message);
    return Champion{std::move(*bytes), false};
  }

  Status steer(const std::string& verb) override {
    return fail(ErrorCode::kUsage, name() + ": a folder cannot " + verb +
                                       " its run; name the server that has it with --server URL");
  }

  Result<json> log_level(const std::optional<std::string>&) override {
    return fail(ErrorCode::kUsage,
                name() + ": a folder has no log; name the server that has it with --server URL");
  }

  Result<std::uint32_t> drain(const std::string&, bool) override {
    return fail(ErrorCode::kUsage,
                name() + ": a folder has no workers; name the server that has them with --server URL");
  }

  std::string name() const override { return folder_.string(); }

 private:
  const std::filesystem::path folder_;
  const std::unique_ptr<server::StoreReader> reader_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_folder(const std::string& folder) {
  auto reader = server::StoreReader::open(folder);
  if (!reader) return tl::unexpected(reader.error());
  return std::make_unique<FolderSource>(folder, std::move(*reader));
}

}  // namespace evograsp::cli
