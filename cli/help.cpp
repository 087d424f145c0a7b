#include "cli/help.h"

#include <algorithm>
#include <map>
#include <sstream>

namespace evograsp::cli {
namespace {

constexpr std::size_t kWidth = 100;
constexpr std::size_t kLabelWidth = 26;

// CLI11's type names in words that need no explanation.
std::string value_name(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  static const std::map<std::string, std::string> kPlain = {{"UINT", "N"}, {"INT", "N"}, {"FLOAT", "X"}};
  const auto found = kPlain.find(type);
  return found == kPlain.end() ? type : found->second;
}

void put_entry(std::ostringstream& out, const std::string& label, const std::string& description) {
  out << "  " << label;
  std::size_t column = label.size() + 2;
  if (column + 2 > kLabelWidth) {
    out << "\n";
    column = 0;
  }
  for (const std::string& line : wrap(description, kWidth - kLabelWidth)) {
    out << std::string(kLabelWidth - column, ' ') << line << "\n";
    column = 0;
  }
  if (description.empty()) out << "\n";
}

std::string described(const CLI::Option& option) {
  std::string text = option.get_description();
  if (option.get_required() && !option.get_positional()) text += " (required)";
  const std::string given = option.get_default_str();
  if (!given.empty() && given != "\"\"" && given != "[]") text += " [" + given + "]";
  return text;
}

void put_options(std::ostringstream& out, const CLI::App& app, bool positional) {
  const auto options = shown_options(app, positional);
  if (options.empty()) return;
  out << (positional ? "\nArguments:\n" : "\nOptions:\n");
  for (const CLI::Option* option : options) put_entry(out, option_label(*option), described(*option));
}

void put_subcommands(std::ostringstream& out, const CLI::App& app) {
  std::vector<std::string> groups;
  for (const CLI::App* sub : app.get_subcommands({})) {
    if (std::ranges::find(groups, sub->get_group()) == groups.end()) groups.push_back(sub->get_group());
  }
  for (const std::string& group : groups) {
    if (group.empty()) continue;
    out << "\n" << group << ":\n";
    for (const CLI::App* sub : app.get_subcommands({})) {
      if (sub->get_group() == group) put_entry(out, sub->get_name(), sub->get_description());
    }
  }
}

std::string usage(const CLI::App& app, const std::string& name) {
  std::string line = "Usage: " + name;
  for (const CLI::Option* option : shown_options(app, true)) {
    const std::string label = option_label(*option);
    line += option->get_required() ? " " + label : " [" + label + "]";
  }
  if (!app.get_subcommands({}).empty()) line += " COMMAND";
  return line + " [OPTIONS]\n";
}

std::string full_name(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name() : full_name(*app.get_parent()) + " " + app.get_name();
}

}  // namespace

std::vector<std::string> wrap(const std::string& text, std::size_t width) {
  std::vector<std::string> lines;
  std::istringstream words(text);
  std::string word, line;
  while (words >> word) {
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      lines.push_back(line);
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

std::vector<const CLI::Option*> shown_options(const CLI::App& app, bool positional) {
  return app.get_options([positional](const CLI::Option* option) {
    return option->get_positional() == positional && !option->get_group().empty();
  });
}

std::string option_label(const CLI::Option& option) {
  const bool many = option.get_expected_max() > 1000;
  if (option.get_positional()) {
    std::string name = option.get_name(true, false);
    std::ranges::transform(name, name.begin(),
                           [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
    return many ? name + "..." : name;
  }
  std::string label;
  for (const std::string& name : option.get_snames()) label += (label.empty() ? "-" : ", -") + name;
  for (const std::string& name : option.get_lnames()) {
    const bool negated = name.starts_with("no-") && option.get_lnames().size() > 1;
    label += (label.empty() ? "--" : negated ? " | --" : ", --") + name;
  }
  if (option.get_type_size() != 0) label += " " + value_name(option) + (many ? " ..." : "");
  return label;
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string, CLI::AppFormatMode) const {
  std::ostringstream out;
  out << full_name(*app) << ": " << app->get_description() << "\n\n";
  out << usage(*app, full_name(*app));
  put_options(out, *app, true);
  put_subcommands(out, *app);
  put_options(out, *app, false);
  if (!app->get_footer().empty()) out << "\n" << app->get_footer() << "\n";
  return out.str();
}

}  // namespace evograsp::cli
