#include "cli/study/check.h"

#include <algorithm>
#include <set>

#include "cli/study/study.h"
#include "common/near_miss.h"

namespace evograsp::cli::study {
namespace {

bool is_word(const std::string& text, bool file) {
  const auto allowed = [file](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || (file && c == '-');
  };
  return !text.empty() && text.size() <= 60 && text.front() != '.' && text.front() != '-' &&
         std::ranges::all_of(text, allowed);
}

std::string at(const std::string& list, int index, const char* field = nullptr) {
  return list + "[" + std::to_string(index) + "]" + (field != nullptr ? std::string(".") + field : "");
}

class Checker {
 public:
  Checker(proto::Study& study, const std::string& file, const Positions& positions)
      : study_(study), file_(file), positions_(positions) {}
  std::vector<Diagnostic> run();

 private:
  void complain(const std::string& path, const std::string& message);
  void check_new_column(const std::string& path, const std::string& name);
  void check_config(const std::string& path, const std::string& config);
  void check_axis(int index);
  void check_table(int index);
  void check_plot(int index);
  void check_reference(const std::string& path, const proto::StudyReference& reference,
                       const std::vector<std::string>& places);
  void check_column(const std::string& path, const std::string& name, proto::StudySource source, bool axes);
  void check_file_name(const std::string& path, const std::string& name);
  std::vector<std::string> axis_names() const;

