/// \file
/// Self-contained HTML pages of figures and tables.
#pragma once

#include <string>
#include <vector>

#include <palpate/report/plot.h>

namespace palpate {

/// A whole page: `title`, then `intro` in a paragraph (both text), the figures, and `body` (HTML; a table in
/// a div of class 'table' scrolls by itself; cells of class 'text' have lines). \param made how all of it was
/// made, text of many lines at the end of the page \param pairs two figures in a line, where there is room:
/// the one is beside what it is compared with
std::string page_document(const std::string& title, const std::string& intro,
                          const std::vector<Plot>& figures, const std::string& body, const std::string& made,
                          bool pairs = false);

}  // namespace palpate
