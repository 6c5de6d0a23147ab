#include <palpate/report/result_files.h>

#include <filesystem>

#include <fmt/format.h>

#include <palpate/base/error.h>

namespace palpate {

ResultFiles::ResultFiles(const ResultNames& names) : names_(names) {
  if (!names.csv.empty()) csv_.emplace(names.csv);
  if (!names.html.empty()) html_.emplace(names.html);
}

void ResultFiles::write(std::optional<OutputFile>& file, const std::string& name, const std::string& bytes) {
  if (!file) return;
  file->write(bytes);
  file->commit();
  written.push_back(name);
}

void ResultFiles::write_figures(const std::vector<Plot>& figures, const std::string& command) {
  palpate::write_figures(figures, names_.svg, command, written);
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
