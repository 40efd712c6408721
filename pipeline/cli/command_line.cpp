#include "pipeline/cli/command_line.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <new>

#include "pipeline/cli/commands.hpp"
#include "pipeline/cli/interruption.hpp"
#include "pipeline/cli/pipeline_host.hpp"

namespace meshmser {
namespace {

/// The values that the parser found for one command's options.
struct ParsedCommand {
  CommandDefinition definition;
  CLI::App* app = nullptr;
  std::vector<CLI::Option*> options;
};

// Stands for the value of an option that was given without one.
constexpr const char* kNoValue = "(none)";

std::string canonical_name(const std::string& name) {
  return name.substr(0, name.find(','));
}

CLI::Option* add_option(CLI::App& app, const CommandOption& option) {
  if (option.flag) return app.add_flag(option.name, option.description);
  CLI::Option* added = nullptr;
  if (option.name.front() == '-') {
    added = app.add_option(option.name, option.description);
    // The placeholder of the value in the help text.
    added->type_name(option.choices.empty() ? "VALUE" : CLI::detail::join(option.choices, "|"));
    if (option.repeated) added->option_text("VALUE (once for each)");
  } else {
    // The parser takes positional names of letters and digits only; the help text shows the name as it is.
    std::string plain = option.name;
    std::replace_if(
        plain.begin(), plain.end(), [](char c) { return c == '.'; }, '_');
    added = app.add_option(plain, option.description);
    added->type_name(option.choices.empty() ? "" : CLI::detail::join(option.choices, "|"));
    added->option_text(option.choices.empty() ? " " : CLI::detail::join(option.choices, "|"));
  }
  added->expected(1, option.repeated ? CLI::detail::expected_max_vector_size : 1);
  if (option.repeated) added->take_all()->allow_extra_args(false);
  if (option.required) added->required();
  return added;
}

ParsedCommand add_command(CLI::App& program, CommandDefinition definition) {
  ParsedCommand command;
  command.app = program.add_subcommand(definition.name, definition.purpose);
  command.app->set_help_flag("--help,-h", "this text");
  for (const CommandOption& option : definition.options) command.options.push_back(add_option(*command.app, option));
  if (!definition.example.empty()) command.app->footer("Example: " + definition.example);
  command.definition = std::move(definition);
  return command;
}

CommandArguments arguments_of(const ParsedCommand& command) {
  CommandArguments arguments;
  for (std::size_t i = 0; i < command.options.size(); ++i) {
    const CommandOption& option = command.definition.options[i];
    if (command.options[i]->count() == 0) continue;
    std::vector<std::string> values = command.options[i]->results();
    for (std::string& value : values) {
      if (option.optional_value && value == kNoValue) value.clear();
      if (!option.choices.empty() &&
          std::find(option.choices.begin(), option.choices.end(), value) == option.choices.end()) {
        const std::string nearest = nearest_name(value, option.choices);
        throw UsageError(command.definition.name + ": '" + value + "' is not one of " +
                         CLI::detail::join(option.choices, ", ") +
                         (nearest.empty() ? "" : "; did you mean '" + nearest + "'?"));
      }
    }
    arguments.values.emplace_back(canonical_name(option.name), std::move(values));
  }
  return arguments;
}

int threads_of(const CommandArguments& arguments) {
  const std::string text = arguments.get("--threads");
  if (text.empty()) return 0;
  int threads = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), threads);
  if (error != std::errc() || end != text.data() + text.size() || threads < 1 || threads > 1024)
    throw UsageError("--threads: '" + text + "' is not a whole number from 1 to 1024");
  return threads;
}

int fail(ExitCode code, const std::string& message) {
  std::fflush(stdout);
  std::fprintf(stderr, "%s\n", message.c_str());
  return static_cast<int>(code);
}

// What went to stdout has arrived, else the result is lost: a full disk must not look like success.
int flush_results(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  return fail(ExitCode::kCache, "meshmser: standard output cannot be written");
}

int run(const ParsedCommand& command) {
  const CommandArguments arguments = arguments_of(command);
  Execution execution;
  execution.threads = threads_of(arguments);
  execution.cancelled = &watch_for_interruption();
  const std::vector<std::string>* cache = arguments.find("--cache");
  PipelineHost host(execution, cache == nullptr ? "" : cache->front());
  return flush_results(command.definition.run(arguments, host));
}

