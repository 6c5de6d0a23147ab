// palpate columns: every column of a CSV and every field of --json, as docs/columns.md has them. Hidden from
// --help: it is for the page, which tests hold against what commands write.
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
