#include "cli/study/dataset.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>

namespace evograsp::cli::study {
namespace {

const Cell kNull;

std::string csv_field(const Cell& cell) {
  if (cell.is_null()) return "";
  const std::string text = text_of(cell);
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

int DataTable::find(const std::string& column) const {
  const auto at = std::ranges::find(columns, column);
  return at == columns.end() ? -1 : static_cast<int>(at - columns.begin());
}

const Cell& DataTable::at(std::size_t row, const std::string& column) const {
  const int index = find(column);
  return index < 0 ? kNull : rows[row][static_cast<std::size_t>(index)];
}

std::string to_csv(const DataTable& table) {
  std::string out;
  const auto line = [&out](const auto& cells, const auto& field) {
    for (std::size_t i = 0; i < cells.size(); ++i) out += (i > 0 ? "," : "") + field(cells[i]);
    out += "\n";
  };
  line(table.columns, [](const std::string& name) { return csv_field(Cell(name)); });
  for (const auto& row : table.rows) line(row, csv_field);
  return out;
}

nlohmann::ordered_json to_json(const DataTable& table) {
  auto out = nlohmann::ordered_json::array();
  for (const auto& row : table.rows) {
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < table.columns.size(); ++i) object[table.columns[i]] = row[i];
    out.push_back(std::move(object));
  }
  return out;
}

Cell cell_of(const std::string& name) {
  if (name == "true") return true;
  if (name == "false") return false;
  std::int64_t whole = 0;
  const char* end = name.data() + name.size();
  if (auto [at, error] = std::from_chars(name.data(), end, whole); error == std::errc() && at == end)
    return whole;
  double number = 0;
  if (auto [at, error] = std::from_chars(name.data(), end, number);
      error == std::errc() && at == end && std::isfinite(number))
    return number;
  return name;
}

std::string text_of(const Cell& cell) {
  if (cell.is_string()) return cell.get<std::string>();
  if (cell.is_null()) return "";
  if (cell.is_number_float()) {
    char text[40];
    std::snprintf(text, sizeof text, "%.10g", cell.get<double>());
    return text;
  }
  return cell.dump();
}

double number_of(const Cell& cell) {
  return cell.is_number() ? cell.get<double>() : std::nan("");
}

double quantile(std::vector<double> values, double part) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return std::nan("");
  std::ranges::sort(values);
  const double place = part * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

double median(const std::vector<double>& values) {
  return quantile(values, 0.5);
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  int n = 0;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    sum += v;
    ++n;
  }
  return n > 0 ? sum / n : std::nan("");
}

double summary(const std::vector<double>& values, proto::StudySummary how) {
  switch (how) {
    case proto::MEAN:
      return mean(values);
    case proto::LOWEST:
      return quantile(values, 0);
    case proto::HIGHEST:
      return quantile(values, 1);
    case proto::MEDIAN:
      break;
  }
  return median(values);
}

Range median_interval(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return {std::nan(""), std::nan("")};
  std::ranges::sort(values);
  // Leaving out k at each end misses the median with the probability of at most k heads in n throws, twice.
  const auto n = static_cast<double>(values.size());
  double chance = std::pow(0.5, n), missed = 2 * chance;
  std::size_t left_out = 0;
  while (missed <= 0.05) {
    chance *= (n - static_cast<double>(left_out)) / (static_cast<double>(left_out) + 1);
    missed += 2 * chance;
    if (missed <= 0.05) ++left_out;
  }
  return {values[left_out], values[values.size() - 1 - left_out]};
}

std::vector<Group> group(const DataTable& table, const std::vector<std::string>& by) {
  std::vector<Group> groups;
  std::map<std::string, std::size_t> known;  // key as text to its group
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    std::vector<Cell> key;
    std::string text;
    for (const std::string& column : by) {
      key.push_back(table.at(row, column));
      text += key.back().dump(-1, ' ', false, Cell::error_handler_t::replace) + ",";
    }
    const auto [place, fresh] = known.try_emplace(text, groups.size());
    if (fresh) groups.push_back({std::move(key), {}});
    groups[place->second].rows.push_back(row);
  }
  return groups;
}

std::vector<double> numbers(const DataTable& table, const std::vector<std::size_t>& rows,
                            const std::string& column) {
  std::vector<double> values;
  for (const std::size_t row : rows) {
    const double value = number_of(table.at(row, column));
    if (std::isfinite(value)) values.push_back(value);
  }
  return values;
}

}  // namespace evograsp::cli::study
