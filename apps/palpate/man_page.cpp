// palpate man-page: the manual page, generated from the declared commands.
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <palpate/base/version.h>

#include "command.h"

namespace palpate::cli {
namespace {

/// Escapes text for roff: no escape sequences, no requests, and dashes as ASCII minus signs, to be copied.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool first = out.empty() || out.back() == '\n';
    if (first && (c == '.' || c == '\'')) out += "\\&";
    switch (c) {
      case '\\': out += "\\e"; break;
      case '-': out += "\\-"; break;
      default: out += c;
    }
  }
  return out;
}

/// Allows line breaks after the commas and bars of long lists of choices.
std::string breakable(const std::string& text) {
  std::string out;
  for (const char c : text) {
    out += c;
    if (c == ',' || c == '|') out += "\\:";
  }
  return out;
}

std::string heading(const std::string& group) { return fmt::format(".PP\n\\fI{}\\fR\n", roff(group)); }

/// The --help entry of an option, with its names in bold.
std::string entry(const CLI::Formatter& help, const CLI::Option& option) {
  return fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(help.make_option_name(&option, option.get_positional())),
                     breakable(roff(help.make_option_opts(&option))), roff(help.make_option_desc(&option)));
}

/// The options of a command under the headings of its --help; --help itself is listed once, for all commands.
std::string options_of(const CLI::Formatter& help, const CLI::App& command) {
  std::string text;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) text += entry(help, *option);
  }
  for (const std::string& group : command.get_groups()) {
    std::string entries;
    for (const CLI::Option* option : command.get_options()) {
      if (!option->get_positional() && option->get_group() == group && option != command.get_help_ptr())
        entries += entry(help, *option);
    }
    if (!group.empty() && !entries.empty()) text += heading(group) + entries;
  }
  return text;
}

std::string command_section(const CLI::Formatter& help, const CLI::App& command) {
  const std::string usage = help.make_usage(&command, "palpate " + command.get_name());
  const std::string arguments = usage.substr(usage.find(": ") + 2);  // ends with a line feed
  return fmt::format(".SS\n{}{}.\n{}", roff(arguments), roff(command.get_description()),
                     options_of(help, command));
}

// Text that is not in --help.
constexpr const char* kIntroduction =
    R"(.SH DESCRIPTION
.B palpate
renders captured 3D Gaussian Splatting scenes haptically, without a mesh: every Gaussian is an ellipsoid, the tool is one or more
ellipsoids, and a force model turns the contacts between them into a wrench.
.B palpate run
does so live, by default with a simulated device and hand, and prints the address of the viewer.
The world is right\-handed with z up; units are SI.
)";

constexpr const char* kEnd =
    R"(.SH EXIT STATUS
.TP
.B 0
Success.
.TP
.B 1
An error: one line on standard error says what, where and what to do.
.TP
.B 2
Bad usage.
.SH FILES
.TP
.I SCENE.palpate
The index that the first command on a scene writes beside it.
Later commands read it and start without a delay.
.TP
.IR PREFIX /lib/palpate/palpate_device_NAME.so
A device driver, for
.BR "palpate run \-\-device " \fINAME\fR:\fIARGUMENTS\fR,
where the program is
.IR PREFIX /bin/palpate.
.SH EXAMPLES
.EX
palpate make\-scene torus \-\-out torus.ply
palpate run torus.ply \-\-record session.csv
palpate report session.csv \-\-scene torus.ply \-\-out report.html
.EE
.SH SEE ALSO
.BR palpate_ros1 (1),
.BR palpate_ros2 (1)
)";

std::string man_page(const CLI::App& root) {
  const CLI::Formatter help;
  std::string list, sections;
  for (const CLI::App* command :
       root.get_subcommands([](const CLI::App* app) { return !app->get_group().empty(); })) {
    list += fmt::format(".TP\n.B {}\n{}\n", roff(command->get_name()), roff(command->get_description()));
    sections += command_section(help, *command);
  }
  std::string purpose = root.get_description();  // "Haptic ... scenes."
  purpose.front() = 'h';
  purpose.pop_back();
  std::string options;
  for (const CLI::Option* option : root.get_options()) options += entry(help, *option);
  return fmt::format(
      ".\\\" printed by palpate man-page\n"
      ".TH PALPATE 1 \"\" \"palpate {}\" \"User Commands\"\n"
      ".ad l\n.nh\n"
      ".SH NAME\npalpate \\- {}\n"
      ".SH SYNOPSIS\n.B palpate\n.I COMMAND\n.RI [ OPTION ]...\n.br\n.B palpate\n.I COMMAND\n.B \\-\\-help\n"
      "{}.PP\nCommands:\n.PD 0\n{}.PD\n.SH OPTIONS\n{}.SH COMMANDS\n{}{}",
      version(), roff(purpose), kIntroduction, list, options, sections, kEnd);
}

}  // namespace

Command declare_man_page(CLI::App& parent) {
  CLI::App& app = add_hidden_command(parent, "man-page", "The manual page in man(1) format");
  const CLI::App* root = &parent;
  return {&app, [root] { fmt::print("{}", man_page(*root)); }};
}

}  // namespace palpate::cli
