// palpate columns: prints docs/columns.md, which describes every CSV column and every --json field. Hidden
// from --help: only the documentation needs it; tests compare the page with the output of the commands.
#include <fmt/format.h>

#include <palpate/report/columns_page.h>

#include "command.h"

namespace palpate::cli {

Command declare_columns(CLI::App& parent) {
  CLI::App& app =
      add_hidden_command(parent, "columns", "Reference page of all CSV columns and --json fields");
  return {&app, [] { fmt::print("{}", columns_page()); }};
}

}  // namespace palpate::cli
