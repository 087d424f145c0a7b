#include "neat/archive.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

namespace evograsp::neat {
namespace {

std::uint32_t bin_of(double value, std::uint32_t bins) {
  const double scaled = std::clamp(value, 0.0, 1.0) * bins;
  return std::min(static_cast<std::uint32_t>(scaled), bins - 1);
}

bool is_circle(const proto::ArchiveAxis& axis) {
  return axis.of() == proto::YAW && !axis.has_low() && !axis.has_high();
}

// The sum of `count` values with one more. On a circle the way about it that is nearer the mean before
// counts, and the mean stays from 0 to 1.
double add_up(double sum, double mean, double value, std::uint32_t count, bool circle) {
  if (!circle) return sum + value;
  if (value - mean > 0.5) value -= 1;
  if (mean - value > 0.5) value += 1;
  sum += value;
  if (sum < 0) sum += count;
  if (sum >= count) sum -= count;
  return sum;
}

// Each from 0 to 1; all 0 when there is no difference.
std::vector<double> spread_out(std::span<const double> values) {
  double least = 0, most = 0;
  bool any = false;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    least = any ? std::min(least, v) : v;
    most = any ? std::max(most, v) : v;
    any = true;
  }
  std::vector<double> result;
  for (const double v : values)
    result.push_back(!std::isfinite(v) ? v : most > least ? (v - least) / (most - least) : 0.0);
  return result;
}

}  // namespace

bool Behaviour::known() const {
  return std::isfinite(x) && std::isfinite(y);
}

Archive::Archive(const proto::ArchiveConfig& config)
    : columns_(std::clamp(config.x().bins(), 1u, 64u)),
      rows_(std::clamp(config.y().bins(), 1u, 64u)),
      neighbours_(std::max(config.neighbours(), 1u)),
      remembered_(config.remembered()),
      memory_size_(config.memory()),
      circle_x_(is_circle(config.x())),
      circle_y_(is_circle(config.y())) {}

std::uint32_t Archive::cell_of(const Behaviour& behaviour) const {
  return bin_of(behaviour.x, columns_) + bin_of(behaviour.y, rows_) * columns_;
}

// ---- the map ----

void Archive::add(std::uint32_t generation, std::span<const Genome> genomes, std::span<const double> fitness,
                  std::span<const Behaviour> behaviour) {
  if (!restored_) changed_.clear();
  restored_ = false;
  std::vector<bool> known(genomes.size(), false);
  judge_again(genomes, fitness, behaviour, known);
  for (std::size_t i = 0; i < genomes.size(); ++i) {
    if (known[i] || !std::isfinite(fitness[i]) || !behaviour[i].known()) continue;
    const auto held = elites_.find(cell_of(behaviour[i]));
    if (held != elites_.end() && fitness[i] <= held->second.fitness()) continue;  // spares the copy
    hold_against({genomes[i], generation, 1, fitness[i], behaviour[i].x, behaviour[i].y});
  }
}

// known[i]: genome i was an elite when the generation began.
void Archive::judge_again(std::span<const Genome> genomes, std::span<const double> fitness,
                          std::span<const Behaviour> behaviour, std::vector<bool>& known) {
  std::map<std::uint64_t, std::uint32_t> cell_of_id;
  for (const auto& [cell, elite] : elites_) cell_of_id[elite.genome.id()] = cell;
  std::vector<std::uint32_t> left;
  for (std::size_t i = 0; i < genomes.size(); ++i) {
    const auto found = cell_of_id.find(genomes[i].id());
    if (found == cell_of_id.end()) continue;
    known[i] = true;
    if (!std::isfinite(fitness[i]) || !behaviour[i].known()) continue;
    Elite& elite = elites_.at(found->second);
    const Behaviour before = elite.behaviour();
    ++elite.judged;
    elite.fitness_sum += fitness[i];
    elite.x_sum = add_up(elite.x_sum, before.x, behaviour[i].x, elite.judged, circle_x_);
    elite.y_sum = add_up(elite.y_sum, before.y, behaviour[i].y, elite.judged, circle_y_);
    changed_.insert(found->second);
    if (cell_of(elite.behaviour()) != found->second) left.push_back(found->second);
  }
  // All leave before the first of them arrives.
  std::sort(left.begin(), left.end());
  std::vector<Elite> moving;
  for (const std::uint32_t cell : left) {
    moving.push_back(std::move(elites_.at(cell)));
    elites_.erase(cell);
  }
  for (Elite& elite : moving) hold_against(std::move(elite));
}

