/// \file
/// Output files of long measurements.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/report/plot.h>

namespace palpate {

/// Where the results of a measurement are written to. Empty: nowhere.
struct ResultNames {
  std::string csv, html;  ///< files
  std::string svg;        ///< existing folder for figures
};

/// \throws Error if `folder`, the value of --svg, is neither empty nor a folder.
void check_figure_folder(const std::string& folder);

/// Output files of a long measurement, opened before it so that errors show early, and written after it.
class ResultFiles {
 public:
  /// \throws Error if a file cannot be written.
  explicit ResultFiles(const ResultNames& names);

  /// \name Results, in any order; nothing is written where there is no name. \throws Error.
  /// @{
  void write_csv(const std::string& text) { write(csv_, names_.csv, text); }
  void write_html(const std::string& page) { write(html_, names_.html, page); }
  /// Writes every figure as FOLDER/COMMAND-NAME.svg.
  void write_figures(const std::vector<Plot>& figures, const std::string& command);
  /// @}

  bool has_csv() const { return csv_.has_value(); }
  bool has_html() const { return html_.has_value(); }

  /// Files written so far, in that order; the caller may add others.
  std::vector<std::string> written;

 private:
  void write(std::optional<OutputFile>& file, const std::string& name, const std::string& bytes);

  ResultNames names_;
  std::optional<OutputFile> csv_, html_;
};

/// Writes every figure as FOLDER/COMMAND-NAME.svg, and appends the names to `written`; nothing if `folder` is
/// empty. \throws Error.
void write_figures(const std::vector<Plot>& figures, const std::string& folder, const std::string& command,
                   std::vector<std::string>& written);

}  // namespace palpate
