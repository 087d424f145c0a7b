#include "cli/study/results.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace evograsp::cli::study {
namespace {

Cell finite(double value) {
  return std::isfinite(value) ? Cell(value) : Cell();
}

Cell rate(int successes, int n) {
  return n > 0 ? Cell(static_cast<double>(successes) / n) : Cell();
}

DataTable empty_table(const proto::Study& study, proto::StudySource source) {
  DataTable table;
  table.columns = place_columns(study);
  table.columns.push_back("seed");
  for (const std::string& column : columns_of(source))
    if (table.find(column) < 0) table.columns.push_back(column);
  return table;
}

// A row with the axes and the seed filled in.
class RowWriter {
 public:
  RowWriter(DataTable& table, const DoneRun& run) : table_(table), row_(table.columns.size()) {
    for (const auto& [axis, value] : run.plan.place) put(axis, cell_of(value));
    put("seed", run.plan.seed);
  }
  void put(const std::string& column, Cell value) {
    row_[static_cast<std::size_t>(table_.find(column))] = std::move(value);
  }
  void finish() { table_.rows.push_back(std::move(row_)); }

 private:
  DataTable& table_;
  std::vector<Cell> row_;
};

void add_reached(RowWriter& row, const std::string& prefix, const server::GenerationRecord& g) {
  row.put(prefix + "_generation", g.generation);
  row.put(prefix + "_trials", g.trials);
  row.put(prefix + "_seconds", g.seconds);
}

// When the bests got to where the study asks, and what they are at the end.
void add_course(RowWriter& row, const proto::Study& study, const DoneRun& done) {
  const auto& generations = done.run.generations;
  double best = 0, best_by = 0;
  const server::GenerationRecord* reached = nullptr;
  for (const server::GenerationRecord& g : generations) {
    best = std::max(best, g.best);
    if (g.generation < study.by_generation()) best_by = std::max(best_by, g.best);
    if (reached == nullptr && g.best >= study.reach()) reached = &g;
  }
  row.put("best", best);
  row.put("best_by", best_by);
  row.put("reached", reached != nullptr);
  if (reached != nullptr) add_reached(row, "reached", *reached);
  for (const CurvePoint& p : done.measured.curve) {
    if (p.fresh_n == 0 || p.fresh_fitness < study.reach() || p.generation >= generations.size()) continue;
    add_reached(row, "fresh_reached", generations[p.generation]);
    break;
  }
}

void add_end(RowWriter& row, const DoneRun& done) {
  const std::size_t count = done.run.generations.size(), first = count - (count + 9) / 10;
  std::vector<double> best, f1, f2, f3, f4, fitness, success;
  for (std::size_t i = first; i < count; ++i) best.push_back(done.run.generations[i].best);
  for (const CurvePoint& p : done.measured.curve) {
    if (p.generation < first) continue;
    if (p.f1) f1.push_back(*p.f1), f2.push_back(*p.f2), f3.push_back(*p.f3), f4.push_back(*p.f4);
    if (p.fresh_n == 0) continue;
    fitness.push_back(p.fresh_fitness);
    success.push_back(static_cast<double>(p.fresh_successes) / p.fresh_n);
  }
  row.put("end_best", finite(mean(best)));
  row.put("end_f1", finite(mean(f1)));
  row.put("end_f2", finite(mean(f2)));
  row.put("end_f3", finite(mean(f3)));
  row.put("end_f4", finite(mean(f4)));
  row.put("end_fresh_fitness", finite(mean(fitness)));
  row.put("end_fresh_success", finite(mean(success)));
}

void add_run(DataTable& table, const proto::Study& study, const DoneRun& done) {
  RowWriter row(table, done);
  const auto& generations = done.run.generations;
  row.put("slots", done.slots);
  row.put("generations", generations.size());
  if (!generations.empty()) {
    row.put("trials", generations.back().trials);
    row.put("seconds", generations.back().seconds);
  }
  add_course(row, study, done);
  add_end(row, done);
  if (done.run.champion) {
    const proto::Champion& c = *done.run.champion;
    row.put("champion_generation", c.generation());
    row.put("champion_fitness", c.fitness());
    row.put("validation_trials", c.validation_trials());
    row.put("validation_success",
            rate(static_cast<int>(c.validation_successes()), static_cast<int>(c.validation_trials())));
    row.put("validation_fitness", c.validation_fitness());
  }
  row.finish();
}

void add_tests(DataTable& table, const DoneRun& done) {
  for (const TestedObject& t : done.measured.tests) {
    RowWriter row(table, done);
    row.put("object", t.object);
    row.put("n", t.n);
    row.put("extent_m", t.extent_m > 0 ? Cell(t.extent_m) : Cell());
    row.put("refused", t.refused.empty() ? Cell() : Cell(t.refused));
    if (t.refused.empty()) {
      row.put("successes", t.successes);
      row.put("success", rate(t.successes, t.n));
      row.put("unseen", t.unseen);
    }
    if (t.lifted) {
      row.put("lifts", t.lifts);
      row.put("lift_success", rate(t.lifts, t.n));
    }
    row.finish();
  }
}

void add_generations(DataTable& table, const DoneRun& done) {
  double best_so_far = 0;
  std::size_t at = 0;
  const std::vector<CurvePoint>& curve = done.measured.curve;
  for (const server::GenerationRecord& g : done.run.generations) {
    RowWriter row(table, done);
    best_so_far = std::max(best_so_far, g.best);
    row.put("generation", g.generation);
    row.put("trials", g.trials);
    row.put("seconds", g.seconds);
    row.put("best", g.best);
    row.put("best_so_far", best_so_far);
    row.put("mean", g.mean);
    row.put("species", g.species);
    row.put("links", g.links);
    while (at < curve.size() && curve[at].generation < g.generation) ++at;
    if (at < curve.size() && curve[at].generation == g.generation) {
      const CurvePoint& p = curve[at];
      const auto put = [&row](const char* name, const std::optional<double>& v) {
        if (v) row.put(name, *v);
      };
      put("f1", p.f1);
      put("f2", p.f2);
      put("f3", p.f3);
      put("f4", p.f4);
      if (p.fresh_n > 0) {
        row.put("fresh_n", p.fresh_n);
        row.put("fresh_success", rate(p.fresh_successes, p.fresh_n));
        row.put("fresh_fitness", p.fresh_fitness);
      }
    }
    row.finish();
  }
}

std::size_t seeds_in(const DataTable& table, const std::vector<std::size_t>& rows) {
  std::set<std::string> seeds;
  for (const std::size_t row : rows) seeds.insert(text_of(table.at(row, "seed")));
  return seeds.size();
}

Cell reference_of(const proto::StudyTable& spec, const std::vector<Cell>& key) {
  for (const proto::StudyReference& reference : spec.reference()) {
    bool same = reference.at_size() == static_cast<int>(key.size());
    for (std::size_t i = 0; same && i < key.size(); ++i)
      same = text_of(key[i]) == reference.at(static_cast<int>(i)) ||
             key[i] == cell_of(reference.at(static_cast<int>(i)));
    if (same) return reference.value();
  }
  return {};
}

// The mean of each number over the rows that agree in everything but the first `by`.
std::vector<std::vector<Cell>> mean_rows(const DataTable& table, std::size_t by) {
  std::vector<std::string> rest(table.columns.begin() + 1, table.columns.begin() + static_cast<long>(by));
  const std::vector<Group> groups = group(table, rest);
  std::vector<std::vector<Cell>> rows;
  for (const Group& g : groups) {
    std::vector<Cell> row(table.columns.size());
    row[0] = "mean";
    std::copy(g.key.begin(), g.key.end(), row.begin() + 1);
    for (std::size_t c = by; c < table.columns.size(); ++c)
      row[c] = finite(mean(numbers(table, g.rows, table.columns[c])));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

Data collect(const proto::Study& study, const std::vector<DoneRun>& done) {
  Data data{empty_table(study, proto::RUNS), empty_table(study, proto::TESTS),
            empty_table(study, proto::GENERATIONS)};
  for (const DoneRun& run : done) {
    add_run(data.runs, study, run);
    add_tests(data.tests, run);
    add_generations(data.generations, run);
  }
  return data;
}

SummedTable sum_up(const proto::StudyTable& spec, const Data& data) {
  const DataTable& source = data.of(spec.source());
  SummedTable summed;
  summed.spec = &spec;
  DataTable& out = summed.data;
  const std::vector<std::string> by(spec.by().begin(), spec.by().end());
  out.columns = by;
  for (const proto::StudyColumn& column : spec.column()) out.columns.push_back(column.name());
  out.columns.push_back("seeds");
  if (spec.reference_size() > 0) out.columns.push_back(spec.reference_label());
  for (const Group& g : group(source, by)) {
    std::vector<Cell> row = g.key;
    for (const proto::StudyColumn& column : spec.column()) {
      const double value = summary(numbers(source, g.rows, column.of()), column.summary());
      // Whole numbers of the source stay whole: n, generations.
      const bool whole = std::isfinite(value) && std::floor(value) == value &&
                         source.at(g.rows[0], column.of()).is_number_integer();
      row.push_back(whole ? Cell(static_cast<std::int64_t>(value)) : finite(value));
    }
    row.push_back(seeds_in(source, g.rows));
    if (spec.reference_size() > 0) row.push_back(reference_of(spec, g.key));
    out.rows.push_back(std::move(row));
  }
  if (spec.mean_row() && !by.empty()) summed.means = mean_rows(out, by.size());
  return summed;
}

}  // namespace evograsp::cli::study
