// A run.db from a stranger, or from a disk that forgets: read beside a server, then resumed. The first byte
// says how the input is meant: 0: the file itself; 1: bytes changed in a good file (offset in 24 bits,
// value); else: a whole file whose rows are sealed but whose content is the input's pieces.
#include <memory>

#include "assets/assets.h"
#include "neat/population.h"
#include "server/store.h"
#include "server/store_reader.h"
#include "tests/fuzz/run_db.h"

namespace {

using namespace evograsp;
using namespace evograsp::server;

// What the server does with a run before it begins.
void take_up(const ResumePoint& point) {
  for (const Evaluation& e : point.evaluations) unpack_measurements(e.measurements);
  for (const StoredAsset& asset : point.assets)
    asset.kind == "hand" ? void(assets::unpack_hand(asset.packed, asset.id))
                         : void(assets::unpack_object(asset.packed, asset.id));
  for (const BestRecord& best : point.bests) make_champion(point.info.config, "f", best, {});
  const auto population = neat::Population::load(point.info.config.neat(), point.population);
  if (population) population->save();
}

// What `evograsp` asks of a run.
void read(StoreReader& reader) {
  reader.run();
  reader.progress();
  reader.assets();
  reader.generations(0, 1000);
  reader.last_generation();
  reader.species(0);
  reader.events(0, 100);
  reader.workers();
  reader.bests(0, 1000);
  reader.best();
  reader.validations();
  reader.poisons();
  reader.champion();
  if (const auto generations = reader.populations())
    for (const std::uint32_t g : *generations) reader.population(g);
}

void change(std::string& file, fuzz::Pieces& pieces) {
  while (!pieces.empty()) {
    const std::size_t at = pieces.number() | static_cast<std::size_t>(pieces.byte()) << 16;
    file[at % file.size()] = static_cast<char>(pieces.byte());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  fuzz::Pieces pieces(data, size);
  const std::uint8_t kind = pieces.byte();
  const std::filesystem::path run = folder.path() / "run";
  std::error_code ignored;
  std::filesystem::remove_all(run, ignored);
  std::filesystem::create_directories(run);
  if (kind == 0) {
    folder.write("run/run.db", pieces.rest());
  } else if (kind == 1) {
    static const std::string good = fuzz::small_run_db(folder.path() / "good");
    std::string file = good;
    change(file, pieces);
    folder.write("run/run.db", file);
  } else if (!fuzz::write_sealed(run, pieces)) {
    return 0;
  }
  if (const auto reader = StoreReader::open(run)) read(**reader);
  auto resumed = Store::resume(run);
  if (resumed) {
    take_up(resumed->point);
    fuzz::require(resumed->store->flush().has_value(), "a run that was taken up can be written");
  }
  return 0;
}
