// The command line program: declares the commands, parses, runs one, and turns every failure into
// one line on stderr and an exit code (0 success, 1 error, 2 bad usage).
#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <palpate/base/error.h>
#include <palpate/base/similar_name.h>

#include "command.h"
#include "config.h"
#include "output.h"
#include "terminal.h"

namespace palpate::cli {

void declare_common(CLI::App& app, CommonOptions& options, const std::string& json_help) {
  options.app = &app;
  add_flag(app, "-q,--quiet", options.quiet, "print neither progress nor summary");
  if (!json_help.empty()) add_flag(app, "--json", options.json, json_help);
  add_text(app, "--config", options.config, "FILE",
           "TOML file of options; keys are the long option names without dashes");
}

namespace {

constexpr int kExitError = 1;
constexpr int kExitUsage = 2;

int fail(int code, std::string_view message) {
  notify(message);
  return code;
}

/// Joins the lines of a CLI11 message: messages of this program have one line.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

/// Reports a value that CLI11 rejected: an error of the configuration file that it came from, else of usage.
int refuse(const CLI::ParseError& error, const Arguments& arguments) {
  const std::string message = one_line(error.what());
  for (const ConfigEntry& entry : arguments.from_files) {
    if (message.starts_with("--" + entry.key + ":"))
      return fail(kExitError, fmt::format("{}: line {}: {}", entry.file, entry.line, message.substr(2)));
  }
  return fail(kExitUsage, message + " (see --help)");
}

/// The option of `command` that `argument` resembles. Empty if there is none.
std::string option_like(const CLI::App& command, const std::string& argument) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    names.insert(names.end(), option->get_lnames().begin(), option->get_lnames().end());
  const std::string found = similar_option(argument, names);
  return found.empty() ? found : "--" + found;
}

/// Reports arguments that the command does not take.
int refuse_extra(const CLI::App& command, const std::vector<std::string>& extra) {
  std::string message = fmt::format("The following argument{} not expected: {}",
                                    extra.size() > 1 ? "s were" : " was", fmt::join(extra, " "));
  for (const std::string& argument : extra) {
    const std::string meant = option_like(command, argument);
    if (meant.empty()) continue;
    message = fmt::format("The following argument was not expected: {}; did you mean {}?", argument, meant);
    break;
  }
  return fail(kExitUsage, one_line(message) + " (see --help)");
}

int run(const std::vector<std::string>& given) {
  CLI::App app("Haptic rendering of captured 3D Gaussian Splatting scenes.", "palpate");
  app.set_version_flag("--version", program_version());
  app.require_subcommand(1);
  const std::vector<Command> commands{declare_info(app),       declare_setup(app),     declare_query(app),
                                      declare_run(app),        declare_replay(app),    declare_report(app),
                                      declare_make_scene(app), declare_make_path(app), declare_bench(app),
                                      declare_evaluate(app),   declare_stability(app), declare_reproduce(app),
                                      declare_completion(app), declare_columns(app),   declare_man_page(app)};
  if (given.empty()) {
    fmt::print(stderr, "{}", app.help());
    return kExitUsage;
  }
  if (!given.front().starts_with('-') && find_command(app, given.front()) == nullptr) {
    return fail(kExitUsage, fmt::format("'{}' is not a command (see --help)", printable(given.front())));
  }
  const Arguments arguments = with_config(app, given);
  try {
    std::vector<std::string> reversed(arguments.all.rbegin(), arguments.all.rend());
    app.parse(reversed);
  } catch (const CLI::Success& success) {  // --help, --version
    std::ostringstream text;
    app.exit(success, text, text);
    fmt::print("{}", text.str());
    return 0;
  } catch (const CLI::ParseError& error) {
    // A mistyped option may be the one that is missing, and explains more than that it is.
    for (const CLI::App* command : app.get_subcommands()) {
      if (const auto extra = command->remaining(); !extra.empty()) return refuse_extra(*command, extra);
    }
    return refuse(error, arguments);
  }
  for (const Command& command : commands) {
    if (command.app->parsed()) command.run();
  }
  return 0;
}

/// Flushes stdout: buffered output that cannot be written is an error too.
void flush_stdout() {
  if (std::fflush(stdout) != 0) throw std::system_error(errno, std::generic_category());
}

}  // namespace
}  // namespace palpate::cli

int main(int argc, char** argv) {
  using palpate::cli::fail;
  using palpate::cli::kExitError;
  try {
    palpate::cli::open_closed_streams();
    const int code = palpate::cli::run(std::vector<std::string>(argv + 1, argv + argc));
    palpate::cli::flush_stdout();
    return code;
  } catch (const palpate::Error& error) {
    return fail(kExitError, error.what());
  } catch (const std::bad_alloc&) {
    return fail(kExitError, "not enough memory; filter or crop the scene, or free some");
  } catch (const std::system_error& error) {
    return fail(kExitError, fmt::format("standard output: {}", error.code().message()));
  } catch (const std::exception& error) {
    return fail(kExitError, fmt::format("internal error: {}; please report it", error.what()));
  }
}