void Archive::hold_against(Elite elite) {
  const std::uint32_t cell = cell_of(elite.behaviour());
  const auto held = elites_.find(cell);
  if (held == elites_.end())
    elites_.emplace(cell, std::move(elite));
  else if (elite.fitness() > held->second.fitness())
    held->second = std::move(elite);
  else
    return;
  changed_.insert(cell);
}

// ---- novelty ----

double Archive::distance(const Behaviour& a, const Behaviour& b) const {
  double dx = std::abs(a.x - b.x), dy = std::abs(a.y - b.y);
  if (circle_x_) dx = std::min(dx, 1 - dx);
  if (circle_y_) dy = std::min(dy, 1 - dy);
  return std::sqrt(dx * dx + dy * dy);
}

std::vector<double> Archive::novelty(std::span<const Behaviour> behaviour) const {
  std::vector<double> result(behaviour.size(), 0.0), near;
  for (std::size_t i = 0; i < behaviour.size(); ++i) {
    if (!behaviour[i].known()) continue;
    near.clear();
    for (std::size_t j = 0; j < behaviour.size(); ++j)
      if (j != i && behaviour[j].known()) near.push_back(distance(behaviour[i], behaviour[j]));
    for (const Behaviour& old : memory_) near.push_back(distance(behaviour[i], old));
    const std::size_t count = std::min<std::size_t>(near.size(), neighbours_);
    if (count == 0) continue;
    const auto end = near.begin() + static_cast<std::ptrdiff_t>(count);
    std::partial_sort(near.begin(), end, near.end());  // so that the sum has one order
    result[i] = std::accumulate(near.begin(), end, 0.0) / static_cast<double>(count);
  }
  return result;
}

void Archive::remember(std::span<const Behaviour> behaviour, std::span<const double> novelty) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < behaviour.size(); ++i)
    if (behaviour[i].known()) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return novelty[a] > novelty[b]; });
  order.resize(std::min<std::size_t>(order.size(), remembered_));
  for (const std::size_t i : order) memory_.push_back(behaviour[i]);
  while (memory_.size() > memory_size_) memory_.pop_front();
}

std::vector<double> selection_scores(std::span<const double> fitness, std::span<const double> novelty,
                                     double weight) {
  std::vector<double> result = spread_out(fitness);
  const std::vector<double> strange = spread_out(novelty);
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = (1 - weight) * result[i] + weight * strange[i];
  return result;
}

// ---- storage ----

Status Archive::restore_elite(std::uint32_t cell, Elite elite) {
  const auto bad = [](const char* what) {
    return fail(ErrorCode::kInvalid, std::string("population state: an elite ") + what);
  };
  if (cell >= cells()) return bad("lies outside the map");
  if (!elites_.empty() && cell <= elites_.rbegin()->first) return bad("is out of order");
  if (elite.judged == 0 || !std::isfinite(elite.fitness_sum) || !elite.behaviour().known())
    return bad("has no fitness or no place");
  if (cell_of(elite.behaviour()) != cell) return bad("lies in another cell than it says");
  elites_.emplace_hint(elites_.end(), cell, std::move(elite));
  changed_.insert(cell);
  restored_ = true;
  return {};
}

Status Archive::restore_memory(Behaviour behaviour) {
  const auto within = [](double v) { return v >= 0 && v <= 1; };
  if (!within(behaviour.x) || !within(behaviour.y) || memory_.size() >= memory_size_)
    return fail(ErrorCode::kInvalid, "population state: its memory of what was novel cannot be");
  memory_.push_back(behaviour);
  return {};
}

}  // namespace evograsp::neat
