// `evograsp completions SHELL`: completion scripts written from the tree of commands itself.
#include <cstdio>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cli/cli.h"
#include "cli/help.h"
#include "cli/study/study.h"
#include "common/config.h"
#include "common/near_miss.h"

namespace evograsp::cli {
namespace {

struct Flag {
  std::vector<std::string> names;  // with their dashes
  bool takes_value = false;
  std::string description;
};
struct Command {
  std::string name, description;
  std::vector<Flag> flags;
  std::vector<std::string> words;  // what its first argument may be, beside files
};

std::vector<Flag> flags_of(const CLI::App& app) {
  std::vector<Flag> flags;
  for (const CLI::Option* option : shown_options(app, false)) {
    Flag flag;
    for (const std::string& name : option->get_lnames()) flag.names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) flag.names.push_back("-" + name);
    flag.takes_value = option->get_items_expected_max() > 0;
    flag.description = option->get_description();
    flags.push_back(flag);
  }
  return flags;
}

std::vector<Command> commands_of(const CLI::App& app) {
  std::vector<Command> commands;
  for (const CLI::App* sub : app.get_subcommands({})) {
    Command command{sub->get_name(), sub->get_description(), flags_of(*sub), {}};
    if (command.name == "train" || command.name == "validate") command.words = builtin_configs();
    if (command.name == "experiment") command.words = study::builtin_studies();
    if (command.name == "completions") command.words = {"bash", "zsh", "fish"};
    commands.push_back(command);
  }
  return commands;
}

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + word;
  return out;
}

std::string all_names(const std::vector<Flag>& flags) {
  std::vector<std::string> names;
  for (const Flag& flag : flags) names.insert(names.end(), flag.names.begin(), flag.names.end());
  return joined(names);
}

std::string all_names(const std::vector<Command>& commands) {
  std::vector<std::string> names;
  for (const Command& command : commands) names.push_back(command.name);
  return joined(names);
}

// Single-quoted for a shell: nothing in it is special. fish reads \' where bash and zsh need '\''.
std::string in_quotes(const std::string& text, const char* quote = "'\\''") {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string(quote) : std::string(1, c);
  return out + "'";
}

std::string bash(const CLI::App& app) {
  const auto commands = commands_of(app);
  std::string out =
      "# evograsp: completion for bash. Use: source <(evograsp completions bash)\n"
      "_evograsp() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} command= words= flags= i\n"
      "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
      "    [[ ${COMP_WORDS[i]} == -* ]] || { command=${COMP_WORDS[i]}; break; }\n"
      "  done\n"
      "  case $command in\n";
  out += "    '') words='" + all_names(commands) + " help' flags='" + all_names(flags_of(app)) + "' ;;\n";
  out += "    help) words='" + all_names(commands) + "' ;;\n";
  for (const Command& command : commands) {
    out += "    " + command.name + ") words='" + joined(command.words) + "' flags='" +
           all_names(command.flags) + "' ;;\n";
  }
  out +=
      "  esac\n"
      "  if [[ $word == -* ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$flags\" -- \"$word\")\n"
      "  else\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\"; [[ -z $command ]] || compgen -f -- "
      "\"$word\")\n"
      "  fi\n"
      "}\n"
      "complete -o filenames -F _evograsp evograsp\n";
  return out;
}

// zsh's _arguments gives brackets and colons a meaning.
std::string zsh_text(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '[' || c == ']' || c == ':' ? std::string("\\") + c : std::string(1, c);
  return out;
}

std::string zsh(const CLI::App& app) {
  std::string out =
      "#compdef evograsp\n# evograsp: completion for zsh. Use: source <(evograsp completions "
      "zsh)\n_evograsp() {\n"
      "  local -a commands=(\n";
  const auto commands = commands_of(app);
  for (const Command& c : commands) out += "    " + in_quotes(c.name + ":" + zsh_text(c.description)) + "\n";
  out +=
      "    'help:explain a command'\n  )\n"
      "  if (( CURRENT == 2 )); then _describe command commands; return; fi\n"
      "  shift words; (( CURRENT-- ))\n"  // _arguments counts from the command's own name
      "  case $words[1] in\n    help) _describe command commands ;;\n";
  for (const Command& command : commands) {
    out += "    " + command.name + ") _arguments";
    for (const Flag& flag : command.flags) {
      for (const std::string& name : flag.names) {
        out += " \\\n      " + in_quotes(name + "[" + zsh_text(flag.description) + "]" +
                                         (flag.takes_value ? ":value:_files" : ""));
      }
    }
    const std::string words = command.words.empty() ? "_files"
                                                    : "_alternative \"names:name:(" + joined(command.words) +
                                                          ")\" \"files:file:_files\"";
    out += " \\\n      " + in_quotes("*::argument:{" + words + "}") + " ;;\n";
  }
  return out +
         "  esac\n}\n"
         "if [[ $funcstack[1] == _evograsp ]]; then _evograsp \"$@\"; else compdef _evograsp evograsp; fi\n";
}

std::string fish(const CLI::App& app) {
  std::string out = "# evograsp: completion for fish. Use: evograsp completions fish | source\n";
  const char* kQuote = "\\'";
  const auto commands = commands_of(app);
  for (const Command& c : commands) {
    out += "complete -c evograsp -f -n __fish_use_subcommand -a " + c.name + " -d " +
           in_quotes(c.description, kQuote) + "\n";
  }
  out += "complete -c evograsp -f -n __fish_use_subcommand -a help -d 'explain a command'\n";
  out += "complete -c evograsp -f -n '__fish_seen_subcommand_from help' -a " +
         in_quotes(all_names(commands), kQuote) + "\n";
  for (const Command& command : commands) {
    const std::string prefix = "complete -c evograsp -n '__fish_seen_subcommand_from " + command.name + "'";
    if (!command.words.empty()) out += prefix + " -a " + in_quotes(joined(command.words), kQuote) + "\n";
    for (const Flag& flag : command.flags) {
      out += prefix;
      for (const std::string& name : flag.names)
        out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      out += std::string(flag.takes_value ? " -r" : "") + " -d " + in_quotes(flag.description, kQuote) + "\n";
    }
  }
  return out;
}

}  // namespace

void add_completions(CLI::App& app, Outcome&) {
  CLI::App* sub = app.add_subcommand("completions", "print a completion script for your shell");
  static const std::vector<std::string> kShells = {"bash", "zsh", "fish"};
  auto shell = std::make_shared<std::string>();
  sub->add_option("shell", *shell, "bash, zsh or fish")->required()->check([](const std::string& given) {
    if (std::ranges::find(kShells, given) != kShells.end()) return std::string();
    return "'" + given + "' is not a shell it knows (" + join_words(kShells) + ")" +
           did_you_mean(given, kShells);
  });
  sub->footer("Example:\n  source <(evograsp completions bash)     # or put the line into ~/.bashrc");
  sub->callback([&app, shell] {
    const std::string script = *shell == "bash" ? bash(app) : *shell == "zsh" ? zsh(app) : fish(app);
    std::fputs(script.c_str(), stdout);
  });
}

}  // namespace evograsp::cli
