// One look for every --help: what it is for, how to call it, arguments, options, examples.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace evograsp::cli {

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

// What stands before an option's description: "--out DIR", "-q, --quiet".
std::string option_label(const CLI::Option& option);

// Options worth showing, positional or not, in the order of their definition.
std::vector<const CLI::Option*> shown_options(const CLI::App& app, bool positional);

// Words broken into lines of at most `width` characters.
std::vector<std::string> wrap(const std::string& text, std::size_t width);

}  // namespace evograsp::cli
