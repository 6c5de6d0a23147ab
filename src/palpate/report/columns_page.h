/// \file
/// Generator of the page docs/columns.md.
#pragma once

#include <string>

namespace palpate {

/// Returns a Markdown page of all CSV columns and `--json` fields that commands write.
std::string columns_page();

}  // namespace palpate
