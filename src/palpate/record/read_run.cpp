// Reading of runs. A day at 1 kHz is 86 million rows in 50 GB, of which often just a minute is wanted.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <palpate/base/csv.h>
#include <palpate/base/error.h>
#include <palpate/record/run_columns.h>
#include <palpate/record/run_log.h>

namespace palpate {
namespace {

constexpr std::uint64_t kBlock = std::uint64_t{1} << 16;  // shorter ranges are not bisected. Unit: [bytes].

constexpr std::size_t kSample = 1000;  // number of rows from which the length of a row is estimated

/// A column of a run, and its index in the file.
struct Source {
  RunColumn column;
  std::size_t index;
};

/// Returns the groups of which the file has a column.
RunGroups groups_of(const CsvHeader& header) {
  RunGroups groups;
  for (const RunColumn& column : run_columns()) {
    if (!header.has(column.name)) continue;
    groups.user_force |= column.group == ColumnGroup::kUserForce;
    groups.live |= column.group == ColumnGroup::kLive;
  }
  return groups;
}

class RunReader {
 public:
  explicit RunReader(const std::string& path) : csv_(path, CsvReader::LastLine::kMaybeCut) {
    take_run_words(csv_);
    ignore_unknown();
    next();  // reports a file that is not a table by its first row rather than by a missing column
    const RunGroups groups = groups_of(csv_.header());
    live_ = groups.live;
    for (const RunColumn& column : run_columns(groups)) {
      if (column.may_lack && !csv_.header().has(column.name)) continue;
      sources_.push_back({column, csv_.header().column(column.name)});
    }
    drop_if_cut();
  }

  Run read(const RunWindow& window, const Progress& progress);

 private:
  using Values = std::optional<std::span<const double>>;

  double time() const { return (*values_)[sources_.front().index]; }
  void next() {
    values_ = csv_.next();
    drop_if_cut();
  }
  void drop_if_cut();
  void ignore_unknown();
  void find(double from);
  RunRow row() const;
  void make_room(std::vector<RunRow>& rows, std::uint64_t start, std::size_t most) const;
  [[noreturn]] void refuse_many(const RunWindow& window, double first);
  [[noreturn]] void refuse_none(const RunWindow& window, std::optional<double> before) const;

  CsvReader csv_;
  std::vector<Source> sources_;
  bool live_ = false;
  bool cut_ = false;
  Values values_;  ///< next row; empty at the end
};

/// Drops a truncated last row. A recording is written in whole lines, so that a line without a terminator is
/// truncated even if the rest of its last number is a number.
void RunReader::drop_if_cut() {
  cut_ = csv_.cut() || (values_ && live_ && !csv_.terminated());
  if (cut_) values_.reset();
}

/// Ignores the columns that no run has.
void RunReader::ignore_unknown() {
  std::vector<std::string_view> known;
  for (const RunColumn& column : run_columns()) known.push_back(column.name);
  csv_.ignore_all_but(known);
}

/// Moves by bisection to a row shortly before the first one at `from` or later. \pre the next row is before
/// `from`
void RunReader::find(double from) {
  std::uint64_t low = csv_.row_start();  // start of a row before `from`
  std::uint64_t high = csv_.size();      // no row that begins after this is before `from`
  while (low + kBlock < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    csv_.seek(middle);
    next();
    if (values_ && time() < from) {
      low = csv_.row_start();
    } else {
      high = middle;
    }
  }
  csv_.seek(low - 1);  // terminator of the previous line
  next();
}

RunRow RunReader::row() const {
  RunRow made;
  for (const auto& [column, index] : sources_) {
    const double value = (*values_)[index];
    if (!column.takes(value)) {
      throw Error("{}: {}: column '{}': {} is not {}; it must be a whole number from 0 to {}",
                  csv_.header().source, csv_.where(), column.name, value, column.whole_number, column.most);
    }
    column.set(made, value);
  }
  return made;
}

/// Reserves memory for the rest of the file, estimated from `rows`, which begin at byte `start`: growing
/// stepwise takes twice the memory.
void RunReader::make_room(std::vector<RunRow>& rows, std::uint64_t start, std::size_t most) const {
  const std::uint64_t row_bytes = (csv_.row_start() - start) / rows.size();
  rows.reserve(std::min<std::uint64_t>(most, (csv_.size() - start) / row_bytes + 1));
}

Run RunReader::read(const RunWindow& window, const Progress& progress) {
  constexpr std::size_t kRowsPerReport = 1 << 16;
  Run run{csv_.header().source, {}, csv_.header().comment, false};
  if (values_ && time() < window.from) find(window.from);
  std::optional<double> before;
  for (; values_ && time() < window.from; next()) before = time();
  const std::uint64_t start = csv_.row_start();
  for (; values_ && time() <= window.to; next()) {
    if (!run.rows.empty() && !(time() > run.rows.back().t)) {
      throw Error("{}: {}: column 't': {} does not follow {}; rows must be in order of time", run.source,
                  csv_.where(), time(), run.rows.back().t);
    }
    if (run.rows.size() == window.most_rows) refuse_many(window, run.rows.front().t);
    if (run.rows.size() == kSample && std::isinf(window.to)) make_room(run.rows, start, window.most_rows);
    run.rows.push_back(row());
    if (run.rows.size() % kRowsPerReport == 0) {
      report(progress, "reading", static_cast<double>(csv_.row_start()) / static_cast<double>(csv_.size()));
    }
  }
  if (run.rows.empty()) refuse_none(window, before);
  run.cut = cut_;
  return run;
}

/// \param first time of the first row in the window
void RunReader::refuse_many(const RunWindow& window, double first) {
  double last = time();
  csv_.seek(std::max(csv_.row_start(), csv_.size() - std::min(csv_.size(), kBlock)));
  for (next(); values_; next()) last = time();
  throw Error("{}: more than {} rows, from {} s to {} s; choose a part with --from and --to",
              csv_.header().source, window.most_rows, first, std::min(last, window.to));
}

/// \param before time of the last row before the window
void RunReader::refuse_none(const RunWindow& window, std::optional<double> before) const {
  const std::string& source = csv_.header().source;
  if (!before && !values_) throw Error("{}: has no rows; replay or record one first", source);
  const std::string part = std::isinf(window.from) ? fmt::format("up to {} s", window.to)
                           : std::isinf(window.to) ? fmt::format("from {} s on", window.from)
                                                   : fmt::format("from {} s to {} s", window.from, window.to);
  const std::string nearest = !values_  ? fmt::format("the last is at {} s", *before)
                              : !before ? fmt::format("the first is at {} s", time())
                                        : fmt::format("the nearest are at {} s and {} s", *before, time());
  throw Error("{}: no rows {}; {}", source, part, nearest);
}

}  // namespace

Run read_run(const std::string& path, const RunWindow& window, const Progress& progress) {
  return RunReader(path).read(window, progress);
}

Run read_run(const std::string& path, const Progress& progress) { return read_run(path, {}, progress); }

}  // namespace palpate
