#include <palpate/report/result_files.h>

#include <filesystem>

#include <fmt/format.h>

#include <palpate/base/error.h>

namespace palpate {

ResultFile::ResultFile(const std::string& path) : path_(path) {
  if (!path.empty()) file_.emplace(path);
}

void ResultFile::write(const std::string& bytes, std::vector<std::string>& written) {
  if (!file_) return;
  file_->write(bytes);
  file_->commit();
  written.push_back(path_);
}

void check_figure_folder(const std::string& folder) {
  if (!folder.empty() && !std::filesystem::is_directory(folder))
    throw Error("--svg {}: is not a folder", folder);
}

void write_figures(const std::vector<Plot>& figures, const std::string& folder, const std::string& command,
                   std::vector<std::string>& written) {
  if (folder.empty()) return;
  for (const Plot& plot : figures) {
    const auto path = std::filesystem::path(folder) / fmt::format("{}-{}.svg", command, plot.name);
    write_file(path.string(), plot_document(plot));
    written.push_back(path.string());
  }
}

}  // namespace palpate
