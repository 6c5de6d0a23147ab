/// \file
/// Output files of long measurements.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/report/plot.h>

namespace palpate {

/// An output file, opened before a long computation so that errors show early, and written after it; or none.
class ResultFile {
 public:
  /// \param path empty: none. \throws Error if it cannot be written.
  explicit ResultFile(const std::string& path);

  /// Writes the whole file, and appends its name to `written`. \throws Error.
  void write(const std::string& bytes, std::vector<std::string>& written);

 private:
  std::string path_;
  std::optional<OutputFile> file_;
};

/// \throws Error if `folder`, the value of --svg, is neither empty nor a folder.
void check_figure_folder(const std::string& folder);

/// Writes every figure as FOLDER/COMMAND-NAME.svg, and appends the names to `written`; nothing if `folder` is
/// empty. \throws Error.
void write_figures(const std::vector<Plot>& figures, const std::string& folder, const std::string& command,
                   std::vector<std::string>& written);

}  // namespace palpate
