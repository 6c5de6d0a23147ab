/// \file
/// The page docs/columns.md.
#pragma once

#include <string>

namespace palpate {

/// Every column of a CSV and every field of `--json` that a command writes, in Markdown.
std::string columns_page();

}  // namespace palpate
