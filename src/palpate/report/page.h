/// \file
/// Self-contained HTML pages of figures and tables.
#pragma once

#include <string>
#include <vector>

#include <palpate/report/plot.h>

namespace palpate {

/// Returns an HTML page: `title`, `intro` as a paragraph (both plain text), the figures, and `body` (HTML; a
/// table in a div of class 'table' scrolls separately from the page; cells of class 'text' wrap). \param made
/// provenance, text of many lines at the end of the page \param pairs places two figures side by side where
/// there is room, for comparison
std::string page_document(const std::string& title, const std::string& intro,
                          const std::vector<Plot>& figures, const std::string& body, const std::string& made,
                          bool pairs = false);

}  // namespace palpate