// The first word, where it is no option and no command is called so.
void check_command_name(const std::vector<std::string>& words, const std::vector<ParsedCommand>& commands) {
  if (words.empty() || words.front().starts_with("-")) return;
  std::vector<std::string> names;
  for (const ParsedCommand& command : commands) names.push_back(command.definition.name);
  if (std::find(names.begin(), names.end(), words.front()) != names.end()) return;
  const std::string nearest = nearest_name(words.front(), names);
  throw UsageError(
      "unknown command '" + words.front() + "'" +
      (nearest.empty() ? "; commands are " + CLI::detail::join(names, ", ") : ", did you mean '" + nearest + "'?"));
}

const ParsedCommand* named_command(const std::vector<std::string>& words, const std::vector<ParsedCommand>& commands) {
  for (const ParsedCommand& command : commands)
    if (!words.empty() && command.definition.name == words.front()) return &command;
  return nullptr;
}

// The first option that the command does not have, with the nearest that it has.
void check_option_names(const std::vector<std::string>& words, const ParsedCommand& command) {
  std::vector<std::string> names = {"--help", "-h"};
  for (const CommandOption& option : command.definition.options)
    for (const std::string& name : CLI::detail::split(option.name, ','))
      if (name.front() == '-') names.push_back(name);
  for (const std::string& word : words) {
    if (word == "--") return;
    const std::string name = word.substr(0, word.find('='));
    if (!name.starts_with("--") || std::find(names.begin(), names.end(), name) != names.end()) continue;
    const std::string nearest = nearest_name(name, names);
    throw UsageError(command.definition.name + ": unknown option '" + name + "'" +
                     (nearest.empty() ? "; 'meshmser " + command.definition.name + " --help' lists them"
                                      : ", did you mean '" + nearest + "'?"));
  }
}

// An option with an optional value takes the next word unless that is an option or a file's name ('.' or '/'); so
// `run --force demo.yaml` leaves demo.yaml to CONFIG. The parser itself would take it.
std::vector<std::string> join_optional_values(const std::vector<std::string>& words, const ParsedCommand& command) {
  std::vector<std::string> joined;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool optional =
        std::any_of(command.definition.options.begin(), command.definition.options.end(),
                    [&](const CommandOption& o) { return o.optional_value && canonical_name(o.name) == words[i]; });
    if (!optional) {
      joined.push_back(words[i]);
      continue;
    }
    const bool has_value = i + 1 < words.size() && !words[i + 1].empty() && words[i + 1].front() != '-' &&
                           words[i + 1].find_first_of("./") == std::string::npos;
    joined.push_back(words[i] + "=" + (has_value ? words[i + 1] : kNoValue));
    if (has_value) ++i;
  }
  return joined;
}

int parse_and_run(int argc, const char* const* argv) {
  CLI::App program("From a raw scan to its meaningful regions: mesh, level-set tree, closed border lines.", "meshmser");
  program.set_help_flag("--help,-h", "this text");
  program.set_version_flag("--version", "meshmser " MESHMSER_VERSION, "the version");
  program.require_subcommand(0, 1);
  program.footer(
      "Exit codes: 0 ok, 1 internal error, 2 usage, 3 configuration, 4 input unreadable, 5 a stage could not do its "
      "work, 6 cache or disk, 130 interrupted.\nExample: meshmser run configs/demo.yaml");
  std::vector<ParsedCommand> commands;
  for (CommandDefinition& definition : program_commands()) commands.push_back(add_command(program, definition));
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  check_command_name(words, commands);
  if (const ParsedCommand* command = named_command(words, commands)) {
    check_option_names(words, *command);
    words = join_optional_values(words, *command);
  }
  try {
    program.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // the parser takes the last word first
  } catch (const CLI::Success& success) {                                   // help and version
    program.exit(success);
    return flush_results(0);
  } catch (const CLI::ParseError& error) {
    std::string name;
    for (const CLI::App* used : program.get_subcommands()) name = " " + used->get_name();
    throw UsageError(std::string(error.what()) + "; see 'meshmser" + name + " --help'");
  }
  for (const ParsedCommand& command : commands)
    if (command.app->parsed()) return run(command);
  std::fputs(program.help().c_str(), stderr);
  return static_cast<int>(ExitCode::kUsage);
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const Error& error) {
    // Configuration and input errors begin with the file's name, as editors like them.
    const bool located = error.code() == ExitCode::kConfig || error.code() == ExitCode::kInput;
    return fail(error.code(), (located ? "" : "meshmser: ") + std::string(error.what()));
  } catch (const std::bad_alloc&) {
    return fail(ExitCode::kStage, "meshmser: not enough memory");
  } catch (const std::exception& error) {
    return fail(ExitCode::kInternal, "meshmser: internal error: " + std::string(error.what()));
  }
}

}  // namespace meshmser