  proto::Study& study_;
  const std::string& file_;
  const Positions& positions_;
  std::vector<Diagnostic> mistakes_;
  std::set<std::string> files_{"runs", "tests", "generations"};
};

// At the value's own place, else where its message begins.
void Checker::complain(const std::string& path, const std::string& message) {
  auto place = positions_.find(path);
  for (std::string outer = path; place == positions_.end() && outer.find('.') != std::string::npos;) {
    outer = outer.substr(0, outer.rfind('.'));
    place = positions_.lower_bound(outer + ".");
    if (place != positions_.end() && !place->first.starts_with(outer + ".")) place = positions_.end();
  }
  const Position position = place == positions_.end() ? Position{} : place->second;
  mistakes_.push_back({file_, position.line, position.column, "'" + path + "': " + message});
}

std::vector<std::string> Checker::axis_names() const {
  return place_columns(study_);
}

// A column of every table that the study adds: no other has its name.
void Checker::check_new_column(const std::string& path, const std::string& name) {
  if (!is_word(name, false))
    return complain(path, "found '" + name + "', a word of a-z, 0-9 and _ is wanted");
  for (const proto::StudySource source : {proto::RUNS, proto::TESTS, proto::GENERATIONS}) {
    const auto& taken = columns_of(source);
    const bool known = name == "seed" || std::ranges::find(taken, name) != taken.end();
    if (known && name != "slots") return complain(path, "'" + name + "' is a column already");
  }
}

// What stands in braces is the name of an axis.
void Checker::check_config(const std::string& path, const std::string& config) {
  const auto known = axis_names();
  for (std::size_t open = config.find('{'); open != std::string::npos; open = config.find('{', open + 1)) {
    const std::string name = config.substr(open + 1, config.find('}', open) - open - 1);
    if (std::ranges::find(known, name) == known.end())
      complain(path, "there is no axis '" + name + "'; allowed are " + join_words(known) +
                         did_you_mean(name, known));
  }
}

void Checker::check_axis(int index) {
  const proto::StudyAxis& axis = study_.axis(index);
  const std::string path = at("axis", index);
  check_new_column(path + ".name", axis.name());
  for (int i = 0; i < index; ++i)
    if (study_.axis(i).name() == axis.name())
      complain(path + ".name", "there are two axes '" + axis.name() + "'");
  if (axis.slots_to_cores() == (axis.value_size() > 0))
    complain(path + ".name", "give either values or slots_to_cores");
  std::set<std::string> seen;
  for (int i = 0; i < axis.value_size(); ++i) {
    const std::string& name = axis.value(i).name();
    if (!is_word(name, true)) {
      complain(at(path + ".value", i, "name"),
               "found '" + name + "', a word of a-z, 0-9, '_', '.' and '-' is wanted");
    }
    if (!seen.insert(name).second)
      complain(at(path + ".value", i, "name"), "there are two values '" + name + "'");
    check_config(at(path + ".value", i, "config"), axis.value(i).config());
    for (int k = 0; k < axis.value(i).tag_size(); ++k)
      check_new_column(at(at(path + ".value", i) + ".tag", k, "name"), axis.value(i).tag(k).name());
  }
}

void Checker::check_file_name(const std::string& path, const std::string& name) {
  if (!is_word(name, true)) complain(path, "found '" + name + "', a word of a-z, 0-9, '_' and '-' is wanted");
}

void Checker::check_column(const std::string& path, const std::string& name, proto::StudySource source,
                           bool axes) {
  std::vector<std::string> known = columns_of(source);
  if (axes) {
    const auto names = axis_names();
    known.insert(known.begin(), names.begin(), names.end());
    known.push_back("seed");
  }
  if (std::ranges::find(known, name) != known.end()) return;
  complain(path, "there is no column '" + name + "'; allowed are " + join_words(known, 50) +
                     did_you_mean(name, known));
}

// places: what each name of `at` is a value of; empty: cannot be known.
void Checker::check_reference(const std::string& path, const proto::StudyReference& reference,
                              const std::vector<std::string>& places) {
  if (reference.at_size() != static_cast<int>(places.size())) {
    return complain(path + ".at", "names " + std::to_string(reference.at_size()) + " values, " +
                                      std::to_string(places.size()) + " are wanted: " + join_words(places));
  }
  for (int i = 0; i < reference.at_size(); ++i) {
    for (const proto::StudyAxis& axis : study_.axis()) {
      if (axis.name() != places[static_cast<std::size_t>(i)] || axis.slots_to_cores()) continue;
      std::vector<std::string> values;
      for (const proto::StudyValue& value : axis.value()) values.push_back(value.name());
      if (std::ranges::find(values, reference.at(i)) == values.end()) {
        complain(at(path + ".at", i), axis.name() + " is one of " + join_words(values, 20) + ", not '" +
                                          reference.at(i) + "'" + did_you_mean(reference.at(i), values));
      }
    }
  }
}

void Checker::check_table(int index) {
  const proto::StudyTable& table = study_.table(index);
  const std::string path = at("table", index);
  check_file_name(path + ".name", table.name());
  if (!files_.insert(table.name()).second)
    complain(path + ".name", "'" + table.name() + "' is written already");
  if (table.by_size() == 0) complain(path + ".name", "says nothing in `by`: what is a row of it?");
  for (int i = 0; i < table.by_size(); ++i)
    check_column(at(path + ".by", i), table.by(i), table.source(), true);
  for (int i = 0; i < table.column_size(); ++i)
    check_column(at(path + ".column", i, "of"), table.column(i).of(), table.source(), false);
  for (int i = 0; i < table.reference_size(); ++i)
    check_reference(at(path + ".reference", i), table.reference(i), {table.by().begin(), table.by().end()});
}

void Checker::check_plot(int index) {
  const proto::StudyPlot& plot = study_.plot(index);
  const std::string path = at("plot", index);
  check_file_name(path + ".name", plot.name());
  for (int i = 0; i < index; ++i)
    if (study_.plot(i).name() == plot.name())
      complain(path + ".name", "there are two plots '" + plot.name() + "'");
  if (plot.y_size() == 0) complain(path + ".name", "says nothing in `y`: what does it show?");
  if (plot.y_name_size() > 0 && plot.y_name_size() != plot.y_size())
    complain(path + ".y_name", "there must be as many as y");
  for (int i = 0; i < plot.y_size(); ++i) check_column(at(path + ".y", i), plot.y(i), plot.source(), false);
  check_column(path + ".x", plot.x(), plot.source(), true);
  std::vector<std::string> places;
  for (const auto& [field, axis] :
       {std::pair{"panel", plot.panel()}, {"x", plot.x()}, {"series", plot.series()}}) {
    if (axis.empty()) continue;
    places.push_back(axis);
    const auto names = axis_names();
    if (std::string(field) == "x" || std::ranges::find(names, axis) != names.end()) continue;
    complain(path + "." + field, "there is no axis '" + axis + "'" + did_you_mean(axis, names));
  }
  for (int i = 0; i < plot.reference_size(); ++i)
    check_reference(at(path + ".reference", i), plot.reference(i), places);
  const auto names = axis_names();
  for (int i = 0; i < plot.where_size(); ++i) {
    if (std::ranges::find(names, plot.where(i).name()) == names.end())
      complain(at(path + ".where", i, "name"),
               "there is no axis '" + plot.where(i).name() + "'" + did_you_mean(plot.where(i).name(), names));
  }
}

std::vector<Diagnostic> Checker::run() {
  write_defaults(study_);
  if (!study_.has_config() && std::ranges::none_of(study_.axis(), [](const proto::StudyAxis& axis) {
        return axis.value_size() > 0 &&
               std::ranges::all_of(axis.value(), [](const auto& v) { return v.has_config(); });
      }))
    complain("title", "no config: neither the study nor every value of an axis names one");
  check_config("config", study_.config());
  for (int i = 0; i < study_.axis_size(); ++i) check_axis(i);
  for (int i = 0; i < study_.table_size(); ++i) {
    for (proto::StudyColumn& column : *study_.mutable_table(i)->mutable_column())
      if (!column.has_name()) column.set_name(column.of());
    check_table(i);
  }
  for (int i = 0; i < study_.plot_size(); ++i) {
    proto::StudyPlot& plot = *study_.mutable_plot(i);
    if (!plot.has_x()) plot.set_x(plot.kind() == proto::BARS ? "object" : "generation");
    check_plot(i);
  }
  return std::move(mistakes_);
}

}  // namespace

std::vector<Diagnostic> check(proto::Study& study, const std::string& file, const Positions& positions) {
  return Checker(study, file, positions).run();
}

}  // namespace evograsp::cli::study
