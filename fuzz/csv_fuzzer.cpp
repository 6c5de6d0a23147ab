// Tables: read_csv(), read_trajectory() and read_run() either throw Error or return valid data; a table can
// be written and read back.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <palpate/base/csv.h>
#include <palpate/base/error.h>
#include <palpate/record/run_log.h>
#include <palpate/record/trajectory.h>

#include "input_file.h"

namespace {

using palpate::fuzz::require;

template <typename Action>
void try_to(Action&& action) {
  try {
    action();
  } catch (const palpate::Error&) {
  }
}

void check_table(const std::string& path, palpate::fuzz::InputFile& other) {
  const palpate::CsvTable table = palpate::read_csv(path);
  require(!table.columns.empty() && table.values.size() == table.rows() * table.columns.size());
  std::string text;
  for (std::size_t k = 0; k < table.columns.size(); ++k) text += (k == 0 ? "" : ",") + table.columns[k];
  text += '\n';
  for (std::size_t row = 0; row < table.rows(); ++row)
    palpate::append_csv_row(
        text, std::span(table.values).subspan(row * table.columns.size(), table.columns.size()));
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
  const palpate::CsvTable again = palpate::read_csv(other.hold(bytes, text.size(), "again.csv"));
  require(again.columns == table.columns && again.values == table.values);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static palpate::fuzz::InputFile file, other;
  const std::string path = file.hold(data, size, "table.csv");
  try_to([&] { check_table(path, other); });
  try_to([&] {
    for (const palpate::TimedPose& p : palpate::read_trajectory(path))
      require(std::isfinite(p.t) && std::abs(p.pose.orientation.norm() - 1.0) < 1e-12);
  });
  try_to([&] {
    const palpate::Run run = palpate::read_run(path);
    for (const palpate::Episode& e : palpate::contact_episodes(run.rows))
      require(e.first <= e.peak && e.peak <= e.last && e.last < run.rows.size());
  });
  try_to([&] {
    for (const palpate::RunRow& row : palpate::read_run(path, {.from = 0.5, .to = 2.0}).rows)
      require(row.t >= 0.5 && row.t <= 2.0);
  });
  return 0;
}
