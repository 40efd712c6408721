#include <cstdio>

#include "pipeline/cli/commands.hpp"
#include "pipeline/config/describe.hpp"

namespace meshmser {
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

// "--dry-run,-n" as two words.
std::vector<std::string> names_of(const CommandOption& option) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin <= option.name.size();) {
    const std::size_t end = std::min(option.name.find(',', begin), option.name.size());
    names.push_back(option.name.substr(begin, end - begin));
    begin = end + 1;
  }
  return names;
}

std::vector<std::string> stage_names() {
  std::vector<std::string> names;
  for (const StageDefinition* stage : stages_in_order()) names.emplace_back(stage->info.name);
  return names;
}

// Words that may follow an option or stand for a positional argument; none: a file.
std::vector<std::string> words_of(const CommandOption& option) {
  if (!option.choices.empty()) return option.choices;
  for (const char* name : {"STAGE", "--until", "--from", "--only", "--force"})
    if (option.name == name) return stage_names();
  if (option.name != "--set") return {};
  std::vector<std::string> words;
  for (const StageDefinition* stage : stages_in_order())
    for (const Parameter& parameter : stage->parameters)
      words.push_back(std::string(stage->info.name) + "." + parameter.name + "=");
  return words;
}

std::string bash_completion() {
  std::string names, cases;
  for (const CommandDefinition& command : program_commands()) {
    names += (names.empty() ? "" : " ") + command.name;
    std::string options = "--help", positional, values;
    for (const CommandOption& option : command.options) {
      if (option.name.front() == '-') options += " " + joined(names_of(option));
      const std::string words = joined(words_of(option));
      if (option.name.front() != '-') {
        positional += words.empty() ? "" : " " + words;
      } else if (!option.flag) {
        std::string pattern;
        for (const std::string& name : names_of(option)) pattern += (pattern.empty() ? "" : "|") + name;
        values += "        " + pattern + ") words=\"" + words + "\" ;;\n";
      }
    }
    cases += "    " + command.name + ")\n      words=\"" + options + positional + "\"\n";
    if (!values.empty()) cases += "      case \"$previous\" in\n" + values + "      esac\n";
    cases += "      ;;\n";
  }
  return "# bash completion of meshmser; put it to use with: source <(meshmser completion bash)\n"
         "_meshmser() {\n"
         "  local current=\"${COMP_WORDS[COMP_CWORD]}\" previous=\"${COMP_WORDS[COMP_CWORD-1]}\" words=\"\"\n"
         "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
         "    COMPREPLY=($(compgen -W \"" +
         names +
         " --help --version\" -- \"$current\"))\n"
         "    return\n"
         "  fi\n"
         "  case \"${COMP_WORDS[1]}\" in\n" +
         cases +
         "  esac\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "  case \"$previous\" in --set) compopt -o nospace ;; esac\n"
         "}\n"
         "complete -o default -F _meshmser meshmser\n";
}

// Within single quotes and the brackets of _arguments.
std::string zsh_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\'')
      escaped += "'\\''";
    else if (c == '[' || c == ']' || c == ':')
      escaped += std::string("\\") + c;
    else
      escaped += c;
  }
  return escaped;
}

std::string zsh_completion() {
  std::string commands, cases;
  for (const CommandDefinition& command : program_commands()) {
    commands += "      '" + command.name + ":" + zsh_text(command.purpose) + "'\n";
    cases += "        " + command.name + ") _arguments '--help[this text]'";
    for (const CommandOption& option : command.options) {
      const std::string words = joined(words_of(option));
      const std::string action = words.empty() ? "_files" : "(" + words + ")";
      if (option.name.front() != '-') {
        cases += " \\\n          '" + std::string(option.repeated ? "*" : "") + ":" + option.name + ":" + action + "'";
        continue;
      }
      for (const std::string& name : names_of(option))
        cases += " \\\n          '" + std::string(option.repeated ? "*" : "") + name + "[" +
                 zsh_text(option.description) + "]" +
                 (option.flag ? "" : std::string(option.optional_value ? "::value:" : ":value:") + action) + "'";
    }
    cases += " ;;\n";
  }
  return "#compdef meshmser\n"
         "# zsh completion of meshmser; put it to use with: source <(meshmser completion zsh)\n"
         "_meshmser() {\n"
         "  local context state line\n"
         "  _arguments -C '--help[this text]' '--version[version]' '1: :->command' '*:: :->arguments'\n"
         "  case $state in\n"
         "    command)\n"
         "      local -a commands=(\n" +
         commands +
         "      )\n"
         "      _describe command commands ;;\n"
         "    arguments)\n"
         "      case $line[1] in\n" +
         cases +
         "      esac ;;\n"
         "  esac\n"
         "}\n"
         // Found through fpath the file itself is the function's body the first time; sourced, it only defines it.
         "if [ \"$funcstack[1]\" = _meshmser ]; then _meshmser \"$@\"; else compdef _meshmser meshmser; fi\n";
}

int complete(const CommandArguments& arguments, CommandHost&) {
  const std::string text = arguments.get("SHELL") == "bash" ? bash_completion() : zsh_completion();
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace

CommandDefinition completion_command() {
  return {.name = "completion",
          .purpose = "Writes the completion of commands, options, stages and parameters for a shell.",
          .options = {{.name = "SHELL", .description = "the shell", .required = true, .choices = {"bash", "zsh"}}},
          .run = complete,
          .example = "source <(meshmser completion bash)"};
}

}  // namespace meshmser
